#!/bin/sh
# Builds the example of examples/web into the folder target/web/page, whose index.html opens in a
# browser with WebGPU.
# Its crate has a lock file of its own; wasm-bindgen's tool must be of the library's version.
set -eu

say() { printf 'web: %s\n' "$*" >&2; }

target=${CARGO_TARGET_DIR:-$PWD/target}/web
page=$target/page
crate=examples/web

rustup target add wasm32-unknown-unknown >/dev/null 2>&1 || true
version=$(sed -n '/^name = "wasm-bindgen"$/{n;s/version = "\(.*\)"/\1/p;}' "$crate/Cargo.lock")
bindgen=${WASM_BINDGEN:-}
if [ -z "$bindgen" ]; then
    bindgen=$target/bin/wasm-bindgen
    if [ "$("$bindgen" --version 2>/dev/null)" != "wasm-bindgen $version" ]; then
        say "building wasm-bindgen $version"
        cargo install --quiet --root "$target" --version "$version" --no-default-features wasm-bindgen-cli
    fi
fi

(cd "$crate" && CARGO_TARGET_DIR=$target cargo build --quiet --release --lib --target wasm32-unknown-unknown)
mkdir -p "$page"
"$bindgen" --target no-modules --no-typescript --out-dir "$page" \
    "$target/wasm32-unknown-unknown/release/gobo_web.wasm"
{
    printf 'const wasm = "'
    base64 "$page/gobo_web_bg.wasm" | tr -d '\n'
    printf '";\n'
} >"$page/gobo_web_wasm.js"
cp "$crate/index.html" "$page/"
say "$page/index.html"
