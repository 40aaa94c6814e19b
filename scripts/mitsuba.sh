#!/bin/sh
# Measures Mitsuba's path tracer on the results of `solve` given as arguments, in a Python
# environment of its own. Its fast variant needs LLVM 17 or later as a shared library: older ones
# end in "Cannot select: fminimum".
set -eu
. "$(dirname "$0")/root.sh"
venv=target/peers/venv

skip() {
    echo "Mitsuba: skipped, $1" >&2
    exit 0
}

newest_llvm() {
    for file in /usr/lib/libLLVM* /usr/lib64/libLLVM* /usr/lib/*/libLLVM* /usr/lib/llvm-*/lib/libLLVM*; do
        [ -e "$file" ] && echo "$file" | sed -n 's/.*libLLVM\(-\|\.so\.\)\([0-9][0-9]\).*/\2 &/p'
    done | sort -n | tail -1
}

is_new() {
    [ "$(newest_llvm | cut -d' ' -f1)" -ge 17 ] 2>/dev/null
}

command -v python3 >/dev/null || skip "no python3"
if [ -z "${DRJIT_LIBLLVM_PATH:-}" ]; then
    if ! is_new && command -v apt-get >/dev/null; then
        echo "Installing libllvm19 by the package manager." >&2
        (as_root apt-get update -qq &&
            as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends libllvm19) || true
    fi
    is_new || skip "no libLLVM of 17 or later (name one in DRJIT_LIBLLVM_PATH)"
    DRJIT_LIBLLVM_PATH=$(newest_llvm | cut -d' ' -f2)
    export DRJIT_LIBLLVM_PATH
fi
if ! cmp -s peers/mitsuba/requirements.txt "$venv/requirements.txt"; then
    { python3 -m venv "$venv" && "$venv/bin/pip" install -q -r peers/mitsuba/requirements.txt; } ||
        skip "its packages could not be installed"
    cp peers/mitsuba/requirements.txt "$venv/"
fi
# Its compiled kernels are kept in the home directory.
HOME=$PWD/target/peers exec "$venv/bin/python" peers/mitsuba/measure.py "$@"
