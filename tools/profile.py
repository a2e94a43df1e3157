#!/usr/bin/env python3
"""Where whole commands spend their time: each scene of data/gallery, and five million particles, tiny, as a table.

GOBO: the program; GOBO_OLD: another beside it, of any version; SCENES: names of scenes instead of all. Each program renders
each scene twice, in turns, and the run with less CPU time counts: the first compiles kernels that the driver may keep. Seconds:
`cpu` of all cores, which other work on the machine changes little, and of the wall clock.
"""
import json, os, pathlib, resource, subprocess, sys, tempfile, time

PHASES = ["device", "read", "generate", "prepare", "compile", "kernels", "read_back", "write", "other"]
TINY = ["--set", "camera.size=[64,36]", "--set", "camera.samples=1", "--json"]
RUNS = 2
MANY = """
[camera]
eye = [3.2, 2.4, 4.6]
target = [-0.2, 0.75, -0.1]
[[light]]
kind = "directional"
direction = [-0.65, -1, -0.25]
[[material]]
name = "smoke"
tint = [0.95, 0.55, 0.25, 0.01]
[[particles]]
generate = { kind = "smoke", count = 5000000, seed = 7, height = 2.0, spread = 0.55, radius = 0.02 }
material = "smoke"
"""


def cpu():
    """Seconds of all cores that ended processes have taken."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(program, scene, out):
    """Seconds of all cores and of the wall clock, and those of the phases by the program's own lines."""
    command = [program, "render", str(scene), "-o", out, *TINY]
    started, before = time.monotonic(), cpu()
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    wall = time.monotonic() - started
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: status {done.returncode}")
    spent = dict.fromkeys(PHASES, 0.0)
    for line in done.stdout.splitlines():
        for phase, ms in json.loads(line).get("milliseconds", {}).items():
            spent[phase] += ms / 1e3
    return cpu() - before, wall, spent


def main():
    program, old = os.environ.get("GOBO") or "target/release/gobo", os.environ.get("GOBO_OLD")
    root = pathlib.Path(__file__).resolve().parent.parent
    scenes = {path.stem: path for path in sorted(root.glob("data/gallery/*.toml"))}
    with tempfile.TemporaryDirectory() as folder:
        many = scenes["particles_5m"] = pathlib.Path(folder, "many.toml")
        many.write_text(MANY)
        chosen = os.environ.get("SCENES", "").split()
        chosen = {name: path for name, path in scenes.items() if not chosen or name in chosen}
        head = (["cpu before", "before"] if old else []) + ["cpu", "wall clock", *PHASES]
        print("| scene |", " | ".join(head), "|")
        print("|---|" + "---|" * len(head))
        sums = [0.0] * (4 if old else 2)
        for name, path in chosen.items():
            best = [None, None]
            for _ in range(RUNS):
                for i, which in enumerate([old, program]):
                    if which:
                        found = run(which, path, folder)
                        best[i] = min(best[i] or found, found, key=lambda it: it[0])
            whole = [seconds for it in best if it for seconds in it[:2]]
            sums = [sum + more for sum, more in zip(sums, whole)]
            cells = [f"{seconds:.2f}" for seconds in [*whole, *(best[1][2][phase] for phase in PHASES)]]
            print(f"| {name} |", " | ".join(cells), "|", flush=True)
        print("| all |", " | ".join(f"{seconds:.2f}" for seconds in sums), "|" * (len(PHASES) + 1))


if __name__ == "__main__":
    main()
