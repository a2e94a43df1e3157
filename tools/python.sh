#!/bin/sh
# The Python package of crates/gobo-python. `wheel` builds what users install, dist/*.whl; `test` builds quickly, installs
# that into a fresh environment and runs its tests there, away from the sources. Everything else is in target/python.
# maturin, and on Linux zig as a linker for old systems, come from PyPI.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
export CARGO_TARGET_DIR="$root/target"
python=${PYTHON:-python3}
crate=crates/gobo-python
build=target/python/build

say() { printf 'python: %s\n' "$*" >&2; }

# An environment with packages, made once.
environment() {
    folder=$1
    shift
    [ -x "$folder/bin/python" ] || "$python" -m venv "$folder"
    "$folder/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
}

case ${1:-} in
    wheel)
        # Old systems have old C libraries: zig links against those of manylinux_2_28.
        if [ "$(uname)" = Linux ]; then
            environment "$build" 'maturin>=1.9,<2' ziglang
            set -- --zig --compatibility manylinux_2_28
        else
            environment "$build" 'maturin>=1.9,<2'
            set --
        fi
        # What is beside the crate's pyproject.toml goes into the wheel.
        cp LICENSE-APACHE LICENSE-MIT "$crate/"
        PATH="$root/$build/bin:$PATH" "$build/bin/maturin" build --quiet --release --locked \
            -m "$crate/Cargo.toml" --out dist "$@"
        ls dist/*.whl
        ;;
    test)
        cargo fmt --check --manifest-path "$crate/Cargo.toml"
        environment "$build" 'maturin>=1.9,<2'
        wheels=target/python/wheels
        rm -rf "$wheels" target/python/test
        PATH="$root/$build/bin:$PATH" "$build/bin/maturin" build --quiet --profile dev --locked \
            -m "$crate/Cargo.toml" --out "$wheels" --compatibility linux
        environment target/python/test pytest numpy "$wheels"/*.whl
        cd target/python
        exec env GALLIVM_PERF=nopt GOBO_DATA="$root/data" test/bin/python -m pytest --quiet \
            -p no:cacheprovider "$root/$crate/tests"
        ;;
    *)
        say "wheel or test?"
        exit 2
        ;;
esac
