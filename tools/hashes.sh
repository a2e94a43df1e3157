#!/bin/sh
# Hashes of the pictures and maps of every scene of data/, on all tiers and the CPU reference: one line for
# each scene, tier and kind. Two builds that agree print the same lines.
# Usage: tools/hashes.sh [GOBO] [SCENE...]. SETS holds further arguments for `gobo render`: builds of different defaults
# are compared with, say, SETS='--set shadow.receiver=nearest'.
set -eu
cd "$(dirname "$0")/.."
gobo=${1:-target/release/gobo}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- data/*.toml
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-/tmp}"
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# One hash for the files of a list, by content and name.
hash_of() { (cd "$out" && xargs sha256sum) | sha256sum | cut -c 1-16; }

for scene in "$@"; do
    name=$(basename "$scene" .toml)
    for tier in native subgroups core cpu; do
        case $tier in
            cpu) backend=cpu ;;
            *) backend=auto ;;
        esac
        rm -rf "$out"/*
        # shellcheck disable=SC2086
        GOBO_TIER=$tier "$gobo" render "$scene" -o "$out" --maps --backend "$backend" ${SETS:-} \
            >"$out/stdout" 2>"$out/stderr" || { cat "$out/stderr" >&2; exit 1; }
        picture=$(cd "$out" && find . -name 'frame_*.png' | sort | hash_of)
        maps=$(cd "$out" && find maps -name '*.npy' | sort | hash_of)
        echo "$name $tier picture $picture"
        echo "$name $tier maps $maps"
    done
done
