#!/bin/sh
# Renders by Open Job Description, by HyperQueue and as a Slurm array on this machine, with shards that are killed; fails
# unless all end in the files of one `gobo render`, and unless lost, damaged and foreign frames are noticed.
set -eu

gobo=$(realpath "${GOBO:-target/release/gobo}")
venv=${VENV:-target/farm}
here=$(dirname "$(realpath "$0")")
dust=$(realpath data/dust.toml)
small='camera.size=[48,32]'

if [ ! -x "$venv/bin/openjd" ]; then
	python3 -m venv "$venv"
	"$venv/bin/pip" install --quiet openjd-cli==0.8.0 hyperqueue==0.27.0
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

say() { printf 'farm: %s\n' "$*"; }
fail() {
	say "$*" >&2
	exit 1
}
files() { (cd "$1" && find . -name '*.png' -o -name '*.npy' | sort | xargs sha256sum); }
same() { files "$1" | diff "$folder/$2.sums" - || fail "$1 has other files"; }

# A gobo that is killed in the middle of its shard the first time: once the shard has begun, and a frame after.
cat >"$folder/killed" <<END
#!/bin/sh
case \$1 in render) ;; *) exec "$gobo" "\$@" ;; esac
mkdir "$folder/once" 2>/dev/null || exec "$gobo" "\$@"
"$gobo" "\$@" >"$folder/killed.lines" 2>&1 &
while [ ! -s "$folder/killed.lines" ]; do
	kill -0 \$! || exit 2
	sleep 0.02
done
kill -KILL \$!
wait \$! || echo "\$?" >"$folder/killed.status"
kill -KILL \$\$
END
chmod +x "$folder/killed"
was_killed() {
	[ "$(cat "$folder/killed.status" 2>/dev/null)" = 137 ] || fail "$1: no shard was killed"
	rm -r "$folder/once" "$folder/killed.status"
}

by_template() {
	for step in Render Verify; do
		"$venv/bin/openjd" run "$here/gobo.openjd.yaml" --step "$step" --job-param "Out=$folder/template" "$@" \
			>"$folder/log" 2>&1 || { cat "$folder/log" >&2; return 1; }
	done
}

"$venv/bin/openjd" check "$here/gobo.openjd.yaml"

# Without any option the picture is that of the scene, here one that is exposed otherwise than usual and moves. Its model,
# image and environment travel in an archive.
mkdir "$folder/scene"
cp data/gallery/wine* data/gallery/room.hdr "$folder/scene"
sed 's/^size = \[.*/size = [48, 32]/; s/^size = 2048/size = 64/' data/gallery/wine.toml >"$folder/scene/wine.toml"
printf '[[animate]]\ntarget = "camera.eye"\ntimes = [0, 0.1]\nvalues = [[0, 0.3, 1], [0.4, 0.5, 0.8]]\n' \
	>>"$folder/scene/wine.toml"
"$gobo" render "$folder/scene/wine.toml" -o "$folder/wine" --frame 1 >/dev/null
files "$folder/wine" >"$folder/wine.sums"
"$gobo" pack "$folder/scene/wine.toml" -o "$folder/wine.zip" >/dev/null
mv "$folder/scene" "$folder/away"
by_template --job-param "Gobo=$gobo" --job-param "Scene=$folder/wine.zip" --job-param Frames=1..2 --job-param Shards=1
same "$folder/template" wine
say "Open Job Description, from an archive: $("$gobo" verify "$folder/template")"

options="--backend cpu --fps 12 --set $small"
# shellcheck disable=SC2086
"$gobo" render "$dust" -o "$folder/dust" --frames 0..8 $options >/dev/null
files "$folder/dust" >"$folder/dust.sums"

rm -r "$folder/template"
job="Scene=$dust"
dusty() {
	by_template --job-param "Gobo=$1" --job-param "$job" --job-param Frames=0..8 --job-param Shards=3 \
		--job-param Backend=cpu --job-param Fps=12 --job-param "Set=$small"
}
dusty "$folder/killed"
was_killed "Open Job Description"
same "$folder/template" dust
say "Open Job Description, after a killed shard: the same files"

# shellcheck disable=SC2086
"$venv/bin/python" "$here/hyperqueue_job.py" "$folder/killed" "$dust" "$folder/queue" 0..8 3 $options
was_killed HyperQueue
same "$folder/queue" dust
say "HyperQueue, after a killed shard: the same files"

for task in 4 5 6; do
	# shellcheck disable=SC2086
	GOBO=$gobo SLURM_ARRAY_TASK_ID=$task SLURM_ARRAY_TASK_MIN=4 SLURM_ARRAY_TASK_COUNT=3 \
		sh "$here/slurm.sh" "$dust" "$folder/slurm" 0..8 $options >/dev/null
done
"$gobo" verify "$folder/slurm"
same "$folder/slurm" dust
say "a Slurm array: the same files"

rm "$folder/template/frame_0003.png"
printf 'damaged' >"$folder/template/frame_0005.png"
# shellcheck disable=SC2086
"$gobo" render "$dust" -o "$folder/template" --frame 6 --skip-existing $options --set camera.exposure=0.1 >/dev/null
"$gobo" verify "$folder/template" >"$folder/log" 2>&1 && fail "lost, damaged and foreign frames went unnoticed"
for frame in 3 5 6; do
	grep -q "^frame $frame " "$folder/log" || fail "frame $frame went unnoticed"
done
dusty "$gobo"
same "$folder/template" dust
say "after a lost frame, a damaged one and a foreign one: the same files"
