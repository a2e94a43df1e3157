#!/bin/sh
# What exported kernels need on GPUs, by RADV's compiler without a GPU: tools/gpu_static. Fails where a kernel
# exceeds a limit of limits.toml. Arguments are the program's: --all. GOBO may name the program.
set -eu

say() { printf 'gpu-static: %s\n' "$*" >&2; }

gobo=${GOBO:-$PWD/target/release/gobo}
# That of tools/ash.sh, too: most of both is the bindings of Vulkan.
target=${CARGO_TARGET_DIR:-$PWD/target}/vulkan
if [ "$(uname -s)" != Linux ]; then
    say "Mesa's RADV is for Linux"
    exit 1
fi
if ! ls /usr/share/vulkan/icd.d/radeon_icd*.json >/dev/null 2>&1; then
    if ! command -v apt-get >/dev/null 2>&1; then
        say "install Mesa's Vulkan driver for AMD's GPUs and the Vulkan loader"
        exit 1
    fi
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        as_root=sudo
    fi
    say "installing mesa-vulkan-drivers libvulkan1"
    {
        $as_root apt-get update -qq
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq mesa-vulkan-drivers libvulkan1
    } >&2
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
(cd tools/gpu_static && CARGO_TARGET_DIR=$target cargo test --quiet --release >&2 && CARGO_TARGET_DIR=$target cargo build --quiet --release)
"$gobo" export --target spirv -o "$folder" >/dev/null
"$target/release/gpu-static" "$folder" "$@"
