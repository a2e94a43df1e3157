#!/bin/sh
# Renders what packs compare: the maps of three scenes, and ten pictures.
#   sh render.sh DATA OUT
set -eu

data=$1 out=$2
for scene in glass mixed volumes; do
    gobo render "$data/$scene.toml" --set shadow.size=128 --set 'shadow.receiver="curve"' \
        --set 'camera.size=[64,36]' --set camera.samples=1 --maps -o "$out/frames/$scene" >/dev/null
    rm -rf "$out/maps/$scene"
    mv "$out/frames/$scene/maps/frame_0000" "$out/maps/$scene"
done
for scene in glass mixed panes soft_box gaussians cloud gallery/fur gallery/screens gallery/nave gallery/pool; do
    short=${scene#gallery/}
    gobo render "$data/$scene.toml" --set 'camera.size=[240,135]' --set camera.samples=1 \
        -o "$out/pictured/$short" >/dev/null
    mv "$out/pictured/$short/frame_0000.png" "$out/pictures/$short.png"
done
