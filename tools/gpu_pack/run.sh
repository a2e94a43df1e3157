#!/bin/sh
# Measures a card: gobo's tests, times by case and kernel, maps and pictures beside lavapipe's. Needs a Vulkan driver and
# coreutils, writes the folder results, and takes at most eight minutes: each part has a time limit, and what was cut is named.
set -u

cd "$(dirname "$0")" || exit 1
PATH=$PWD/bin:$PATH
export GOBO_ROOT=$PWD
: "${XDG_RUNTIME_DIR:=/tmp}"
export XDG_RUNTIME_DIR
rm -rf results
mkdir -p results/maps results/pictures
# Smaller cases, for a driver on the CPU.
small=${GOBO_PACK_SMALL:-}

# part NAME SECONDS COMMAND ..: the seconds, and two to end for each, add up to at most 480 (tests/contract/pack.rs).
part() {
    name=$1 limit=$2
    shift 2
    started=$(date +%s)
    timeout -k 2 "$limit" "$@" >"results/$name.log" 2>&1
    status=$?
    echo "$name $status $(($(date +%s) - started)) $limit" >>results/parts.txt
    echo "$name: exit status $status" >&2
}

cases=10kx6,100kx16,1mx16,1mx6,1mx0.5,1mx16@1
curves=100kx16,1mx16
splats=1mx16
tuned=10kx6,100kx16,1mx16
if [ -n "$small" ]; then
    cases=1kx6,2kx16 curves=2kx16 splats=1kx16 tuned=1kx6
fi

part info 15 gobo info
part cases 70 gobo bench --kernels --case $cases --json results/cases.json
part curves 35 gobo bench --kernels --case $curves --receiver curve --json results/curves.json
part splats 20 gobo bench --kernels --shape gaussian --case $splats --json results/splats.json
part tune 40 gobo bench --tune --case $tuned --runs 9 --json results/tune.json
if [ -e /dev/nvidiactl ] && [ -x bin/rival ]; then
    part cuda 15 rival 10kx6 100kx16 1mx16 1mx6 1mx0.5 1mx16@1
fi
for scene in gallery/fur lamps gallery/market volumes; do
    short=${scene#gallery/} receiver=nearest
    [ "$short" != fur ] || receiver=curve
    part "$short" 12 gobo bench --kernels --scene "data/$scene.toml" --set shadow.receiver=$receiver --json "results/$short.json"
done
part render 80 sh render.sh data results
part maps 10 gpu-pack compare expected/maps results/maps results/maps.json
part pictures 10 gpu-pack compare expected/pictures results/pictures results/pictures.json
part kernels 25 gpu-static kernels --here
# Tests of kernels and pictures, without the slow ones.
set --
while read -r name; do
    set -- "$@" --skip "$name"
done <slow.txt
part suite 66 tests maps:: stages:: picture:: guest:: "$@"

timeout -k 2 10 gpu-pack gather results
