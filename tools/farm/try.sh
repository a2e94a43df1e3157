#!/bin/sh
# Renders eight frames by Open Job Description and by HyperQueue on this machine; then loses a frame,
# damages another and kills a run, and fails unless all ends in the same files.
set -eu

gobo=$(realpath "${GOBO:-target/release/gobo}")
scene=$(realpath data/dust.toml)
venv=${VENV:-target/farm}
here=$(dirname "$(realpath "$0")")
small='camera.size=[96,64]'

if [ ! -x "$venv/bin/openjd" ]; then
	python3 -m venv "$venv"
	"$venv/bin/pip" install --quiet openjd-cli==0.8.0 hyperqueue==0.27.0
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

say() { printf 'farm: %s\n' "$*"; }
pictures() { (cd "$1" && sha256sum frame_*.png); }
by_template() {
	for step in Render Verify; do
		"$venv/bin/openjd" run "$here/gobo.openjd.yaml" --step "$step" --job-param "Gobo=$gobo" \
			--job-param "Scene=$scene" --job-param "Out=$folder/template" --job-param Frames=0..8 \
			--job-param Shards=3 --job-param LastShard=2 --job-param "Set=$small" >"$folder/log" 2>&1 ||
			{ cat "$folder/log" >&2; return 1; }
	done
}

"$venv/bin/openjd" check "$here/gobo.openjd.yaml"
by_template
say "Open Job Description: $("$gobo" verify "$folder/template")"

"$venv/bin/python" "$here/hyperqueue_job.py" "$gobo" "$scene" "$folder/queue" 0..8 3 --set "$small"
pictures "$folder/template" >"$folder/expected"
pictures "$folder/queue" | diff "$folder/expected" -
say "HyperQueue: the same files"

rm "$folder/template/frame_0003.png"
printf 'damaged' >"$folder/template/frame_0005.png"
if "$gobo" verify "$folder/template" >"$folder/log" 2>&1; then
	say "a lost and a damaged frame went unnoticed" >&2
	exit 1
fi
"$gobo" render "$scene" -o "$folder/template" --frames 0..8 --skip-existing --set "$small" \
	>/dev/null 2>&1 &
sleep 1
kill -KILL $! 2>/dev/null || true
wait $! 2>/dev/null || true
by_template
pictures "$folder/template" | diff "$folder/expected" -
say "after a lost frame, a damaged one and a killed run: the same files"
