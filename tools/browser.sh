#!/bin/sh
# Opens a page in a headless Chromium with WebGPU on SwiftShader and waits until it says on its console
# `web-test: passed` or `web-test: failed`: tools/browser.sh PAGE. CHROMIUM may name the browser; LIMIT
# [s]. PAGE is a file or an address.
set -eu

say() { printf 'web-test: %s\n' "$*" >&2; }

case $1 in
    http*) page=$1 ;;
    *) page=file://$1 ;;
esac
limit=${LIMIT:-900}

browser=${CHROMIUM:-}
if [ -z "$browser" ]; then
    for name in chromium chromium-browser google-chrome; do
        if command -v "$name" >/dev/null 2>&1; then
            browser=$name
            break
        fi
    done
fi
if [ -z "$browser" ]; then
    if ! command -v apt-get >/dev/null 2>&1; then
        say "install Chromium, or set CHROMIUM to a browser of its kind"
        exit 1
    fi
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        as_root=sudo
    fi
    say "installing chromium"
    {
        $as_root apt-get update -qq
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium
    } >&2
    browser=chromium
fi

folder=$(mktemp -d)
pid=
stop() {
    if [ -n "$pid" ]; then
        kill -- "-$pid" 2>/dev/null || true
        wait "$pid" 2>/dev/null || true
    fi
    # What a helper of the browser still writes may stay.
    rm -rf "$folder" 2>/dev/null || true
}
trap stop EXIT

log=$folder/log
# In a session of its own: Debian's `chromium` is a script, whose child outlives it.
setsid "$browser" --headless=new --no-sandbox --no-first-run --user-data-dir="$folder/profile" \
    --enable-unsafe-webgpu --use-webgpu-adapter=swiftshader --enable-unsafe-swiftshader \
    --enable-features=Vulkan,VulkanFromANGLE,DefaultANGLEVulkan --use-angle=vulkan \
    --use-vulkan=swiftshader --disable-vulkan-surface --disable-gpu-watchdog \
    --enable-logging=stderr "$page" >"$log" 2>&1 &
pid=$!
waited=0
while ! grep -qE 'web-test: (passed|failed)' "$log"; do
    if ! kill -0 "$pid" 2>/dev/null || [ "$waited" -ge "$limit" ]; then
        tail -n 20 "$log" >&2
        say "failed: the browser ended or took more than $limit s"
        exit 1
    fi
    sleep 1
    waited=$((waited + 1))
done
# [12:34:INFO:CONSOLE:56] "web-test: ...", source: file:///... (56)
sed -n 's/.*"\(web-test: .*\)", source: .*/\1/p' "$log"
grep -q 'web-test: passed' "$log"
