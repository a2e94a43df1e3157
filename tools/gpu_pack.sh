#!/bin/sh
# Builds dist/gpu-pack.tar.gz: what measures a card on a machine without Rust, network and sources. There: unpack it and run
# gpu-pack/run.sh, which needs a Vulkan driver, sh and coreutils; tools/gpu_pack/run.sh has its parts.
set -eu

say() { printf 'gpu-pack: %s\n' "$*" >&2; }

target=${CARGO_TARGET_DIR:-$PWD/target}
gobo=${GOBO:-$target/release/gobo}
pack=$target/gpu-pack
# Most that a pack may have [bytes]: 45 MiB.
most=47185920

rm -rf "$pack"
mkdir -p "$pack/bin" "$pack/expected/maps" "$pack/expected/pictures"
for crate in gpu_pack gpu_static; do
    (cd tools/$crate && CARGO_TARGET_DIR=$target/vulkan cargo build --quiet --release)
done
cp "$gobo" "$target/vulkan/release/gpu-pack" "$target/vulkan/release/gpu-static" "$pack/bin/"
tests=$(cargo test --test root --no-run 2>&1 | sed -n 's/.*Executable.*(\(.*\))$/\1/p')
cp "$tests" "$pack/bin/tests"
# The CUDA program that the results are beside, where its compiler can be fetched.
if sh tools/cuda.sh >/dev/null; then
    cp "$target/cuda/rival" "$pack/bin/"
else
    say "without the CUDA rival: its compiler could not be fetched"
fi
strip "$pack"/bin/*
cp -r data tests/slow.txt tools/gpu_pack/run.sh tools/gpu_pack/render.sh "$pack/"
"$gobo" export --target spirv -o "$pack/kernels" >/dev/null
say "maps and pictures of this machine's driver"
made=$(mktemp -d)
trap 'rm -rf "$made"' EXIT
mkdir -p "$made/maps" "$made/pictures"
PATH=$pack/bin:$PATH sh tools/gpu_pack/render.sh data "$made"
cp -r "$made/maps" "$made/pictures" "$pack/expected/"
rm -f "$pack"/expected/maps/*/*.png
mkdir -p dist
tar -C "$target" -c gpu-pack | gzip -9 >dist/gpu-pack.tar.gz
size=$(wc -c <dist/gpu-pack.tar.gz)
say "dist/gpu-pack.tar.gz: $((size / 1048576)) MiB"
if [ "$size" -gt "$most" ]; then
    say "that is more than $((most / 1048576)) MiB"
    exit 1
fi
