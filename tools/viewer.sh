#!/bin/sh
# Opens examples/viewer on a screen without a monitor (Xvfb), turns its camera and looks at what it
# drew: it fails where the window's or the scene's picture is flat, and where it does not refuse a broken
# scene and an empty one. Writes target/viewer/viewer.png.
# Needs Debian's xvfb, xauth and libxkbcommon-x11-0: `apt-get install xvfb xauth libxkbcommon-x11-0`.
set -eu

say() { printf 'viewer: %s\n' "$*" >&2; }

command -v xvfb-run >/dev/null 2>&1 || {
    say "xvfb-run is missing: apt-get install xvfb xauth libxkbcommon-x11-0"
    exit 1
}
target=${CARGO_TARGET_DIR:-$PWD/target}/viewer
(cd examples/viewer && CARGO_TARGET_DIR=$target cargo test --quiet && CARGO_TARGET_DIR=$target cargo build --quiet)

on_screen() {
    # A Wayland session would be taken before the screen that is made here.
    env -u WAYLAND_DISPLAY timeout 300 xvfb-run -a -s "-screen 0 1280x800x24" "$target/debug/gobo-viewer" "$@"
}

on_screen data/smoke.toml --scale 0.5 --screenshot "$target/viewer.png" --frames 3 --orbit 40
say "$target/viewer.png"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# What must be refused: $1 a scene's text, $2 a word of the message.
refused() {
    printf '%s\n' "$1" >"$folder/scene.toml"
    if message=$(on_screen "$folder/scene.toml" --size 640 400 --screenshot "$folder/no.png" 2>&1); then
        say "it takes a scene whose message should have $2"
        exit 1
    fi
    case $message in
        *"$2"*) ;;
        *)
            say "$message"
            say "the message above should have $2"
            exit 1
            ;;
    esac
}
refused '[shadow]
size = "large"' 'scene.toml:2:8'
refused '[environment]
ambient = [0.1, 0.1, 0.1]
background = [0.1, 0.2, 0.3]' 'is flat'
