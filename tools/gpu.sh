#!/bin/sh
# Runs the pack that tools/gpu_pack.sh left in target/gpu-pack on this machine's driver, and copies what it says of the device
# to benches/results/<device>.json. Fails where a part of the pack failed.
set -eu

results=${CARGO_TARGET_DIR:-$PWD/target}/gpu-pack/results
status=0
sh "${results%/*}/run.sh" || status=$?
mkdir -p benches/results
for file in "$results"/*.json; do
    part=${file##*/}
    # The parts' own are in it.
    if ! grep -q "^${part%.json} " "$results/parts.txt"; then
        cp "$file" benches/results/
        echo "benches/results/$part"
    fi
done
exit "$status"
