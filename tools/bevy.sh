#!/bin/sh
# Builds bevy_gobo (examples/bevy) with the toolchain that Bevy needs (rustup fetches it), renders 40 frames of its example
# without a window and writes target/bevy/bevy.png. Fails if the picture is flat or grey. The first build takes minutes:
# it has about 300 crates. GOBO_BEVY_TOOLCHAIN names another toolchain, even one that Bevy says is too old.
set -eu

target=${CARGO_TARGET_DIR:-$PWD/target}/bevy
cd examples/bevy
# The toolchain of rust-toolchain.toml, also where another one is set for the shell.
unset RUSTUP_TOOLCHAIN
if [ -n "${GOBO_BEVY_TOOLCHAIN:-}" ]; then
    export RUSTUP_TOOLCHAIN="$GOBO_BEVY_TOOLCHAIN"
    set -- --ignore-rust-version
fi
CARGO_TARGET_DIR=$target cargo run --quiet "$@" --example smoke -- 40 "$target/bevy.png"
