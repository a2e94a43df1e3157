#!/usr/bin/env python3
"""Where whole commands spend their time: each scene of data/gallery, and five million particles, tiny, as a table.

GOBO: the program; GOBO_OLD: another beside it, of any version; SCENES: names of scenes instead of all; GALLERY: a folder of scenes
instead of data/gallery; SETS: further arguments of GOBO alone, such as what turns off that GOBO_OLD does not know; RUNS: 2 where not
given. Each program renders each scene so often, in turns, by the same receiver, and the run with less CPU time counts: the first compiles kernels that the
driver may keep. Seconds: `cpu` of all cores, which other work on the machine changes little, and of the wall clock. A scene that one
of them cannot read has a `-` in its columns and is in no sum; below the table it says why. Ends with status 1 where GOBO itself cannot.
"""
import json, os, pathlib, resource, subprocess, sys, tempfile, time

PHASES = ["device", "read", "generate", "prepare", "compile", "kernels", "read_back", "write", "other"]
TINY = ["--set", "camera.size=[64,36]", "--set", "camera.samples=1", "--json"]
RUNS = int(os.environ.get("RUNS", 2))
MANY = """
[camera]
eye = [3.2, 2.4, 4.6]
target = [-0.2, 0.75, -0.1]
[shadow]
receiver = "nearest"
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


def run(program, scene, out, sets):
    """Seconds of all cores and of the wall clock, and those of the phases by the program's own lines; or why it cannot."""
    # Versions have different defaults.
    receiver = "nearest" if 'receiver = "nearest"' in scene.read_text() else "curve"
    command = [program, "render", str(scene), "-o", out, "--set", f"shadow.receiver={receiver}", *TINY, *sets]
    started, before = time.monotonic(), cpu()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wall = time.monotonic() - started
    if done.returncode != 0:
        lines = done.stderr.splitlines()
        return f"status {done.returncode}: {lines[0] if lines else 'without a word'}"
    sys.stderr.write(done.stderr)
    spent = dict.fromkeys(PHASES, 0.0)
    for line in done.stdout.splitlines():
        for phase, ms in json.loads(line).get("milliseconds", {}).items():
            spent[phase] += ms / 1e3
    return cpu() - before, wall, spent


def main():
    program, old = os.environ.get("GOBO") or "target/release/gobo", os.environ.get("GOBO_OLD")
    root = pathlib.Path(__file__).resolve().parent.parent
    gallery = pathlib.Path(os.environ.get("GALLERY") or root / "data/gallery")
    scenes = {path.stem: path for path in sorted(gallery.glob("*.toml"))}
    with tempfile.TemporaryDirectory() as folder:
        many = scenes["particles_5m"] = pathlib.Path(folder, "many.toml")
        many.write_text(MANY)
        chosen = os.environ.get("SCENES", "").split()
        chosen = {name: path for name, path in scenes.items() if not chosen or name in chosen}
        head = (["cpu before", "before"] if old else []) + ["cpu", "wall clock", *PHASES]
        print("| scene |", " | ".join(head), "|")
        print("|---|" + "---|" * len(head))
        sums, summed, failed = [0.0] * (4 if old else 2), 0, []
        for name, path in chosen.items():
            sets = os.environ.get("SETS", "").split()
            programs = {"before": (old, [])} if old else {}
            programs["now"] = (program, sets)
            best = {}
            for _ in range(RUNS):
                for which, (path_of, sets) in programs.items():
                    if isinstance(best.get(which), str):
                        continue
                    found = run(path_of, path, folder, sets)
                    if isinstance(found, str):
                        failed.append((name, which, found))
                        best[which] = found
                    else:
                        best[which] = min(best.get(which, found), found, key=lambda it: it[0])
            pairs = [[None, None] if isinstance(it, str) else it[:2] for it in best.values()]
            whole = [seconds for pair in pairs for seconds in pair]
            if None not in whole:
                sums, summed = [sum + more for sum, more in zip(sums, whole)], summed + 1
            spent = [None] * len(PHASES) if isinstance(best["now"], str) else [best["now"][2][phase] for phase in PHASES]
            cells = ["-" if seconds is None else f"{seconds:.2f}" for seconds in [*whole, *spent]]
            print(f"| {name} |", " | ".join(cells), "|", flush=True)
        label = "all" if summed == len(chosen) else f"{summed} of {len(chosen)}"
        print(f"| {label} |", " | ".join(f"{seconds:.2f}" for seconds in sums), "|" * (len(PHASES) + 1))
        for name, which, why in failed:
            print(f"\n{name}, {which}: {why}")
    if any(which == "now" for _, which, _ in failed):
        sys.exit(1)


if __name__ == "__main__":
    main()
