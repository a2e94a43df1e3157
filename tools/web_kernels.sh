#!/bin/sh
# Makes and runs every exported kernel of core, and with subgroups where the browser has them, in a headless
# Chromium, whose WGSL compiler is Tint. Fails where one is refused. GOBO may name the program; tools/browser.sh says what names the browser.
set -eu

gobo=${GOBO:-target/release/gobo}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$gobo" export --target wgsl -o "$folder/kernels" >/dev/null
cp tools/web/kernels.html "$folder/"
{
    printf 'const manifest = '
    cat "$folder/kernels/manifest.json"
    printf ';\nconst sources = {};\n'
    for file in "$folder"/kernels/*.wgsl; do
        printf 'sources["%s"] = `' "$(basename "$file")"
        sed 's/[`\\$]/\\&/g' "$file"
        printf '`;\n'
    done
} >"$folder/manifest.js"
sh tools/browser.sh "$folder/kernels.html"
