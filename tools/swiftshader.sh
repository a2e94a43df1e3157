#!/bin/sh
# Runs a command with SwiftShader as the only Vulkan driver:
#   sh tools/swiftshader.sh cargo test --test root occlude::
# It comes out of Debian's package chromium-common where it is not there yet: two files, nothing is
# installed. SWIFTSHADER may name a folder that has them.
set -eu

say() { printf 'swiftshader: %s\n' "$*" >&2; }

manifest=vk_swiftshader_icd.json
cache=${CARGO_TARGET_DIR:-target}/swiftshader

# A folder that has the manifest and the library.
has_driver() { [ -f "$1/$manifest" ] && [ -f "$1/libvk_swiftshader.so" ]; }

found=
if [ -n "${SWIFTSHADER:-}" ]; then
    found=$SWIFTSHADER
    if ! has_driver "$found"; then
        say "SWIFTSHADER=$found has no $manifest with libvk_swiftshader.so"
        exit 1
    fi
else
    for folder in "$cache" /usr/lib/chromium /usr/lib64/chromium-browser /opt/google/chrome; do
        if has_driver "$folder"; then
            found=$folder
            break
        fi
    done
fi

if [ -z "$found" ]; then
    if ! command -v apt-get >/dev/null 2>&1 || ! command -v dpkg-deb >/dev/null 2>&1; then
        say "install Chromium, or set SWIFTSHADER to the folder of its $manifest"
        exit 1
    fi
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    say "downloading it (32 MB)"
    # Of these packages one has the files, by the release of Debian.
    for package in chromium-common chromium; do
        (cd "$work" && apt-get download -q "$package" >/dev/null 2>&1) || continue
        deb=$(find "$work" -name "${package}_*.deb")
        dpkg-deb --fsys-tarfile "$deb" | tar -x -C "$work" --wildcards '*swiftshader*' 2>/dev/null || true
        has_driver "$work/usr/lib/chromium" && break
    done
    if ! has_driver "$work/usr/lib/chromium"; then
        say "apt-get download gave no SwiftShader: run apt-get update, or set SWIFTSHADER"
        exit 1
    fi
    mkdir -p "$cache"
    # The manifest last: it says that all is there.
    cp "$work/usr/lib/chromium/libvk_swiftshader.so" "$cache/"
    cp "$work/usr/lib/chromium/$manifest" "$cache/"
    rm -rf "$work"
    found=$cache
fi

found=$(cd "$found" && pwd)
VK_DRIVER_FILES=$found/$manifest
VK_ICD_FILENAMES=$VK_DRIVER_FILES # what older loaders read
export VK_DRIVER_FILES VK_ICD_FILENAMES
say "$VK_DRIVER_FILES"
exec "$@"
