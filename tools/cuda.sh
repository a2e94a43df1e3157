#!/bin/sh
# Builds benches/cuda/rival.cu as target/cuda/rival, with the compiler of PyPI's packages: no CUDA need be installed, and no card.
# It runs where an NVIDIA driver of CUDA 13.0 or later is.
set -eu

target=${CARGO_TARGET_DIR:-$PWD/target}/cuda
mkdir -p "$target"
if [ ! -x "$target/python/bin/python" ]; then
    python3 -m venv "$target/python"
fi
"$target/python/bin/python" -m pip install --quiet --disable-pip-version-check \
    'nvidia-cuda-nvcc==13.0.*' 'nvidia-cuda-crt==13.0.*' 'nvidia-nvvm==13.0.*' 'nvidia-cuda-runtime==13.0.*' 'nvidia-cuda-cccl==13.0.*'
root=$("$target/python/bin/python" -c 'import nvidia; print(list(nvidia.__path__)[0])')/cu13
# Cards since 2018, each in its own code: nothing is compiled on the card's machine.
codes=''
for card in 75 80 86 89 90 100 120; do
    codes="$codes -gencode arch=compute_$card,code=sm_$card"
done
# shellcheck disable=SC2086
"$root/bin/nvcc" -O3 -std=c++17 $codes -cudart static -I "$root/include" -I "$root/include/cccl" -L "$root/lib" \
    benches/cuda/rival.cu -o "$target/rival"
echo "$target/rival"
