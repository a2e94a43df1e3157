#!/bin/sh
# Unpacks dist/gpu-pack.tar.gz into an empty folder and runs its small form on this machine's driver with nothing but
# coreutils in the path: what every part needs is in the pack.
set -eu

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
tar -C "$folder" -xzf dist/gpu-pack.tar.gz
mkdir "$folder/path"
for name in cat cp date dirname mkdir mv rm sh sleep timeout; do
    ln -s "$(command -v $name)" "$folder/path/$name"
done
started=$(date +%s)
env -i PATH="$folder/path" HOME="$folder" GOBO_PACK_SMALL=1 GALLIVM_PERF=nopt sh "$folder/gpu-pack/run.sh"
seconds=$(($(date +%s) - started))
ls "$folder/gpu-pack/results"/*.json
printf 'gpu-pack: %s s\n' "$seconds" >&2
[ "$seconds" -le 480 ]
