#!/bin/sh
# Makes sure of what the build and the tests need: cargo, a C++ compiler (the tests' image
# comparison is written in C++), and on Linux the Vulkan loader with at least one driver.
# Installs only what is missing, and only where apt-get is; elsewhere it says what to install.
set -eu

say() { printf 'setup: %s\n' "$*" >&2; }

if ! command -v cargo >/dev/null 2>&1; then
    say "cargo is missing: install Rust from https://rustup.rs, open a new shell and run this again"
    exit 1
fi

# The library that a driver's manifest names, absolute or by name.
has_library() {
    case $1 in
        /*) [ -e "$1" ] ;;
        ./* | ../*) [ -e "$(dirname "$2")/$1" ] ;;
        *) { ldconfig -p 2>/dev/null || /sbin/ldconfig -p; } | grep -qF "$1" ;;
    esac
}

has_driver() {
    if [ -n "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" ]; then
        manifests=$(printf '%s' "${VK_DRIVER_FILES:-$VK_ICD_FILENAMES}" | tr ':' '\n')
    else
        manifests=$(find /usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d /etc/vulkan/icd.d \
            "${XDG_DATA_HOME:-$HOME/.local/share}/vulkan/icd.d" -name '*.json' 2>/dev/null) || true
    fi
    printf '%s\n' "$manifests" | {
        while IFS= read -r manifest; do
            [ -f "$manifest" ] || continue
            library=$(sed -n 's/.*"library_path"[[:space:]]*:[[:space:]]*"\([^"]*\)".*/\1/p' "$manifest")
            if [ -n "$library" ] && has_library "$library" "$manifest"; then
                exit 0
            fi
        done
        exit 1
    }
}

missing=
case $(uname -s) in
    Linux)
        has_library libvulkan.so.1 / || missing="$missing libvulkan1"
        if ! has_driver; then
            if [ -n "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" ]; then
                say "VK_DRIVER_FILES or VK_ICD_FILENAMES names no driver: mend or unset it"
                exit 1
            fi
            missing="$missing mesa-vulkan-drivers"
        fi
        ;;
    *) ;; # Metal and Direct3D 12 come with the system.
esac
command -v c++ >/dev/null 2>&1 || command -v g++ >/dev/null 2>&1 || missing="$missing g++"

[ -n "$missing" ] || exit 0

if [ "$(uname -s)" != Linux ] || ! command -v apt-get >/dev/null 2>&1; then
    say "missing:$missing"
    say "install a C++ compiler, the Vulkan loader and a Vulkan driver (Mesa's lavapipe is enough)"
    say "  Fedora: dnf install gcc-c++ vulkan-loader mesa-vulkan-drivers"
    say "  Arch:   pacman -S gcc vulkan-icd-loader vulkan-swrast"
    say "  macOS:  xcode-select --install"
    exit 1
fi

as_root=
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null 2>&1; then
        say "missing:$missing; as root, run: apt-get install -y$missing"
        exit 1
    fi
    as_root=sudo
fi
say "installing$missing"
# shellcheck disable=SC2086 # lists of words
{
    $as_root apt-get update -qq >&2
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $missing >&2
}
