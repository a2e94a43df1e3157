#!/bin/sh
# Files that other programs write, read by gobo, beside numbers of numpy: `make foreign`, or `sh tools/foreign/run.sh volumes points`,
# or some of splats, volumes, points and models. Prints a table, and fails where a row is wrong. The programs come from npm, PyPI
# and Debian into target/foreign: numpy and the libraries of each format, Blender, splat-transform, three.js, Babylon.js; some 2 GB.
set -eu
cd "$(dirname "$0")/../.."
here=$PWD/tools/foreign
mkdir -p target/foreign/files
cp "$here"/*.mjs target/foreign/
if [ ! -d target/foreign/py ]; then
    python3 -m venv target/foreign/py
    target/foreign/py/bin/pip install -q --only-binary :all: 'laspy[lazrs]' 'bpy==5.0.1' pye57 copclib pynrrd nibabel SimpleITK \
        tifffile OpenEXR pypcd4 vtk
fi
if [ ! -d target/foreign/node_modules ]; then
    (cd target/foreign && npm install --no-audit --no-fund --silent @playcanvas/splat-transform @mkkellogg/gaussian-splats-3d three \
        @babylonjs/core @babylonjs/serializers @gltf-transform/core @gltf-transform/extensions)
fi
if ! command -v nanovdb_convert >/dev/null || ! /usr/bin/python3 -c 'import pyopenvdb' 2>/dev/null; then
    echo "foreign: apt-get install libnanovdb-tools python3-openvdb python3-numpy" >&2
    exit 3
fi
failed=0
printf '| bullet | file | program | error | |\n|---|---|---|---|---|\n'
for part in ${*:-splats volumes points models}; do
    target/foreign/py/bin/python "$here/$part.py" || failed=1
done
exit $failed
