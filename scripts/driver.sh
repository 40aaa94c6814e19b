#!/bin/sh
# A Linux machine without a Vulkan driver gets Mesa's software driver from its package manager;
# everywhere else this does nothing.
set -eu

[ "$(uname -s)" = Linux ] || exit 0

has_driver() {
    for folder in /usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d /etc/vulkan/icd.d \
        "${XDG_DATA_HOME:-${HOME:-/nonexistent}/.local/share}/vulkan/icd.d"; do
        for file in "$folder"/*.json; do
            [ -e "$file" ] && return 0
        done
    done
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ]
}

has_loader() {
    ldconfig -p 2>/dev/null | grep -q 'libvulkan\.so\.1' || ls /usr/lib/libvulkan.so.1 >/dev/null 2>&1
}

if has_driver && has_loader; then
    exit 0
fi

. "$(dirname "$0")/root.sh"

echo "No Vulkan driver found: installing Mesa's software driver (lavapipe) by the package manager." >&2
if command -v apt-get >/dev/null; then
    as_root apt-get update -qq
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq mesa-vulkan-drivers libvulkan1
elif command -v dnf >/dev/null; then
    as_root dnf install -y mesa-vulkan-drivers vulkan-loader
elif command -v pacman >/dev/null; then
    as_root pacman -S --noconfirm --needed vulkan-swrast vulkan-icd-loader
elif command -v zypper >/dev/null; then
    as_root zypper --non-interactive install Mesa-libVulkan libvulkan1
elif command -v apk >/dev/null; then
    as_root apk add mesa-vulkan-swrast vulkan-loader
else
    echo "No known package manager: install a Vulkan driver, or solve with --solver cpu." >&2
fi
