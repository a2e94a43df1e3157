#!/bin/sh
# `gobo view` on a screen without a monitor (Xvfb): its unit tests, and windows that are looked at. Fails where a window's or a
# scene's picture is flat, where a file that breaks closes the window or leaves no error, and where it does not refuse a
# broken scene and an empty one. Writes target/view/view.png and broken.png.
# Needs Debian's xvfb, xauth and libxkbcommon-x11-0. VIEW_SCENE: the scene of the picture.
set -eu
cd "$(dirname "$0")/.."

say() { printf 'view: %s\n' "$*" >&2; }

command -v xvfb-run >/dev/null 2>&1 || {
    say "xvfb-run is missing: apt-get install xvfb xauth libxkbcommon-x11-0"
    exit 1
}
out=target/view
mkdir -p "$out"
cargo test --quiet -p gobo-cli --features view --lib -- view
cargo build --quiet -p gobo-cli --features view
gobo=${CARGO_TARGET_DIR:-target}/debug/gobo

on_screen() {
    # A Wayland session would be taken before the screen that is made here.
    env -u WAYLAND_DISPLAY GALLIVM_PERF=nopt timeout 600 xvfb-run -a -s "-screen 0 1280x800x24" "$gobo" view "$@"
}

on_screen "${VIEW_SCENE:-data/moving.toml}" --beside --time 0.5 --pick 0.5 0.8 --scale 0.5 \
    --screenshot "$out/view.png" --frames 2 --orbit 20
say "$out/view.png"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# A file that breaks while it is shown: the window stays, with the picture and an error.
cp data/glass.toml "$folder/glass.toml"
GOBO_LOG=gobo=info on_screen "$folder/glass.toml" --scale 0.3 --screenshot "$out/broken.png" --frames 2 \
    >"$folder/log" 2>&1 &
window=$!
tries=0
until grep -q "shown" "$folder/log"; do
    tries=$((tries + 1))
    if [ "$tries" -gt 1200 ] || ! kill -0 "$window" 2>/dev/null; then
        cat "$folder/log" >&2
        say "it shows no picture"
        exit 1
    fi
    sleep 0.5
done
printf '[shadow]\nsize = "large"\n' >"$folder/glass.toml"
wait "$window" || {
    cat "$folder/log" >&2
    say "a file that breaks ends it"
    exit 1
}
grep -q "not read: .*glass.toml:2:8" "$folder/log" || {
    cat "$folder/log" >&2
    say "a file that breaks is no error"
    exit 1
}
say "$out/broken.png"

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

# Without a screen it says what is needed.
if message=$(env -u WAYLAND_DISPLAY -u DISPLAY "$gobo" view data/glass.toml 2>&1); then
    say "it opens a window without a screen"
    exit 1
fi
case $message in
    *"no window can be opened"*) ;;
    *)
        say "$message"
        exit 1
        ;;
esac
