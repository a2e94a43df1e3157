#!/bin/sh
# Drives the page of crates/gobo-web and the npm package in a headless Chromium, and compares their pictures with those of a
# native device; checks the package's types, and its example with three.js, where npm fetches TypeScript and three.js. The page is
# built first unless dist/web is there and WEB_BUILT is set.
set -eu
cd "$(dirname "$0")/.."

say() { printf 'web-page: %s\n' "$*" >&2; }

[ -n "${WEB_BUILT:-}" ] || sh tools/web.sh
crate=crates/gobo-web
folder=$(mktemp -d)
server=
stop() {
    [ -z "$server" ] || kill "$server" 2>/dev/null || true
    rm -rf "$folder"
}
trap stop EXIT
cp dist/web/* "$folder/"
cp "$crate"/tests/*.html "$folder/"
tar -xzf dist/gobo-shadows-*.tgz -C "$folder"
# Shares what the tests were built of.
target=${CARGO_TARGET_DIR:-$PWD/target}
(cd "$crate" && CARGO_TARGET_DIR=$target cargo run --quiet --locked --bin samples -- "$folder/samples" 120 75)
# Maps by the driver that the browser has.
(cd "$crate" && CARGO_TARGET_DIR=$target sh ../../tools/swiftshader.sh cargo run --quiet --locked --bin samples -- "$folder/samples")
python3 -u -m http.server --bind 127.0.0.1 --directory "$folder" 0 >"$folder/port" 2>/dev/null &
server=$!
port=
for _ in 1 2 3 4 5 6 7 8 9 10; do
    port=$(sed -n 's/.* port \([0-9]*\) .*/\1/p' "$folder/port")
    [ -z "$port" ] || break
    sleep 1
done
sh tools/browser.sh "http://127.0.0.1:$port/package.html"
# What the package's users install beside it.
if command -v npm >/dev/null 2>&1 &&
    npm install --silent --no-audit --no-fund --prefix "$folder" three@0.187.0 @types/three@0.187.0 typescript@7.0.2 "$(ls -d "$PWD"/dist/gobo-shadows-*.tgz)" >&2; then
    cp "$crate"/tests/user.ts "$crate"/tests/tsconfig.json "$folder/"
    (cd "$folder" && node_modules/.bin/tsc)
    say "the package's types are as user.ts uses them"
    cp "$crate"/examples/three.html "$folder/example.html"
    sh tools/browser.sh "http://127.0.0.1:$port/three.html"
else
    say "left out: types and three.js, npm or its registry is missing"
fi
LIMIT=${LIMIT:-1500} sh tools/browser.sh "http://127.0.0.1:$port/page.html"
