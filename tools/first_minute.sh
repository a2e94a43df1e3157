#!/bin/sh
# Times README's lines of the first minute, each in a fresh clone with nothing built: `sh tools/first_minute.sh rust view python web`,
# or some of them. What cargo and pip have fetched before stays fetched. Needs some 6 GB for a while; close what else runs.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

line() { # a name, then a line of shell that ends with a picture or what shows one
    rm -rf "$folder/clone" "$folder/home"
    git clone --quiet --depth 1 "file://$root" "$folder/clone"
    start=$(date +%s)
    (cd "$folder/clone" && env -u CARGO_TARGET_DIR -u GOBO PATH="$folder/home/bin:$PATH" sh -euc "$2" >"$folder/log" 2>&1) || {
        tail -n 20 "$folder/log" >&2
        printf '%s: failed\n' "$1" >&2
        exit 1
    }
    printf '%s: %s s\n' "$1" "$(($(date +%s) - start))"
}

[ $# -gt 0 ] || set -- rust view python web
for name; do
    case $name in
        rust) line rust "cargo install --quiet --path crates/gobo-cli --root '$folder/home' && gobo render data/smoke.toml && test -s out/frame_0000.png" ;;
        view)
            line view "cargo install --quiet --path crates/gobo-cli --features view --root '$folder/home' &&
                xvfb-run -a gobo view data/smoke.toml --screenshot shot.png && test -s shot.png"
            ;;
        python)
            line python "make python && python3 -m venv '$folder/home' && pip install --quiet dist/*.whl &&
                python -m gobo_shadows render data/smoke.toml && test -s out/frame_0000.png"
            ;;
        web) line web "make web && test -s dist/web/index.html" ;;
        *)
            printf 'rust, view, python or web?\n' >&2
            exit 2
            ;;
    esac
done
