#!/bin/sh
# Times README's lines of the first minute as strangers run them: `make first-minute`, or `sh tools/first_minute.sh rust view python
# web`, or some of them. Each has a fresh clone, a home with nothing in it (no fetched crates, no settings), an environment of four
# variables, an empty Python environment or an empty profile of the browser, and ends with a picture that is not flat. Needs Rust
# 1.95 and some 6 GB for a while; view needs Xvfb and web Chromium. NICE=1 leaves other work its cores.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
RUSTUP_HOME=${RUSTUP_HOME:-$HOME/.rustup}
export RUSTUP_HOME
rust=$(rustc --print sysroot)/bin
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

say() { printf '%s\n' "$*"; }

# How this machine reaches its registries, if it says, and where rustup keeps Rust: `make web` adds a target to it.
network=
rustup=$(dirname "$(command -v rustup || echo /usr/bin/rustup)")
for name in RUSTUP_HOME SSL_CERT_FILE PIP_CERT PIP_INDEX_URL NODE_EXTRA_CA_CERTS HTTPS_PROXY https_proxy; do
    value=$(printenv "$name" || true)
    [ -z "$value" ] || network="$network $name=$value"
done

# A name, what is first in PATH, and a line of shell. Prints its time, and the CPU's.
line() {
    start=$(date +%s)
    # shellcheck disable=SC2086 # a list of variables
    (cd "$folder/clone" && env -i HOME="$folder/home" PATH="$2" LANG=C.UTF-8 XDG_RUNTIME_DIR="$folder/run" $network \
        ${NICE:+/usr/bin/nice} /bin/sh -euc "$3
times >'$folder/times'" >"$folder/log" 2>&1) || {
        tail -n 20 "$folder/log" >&2
        say "$1: failed" >&2
        exit 1
    }
    # The second line is of the processes that the shell started: 1m2.34s 0m5.6s.
    cpu=$(sed -n '2p' "$folder/times" | tr 'ms' '  ' | awk '{ printf "%.0f", 60 * $1 + $2 + 60 * $3 + $4 }')
    say "$1: $(($(date +%s) - start)) s, $cpu s of the processors"
}

# Nothing of the line before is left.
fresh() {
    rm -rf "$folder/clone" "$folder/home" "$folder/run"
    mkdir -p "$folder/home" "$folder/run"
    chmod 700 "$folder/run"
    git clone --quiet --depth 1 "file://$root" "$folder/clone"
}

# A flat picture of this size has less than 5 KB.
picture() {
    bytes=$(wc -c <"$folder/clone/$1")
    [ "$bytes" -gt 30000 ] || { say "$1: $bytes bytes, a flat picture" >&2; exit 1; }
    mkdir -p "$root/target/first_minute"
    cp "$folder/clone/$1" "$root/target/first_minute/$2.png"
}

system=$rust:$rustup:/usr/bin:/bin
[ $# -gt 0 ] || set -- rust view python web
for name; do
    fresh
    case $name in
        rust)
            line rust "$folder/home/.cargo/bin:$system" 'cargo install --path crates/gobo-cli && gobo render data/smoke.toml'
            picture out/frame_0000.png rust
            ;;
        view)
            # The window closes by itself: --screenshot.
            line view "$folder/home/.cargo/bin:$system" 'cargo install --path crates/gobo-cli --features view &&
                xvfb-run -a gobo view data/smoke.toml --screenshot shot.png'
            picture shot.png view
            ;;
        python)
            PATH=/usr/bin:/bin python3 -m venv "$folder/home/venv"
            line python "$folder/home/venv/bin:$system" 'make python && pip install dist/*.whl && python -m gobo_shadows render data/smoke.toml'
            picture out/frame_0000.png python
            # The wheel alone, where neither Rust nor a compiler is.
            rm -rf "$folder/clone/out" "$folder/home/venv"
            PATH=/usr/bin:/bin python3 -m venv "$folder/home/venv"
            line "python, from the wheel" "$folder/home/venv/bin" 'pip install dist/*.whl && python -m gobo_shadows render data/smoke.toml'
            picture out/frame_0000.png wheel
            ;;
        web)
            line web "$system" 'make web'
            # The server of the line, and a visitor whose browser has never run.
            line "web, a first visit" "$system" 'cp crates/gobo-web/tests/first.html dist/web/
                python3 -m http.server -d dist/web & server=$!
                trap "kill $server" EXIT
                sleep 1
                sh tools/browser.sh http://localhost:8000/first.html'
            grep '^web-test' "$folder/log"
            ;;
        *)
            say "rust, view, python or web?" >&2
            exit 2
            ;;
    esac
done
