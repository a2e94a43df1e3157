#!/bin/sh
# Renders a small scene many times and fails where the program grows from frame to frame, as where a
# driver compiles kernels anew in each. FRAMES in all; growth counts from frame FROM; LIMIT [kB].
set -eu

frames=${FRAMES:-2000}
from=${FROM:-300}
limit=${LIMIT:-8192}
gobo=${GOBO:-target/release/gobo}

folder=$(mktemp -d)
pid=
trap 'test -z "$pid" || kill "$pid" 2>/dev/null; rm -rf "$folder"' EXIT
: >"$folder/frames" # the loops below may read it before the program has started
"$gobo" render data/smoke.toml --frames "0..$frames" --set 'camera.size=[64,36]' \
	--set shadow.size=64 --json -o "$folder/out" >"$folder/frames" &
pid=$!

done_count() { wc -l <"$folder/frames"; }
resident() { awk '/^VmRSS/ { print $2 }' "/proc/$pid/status" 2>/dev/null || true; }

while [ "$(done_count)" -lt "$from" ] && kill -0 "$pid" 2>/dev/null; do sleep 0.1; done
first=$(resident)
last=$first
while kill -0 "$pid" 2>/dev/null; do
	seen=$(resident)
	last=${seen:-$last}
	sleep 0.2
done
wait "$pid" && status=0 || status=$?
pid=
if [ "$status" -ne 0 ] || [ "$(done_count)" -ne "$frames" ] || [ -z "$first" ]; then
	echo "soak: $(done_count) of $frames frames, exit status $status" >&2
	exit 1
fi
grown=$((last - first))
echo "soak: $first kB at frame $from, $last kB at frame $frames"
if [ "$grown" -gt "$limit" ]; then
	echo "soak: grown by $grown kB, more than $limit" >&2
	exit 1
fi
