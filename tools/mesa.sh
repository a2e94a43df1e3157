#!/bin/sh
# Runs a command with a newer Mesa's lavapipe as the only Vulkan driver:
#   sh tools/mesa.sh cargo test --test root maps::
# The driver comes out of Debian's backports where it is not there yet; it is unpacked below target/ and nothing is
# installed. MESA may name a folder that has usr/lib and usr/share/vulkan/icd.d of another Mesa.
set -eu

say() { printf 'mesa: %s\n' "$*" >&2; }

cache=${CARGO_TARGET_DIR:-target}/mesa
found=${MESA:-$cache}
has_driver() { [ -n "$(find "$found/usr/lib" -name libvulkan_lvp.so 2>/dev/null)" ]; }

# The distribution's own mirror, in a list and with indices of our own: the system's stay as they are.
download() {
    codename=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
    mirror=$(apt-get indextargets --format '$(SITE) $(RELEASE)' 'Created-By: Packages' |
        awk -v release="$codename" '$2 == release { print $1; exit }')
    [ -n "$mirror" ] || return 1
    mkdir -p "$work/lists/partial" "$work/archives/partial" "$work/root"
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror $codename-backports main" >"$work/sources.list"
    set -- -q -o Dir::Etc::sourcelist="$work/sources.list" -o Dir::Etc::sourceparts=- -o Dir::State::lists="$work/lists" \
        -o Dir::Cache="$work" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache=
    apt-get "$@" update || return 1
    # lavapipe, and the one library of which it wants more than the release has.
    for package in mesa-vulkan-drivers libdrm2; do
        (cd "$work" && apt-get "$@" download "$package/$codename-backports") || return 1
    done
    for deb in "$work"/*.deb; do
        dpkg-deb -x "$deb" "$work/root"
    done
}

if ! has_driver; then
    if [ -n "${MESA:-}" ]; then
        say "MESA=$MESA has no usr/lib/**/libvulkan_lvp.so"
        exit 1
    fi
    if ! command -v apt-get >/dev/null 2>&1 || ! command -v dpkg-deb >/dev/null 2>&1; then
        say "set MESA to a folder with a newer Mesa's usr/lib and usr/share/vulkan/icd.d"
        exit 1
    fi
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    say "downloading it (11 MB)"
    if ! download >"$work/log" 2>&1; then
        cat "$work/log" >&2
        say "no backports of Mesa: run apt-get update on Debian, or set MESA"
        exit 1
    fi
    rm -rf "$cache"
    mkdir -p "$(dirname "$cache")"
    mv "$work/root" "$cache"
    rm -rf "$work"
fi

found=$(cd "$found" && pwd)
library=$(find "$found/usr/lib" -name libvulkan_lvp.so | head -n 1)
# The manifest of the package names its library without a folder.
VK_DRIVER_FILES=$(find "$found/usr/share/vulkan/icd.d" -name 'lvp_icd*.json' | head -n 1)
VK_ICD_FILENAMES=$VK_DRIVER_FILES # what older loaders read
LD_LIBRARY_PATH=$(dirname "$library")${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
# A cache of its own: another Mesa's kernels are no use.
MESA_SHADER_CACHE_DIR=${MESA_SHADER_CACHE_DIR:-$found/shaders}
export VK_DRIVER_FILES VK_ICD_FILENAMES LD_LIBRARY_PATH MESA_SHADER_CACHE_DIR
say "$VK_DRIVER_FILES"
exec "$@"
