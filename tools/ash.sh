#!/bin/sh
# Frames of several kinds run by examples/ash, which has neither wgpu nor gobo, from what `gobo export`
# writes: fails where a bit of a map differs. GOBO may name the program, ASH_TARGET a folder to build in.
set -eu

gobo=${GOBO:-$PWD/target/release/gobo}
crate=examples/ash
target=${ASH_TARGET:-${CARGO_TARGET_DIR:-$PWD/target}/vulkan}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

(cd "$crate" && CARGO_TARGET_DIR=$target cargo build --quiet --release)

check() { # scene, then values that replace its own
    scene=$1
    shift
    printf '%s\n' "ash: $scene $*" >&2
    options=
    for value; do
        options="$options --set $value"
    done
    rm -rf "$folder/frame"
    # shellcheck disable=SC2086 # a list of words
    "$gobo" export --target spirv -o "$folder" --scene "$crate/scenes/$scene.toml" $options >/dev/null
    "$target/release/gobo-ash" "$folder" >"$folder/log" || {
        cat "$folder/log" >&2
        exit 1
    }
    tail -n 1 "$folder/log"
}

check five shadow.receiver=nearest
check five shadow.receiver=nearest shadow.pair_budget=64
check five shadow.receiver=nearest material.disc.transfer=gain
check five shadow.receiver=nearest material.disc.transfer=over
for nodes in 4 8 16; do
    check five shadow.receiver=curve shadow.nodes=$nodes
done
check five shadow.receiver=curve shadow.nodes=4 material.quad.transfer=gain
check discs shadow.receiver=nearest
check discs shadow.receiver=curve
echo "ash: all maps are the same, bit for bit"
