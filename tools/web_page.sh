#!/bin/sh
# Drives the page of crates/gobo-web and the npm package in a headless Chromium, and compares their pictures with those of a
# native device. The page is built first unless dist/web is there and WEB_BUILT is set.
set -eu
cd "$(dirname "$0")/.."

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
target=${CARGO_TARGET_DIR:-$PWD/target}/web
(cd "$crate" && CARGO_TARGET_DIR=$target cargo run --quiet --locked --bin samples -- "$folder/samples" 120 75)
python3 -u -m http.server --bind 127.0.0.1 --directory "$folder" 0 >"$folder/port" 2>/dev/null &
server=$!
port=
for _ in 1 2 3 4 5 6 7 8 9 10; do
    port=$(sed -n 's/.* port \([0-9]*\) .*/\1/p' "$folder/port")
    [ -z "$port" ] || break
    sleep 1
done
sh tools/browser.sh "http://127.0.0.1:$port/package.html"
LIMIT=${LIMIT:-1500} sh tools/browser.sh "http://127.0.0.1:$port/page.html"
