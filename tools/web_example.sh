#!/bin/sh
# Draws the example of examples/web in a headless Chromium and on a native device; fails where the
# pictures differ.
set -eu

sh tools/web.sh
page=${CARGO_TARGET_DIR:-$PWD/target}/web/page
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$page"/* "$folder/"
(cd examples/web && CARGO_TARGET_DIR=${page%/page} cargo run --quiet --bin expected 120 75) \
    >"$folder/expected.js"
sh tools/browser.sh "$folder/index.html"
