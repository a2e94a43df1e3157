#!/bin/sh
# Builds the page of crates/gobo-web into dist/web, which any server shows, and the npm package gobo-shadows into dist/npm,
# with its tarball beside it. Its crate has a lock file of its own; wasm-bindgen's tool must be of the library's version.
set -eu
cd "$(dirname "$0")/.."

say() { printf 'web: %s\n' "$*" >&2; }

# Most that is fetched before the scene moves [bytes].
most=6000000
target=${CARGO_TARGET_DIR:-$PWD/target}/web
crate=crates/gobo-web

rustup target add wasm32-unknown-unknown >/dev/null 2>&1 || true
[ -d "$(rustc --print sysroot)/lib/rustlib/wasm32-unknown-unknown" ] || {
    say "Rust for browsers is missing: rustup target add wasm32-unknown-unknown"
    exit 1
}
version=$(sed -n '/^name = "wasm-bindgen"$/{n;s/version = "\(.*\)"/\1/p;}' "$crate/Cargo.lock")
bindgen=${WASM_BINDGEN:-}
if [ -z "$bindgen" ]; then
    bindgen=$target/bin/wasm-bindgen
    if [ "$("$bindgen" --version 2>/dev/null)" != "wasm-bindgen $version" ]; then
        say "building wasm-bindgen $version"
        cargo install --quiet --root "$target" --version "$version" --no-default-features wasm-bindgen-cli
    fi
fi

(cd "$crate" && CARGO_TARGET_DIR=$target cargo build --quiet --release --locked --lib --target wasm32-unknown-unknown)
rm -rf dist/web dist/npm
mkdir -p dist/web dist/npm
"$bindgen" --target web --remove-name-section --remove-producers-section --out-dir dist/npm "$target/wasm32-unknown-unknown/release/gobo_web.wasm"
# Smaller by binaryen, where it is.
if command -v wasm-opt >/dev/null 2>&1; then
    wasm-opt -Os --all-features dist/npm/gobo_web_bg.wasm -o dist/npm/gobo_web_bg.wasm
fi
rm -f dist/npm/gobo_web_bg.wasm.d.ts
cp "$crate"/package/* LICENSE-APACHE LICENSE-MIT dist/npm/
cp "$crate"/page/* docs/gallery/moving.webp dist/npm/gobo_web.js dist/npm/gobo_web_bg.wasm dist/npm/view.js dist/web/

fetched=$(for file in index.html poster.jpg view.js gobo_web.js gobo_web_bg.wasm; do gzip -9 -c "dist/web/$file"; done | wc -c)
say "$fetched bytes are fetched, by gzip, before the scene moves"
[ "$fetched" -le "$most" ] || { say "failed: more than $most"; exit 1; }

# The tarball as `npm pack` makes it: all in a folder `package`.
if command -v npm >/dev/null 2>&1; then
    (cd dist && npm pack --silent ./npm >/dev/null)
else
    package=$(mktemp -d)
    cp -r dist/npm "$package/package"
    number=$(sed -n 's/.*"version": "\(.*\)".*/\1/p' dist/npm/package.json)
    tar -czf "dist/gobo-shadows-$number.tgz" -C "$package" package
    rm -rf "$package"
fi
say "dist/web/index.html, by any server: python3 -m http.server -d dist/web"
