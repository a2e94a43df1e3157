"""Writes what core costs beside native, as JSON: `tools/core_cost.py GOBO CASES FILE`, as `make results` calls it.

A row for each case of `gobo bench`: seconds of CPU time of a frame on each tier. A long and a short run are measured in
turns, and the least of each subtracted: opening a device and compiling kernels do not count, and what else the machine
does counts little."""

import json
import os
import re
import resource
import subprocess
import sys

TURNS = 2
TIERS = ["native", "core"]


def seconds(gobo, case, tier, runs):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [gobo, "bench", "--case", case, "--runs", str(runs)]
    subprocess.run(command, env={**os.environ, "GOBO_TIER": tier}, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def row(gobo, case):
    casters, footprint, opacity = re.fullmatch(r"(\d+[km]?)x([\d.]+)(?:@([\d.]+))?", case).groups()
    count = int(casters.replace("k", "000").replace("m", "000000"))
    lengths = (1, 5) if count > 100_000 else (2, 42)
    times = {tier: ([], []) for tier in TIERS}
    for _ in range(TURNS):
        for tier in TIERS:
            for runs, of in zip(lengths, times[tier]):
                of.append(seconds(gobo, case, tier, runs))
    frames = {
        f"{tier}_cpu_s": round((min(long) - min(short)) / (lengths[1] - lengths[0]), 4)
        for tier, (short, long) in times.items()
    }
    print(case, times, frames, file=sys.stderr, flush=True)
    return {"casters": count, "footprint": float(footprint), "opacity": float(opacity or 0.02), **frames}


def main():
    gobo, cases, path = sys.argv[1:]
    rows = [row(gobo, case) for case in cases.split(",")]
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"rows": rows}, file, indent=2)
        file.write("\n")


main()
