#!/bin/sh
# Compiles the live page's program to target/live.wasm. Installs what that needs: the target by rustup, or where rustup
# does not have it, Debian's compiler with the sources of its library.
set -eu
TARGET=wasm32-unknown-unknown
if rustup target list --installed 2>/dev/null | grep -qx "$TARGET" || rustup target add "$TARGET" >/dev/null 2>&1; then
    cargo build --profile wasm --locked -p radiosity-live --target "$TARGET" --target-dir target/wasm
elif command -v apt-get >/dev/null; then
    if ! [ -x /usr/bin/rust-lld ] || ! [ -d /usr/lib/rustlib/src/rust/library ]; then
        apt-get update -qq
        apt-get install -y -qq rustc-web cargo-web rust-web-src >/dev/null
    fi
    # The linker has the number of the compiler's LLVM in its name.
    linker=$(readlink /usr/bin/rust-lld)
    if ! command -v "wasm-ld-${linker#lld-}" >/dev/null; then
        apt-get install -y -qq "$linker" >/dev/null
    fi
    # Debian has no library for browsers: it is built from its sources.
    RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 \
        CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER="/usr/bin/wasm-ld-${linker#lld-}" \
        /usr/bin/cargo build --profile wasm --locked -p radiosity-live --target "$TARGET" --target-dir target/wasm \
        -Z build-std=std,panic_abort
else
    echo "error: no compiler for $TARGET: run rustup target add $TARGET" >&2
    exit 1
fi
cp "target/wasm/$TARGET/wasm/live.wasm" target/live.wasm
