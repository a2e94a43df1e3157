#!/bin/sh
# Builds examples/bevy with the toolchain that Bevy needs (rustup fetches it), renders 40 frames without a
# window and writes target/bevy/bevy.png. Fails if the picture is flat. The first build takes minutes: it
# has about 300 crates.
set -eu

target=${CARGO_TARGET_DIR:-$PWD/target}/bevy
cd examples/bevy
# The toolchain of rust-toolchain.toml, also where another one is set for the shell.
unset RUSTUP_TOOLCHAIN
CARGO_TARGET_DIR=$target cargo run --quiet -- 40 "$target/bevy.png"
