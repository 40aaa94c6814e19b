# Sourced by the scripts that install packages.

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif command -v sudo >/dev/null; then
        sudo "$@"
    else
        echo "Cannot install as $(id -un) without sudo. As root, run: $*" >&2
        exit 1
    fi
}
