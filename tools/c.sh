#!/bin/sh
# Tests crates/gobo-c, builds its example with the system's C++ compiler and runs it: its maps must be those that `gobo render
# --maps` writes of the same scene, bit for bit. GOBO may name the program.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
export CARGO_TARGET_DIR="$root/target"
crate=crates/gobo-c
gobo=${GOBO:-$root/target/release/gobo}

say() { printf 'c: %s\n' "$*" >&2; }

out=target/c
rm -rf "$out"
mkdir -p "$out"
cargo fmt --check --manifest-path "$crate/Cargo.toml"
cargo test --quiet --locked --manifest-path "$crate/Cargo.toml"
cargo build --quiet --locked --manifest-path "$crate/Cargo.toml"
c++ -std=c++17 -O1 -Wall -Wextra -Werror -I "$crate/include" "$crate/examples/particles.cpp" -o "$out/particles" \
    -L target/debug -lgobo_c -Wl,-rpath,"$root/target/debug"
"$out/particles" "$out"
"$gobo" render "$out/particles.toml" --maps -o "$out/program" >/dev/null

count=0
for array in "$out"/program/maps/frame_0000/*.npy; do
    name=$(basename "$array" .npy)
    size=$(wc -c <"$out/$name")
    # Behind an array's header are the same bytes.
    tail -c "$size" "$array" | cmp - "$out/$name" || {
        say "$name differs from the program's"
        exit 1
    }
    [ $(($(wc -c <"$array") - size)) -lt 256 ] || {
        say "$name is shorter than the program's"
        exit 1
    }
    count=$((count + 1))
done
[ "$count" -ge 8 ] || {
    say "only $count maps"
    exit 1
}
say "$count arrays are the program's, bit for bit; $out/particles.ppm"
