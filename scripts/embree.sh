#!/bin/sh
# Builds peers/embree, installing Embree 3 where the package manager has it (Debian 12).
set -eu
. "$(dirname "$0")/root.sh"

skip() {
    echo "Embree: skipped, $1" >&2
    exit 0
}

has_embree() {
    echo '#include <embree3/rtcore.h>' | cc -E - >/dev/null 2>&1
}

command -v cc >/dev/null || skip "no C compiler"
if ! has_embree && command -v apt-get >/dev/null; then
    echo "Installing libembree-dev by the package manager." >&2
    (as_root apt-get update -qq &&
        as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends libembree-dev) || true
fi
has_embree || skip "embree3/rtcore.h is missing and could not be installed (Debian 12: libembree-dev)"
mkdir -p target/peers
cc -std=gnu11 -O3 -march=native -fopenmp -Wall -Wextra -o target/peers/embree_rays \
    peers/embree/rays.c -lembree3 || skip "it does not build here"
