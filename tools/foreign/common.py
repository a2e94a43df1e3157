"""Files of other programs, read by gobo, beside numbers that numpy computes."""
import json
import os
import pathlib
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = ROOT / "target/foreign"
FILES = HERE / "files"
GOBO = os.environ.get("GOBO", str(ROOT / "target/debug/gobo"))

WRONG = []


def run(*command, **more):
    """What a command prints; its error output where it fails."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **more)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}: {done.returncode}\n{done.stderr}")
    return done.stdout + done.stderr


def gobo(*arguments):
    """What the program prints."""
    return run(GOBO, *arguments)


def info(path):
    """What `gobo info` says of a file, as one text."""
    return gobo("info", path)


def row(bullet, name, program, what, error, limit):
    """A line of the table: the largest error of `what`, which must not be above `limit`."""
    is_right = error <= limit
    if not is_right:
        WRONG.append(f"{name}: {what}")
    verdict = "right" if is_right else "WRONG"
    print(f"| {bullet} | {name} | {program} | {what}: {error:.3g} (at most {limit:.3g}) | {verdict} |", flush=True)


def attempt(bullet, name, program, check):
    """Runs a check, whose failure is a line of the table."""
    start = time.time()
    try:
        check()
    except Exception as error:  # noqa: BLE001: the table goes on
        WRONG.append(f"{name}: {error}")
        print(f"| {bullet} | {name} | {program} | {error!s:.600} | WRONG |", flush=True)
    return time.time() - start


def scene(name, text):
    """A scene file beside the files."""
    path = FILES / f"{name}.toml"
    path.write_text(text)
    return path


def maps(scene_path, light="sun"):
    """The views of a light and their arrays, by the names of `--maps`."""
    import numpy

    out = HERE / "out" / scene_path.stem
    said = gobo("render", scene_path, "--maps", "-o", out, "--set", "camera.size=[32,18]")
    folder = out / "maps/frame_0000"
    views = json.loads((folder / "views.json").read_text())
    found = []
    for view in views:
        if view["light"] == light:
            stem = f"{view['light']}.{view['view']}"
            arrays = {path.name.split(".")[2]: numpy.load(path) for path in folder.glob(f"{stem}.*.npy")}
            found.append((view, arrays))
    return found, said


def texels(view):
    """World-space points of the texels' centres at depth 0, and the unit direction of the light [m]."""
    import numpy

    width, height = view["size"]
    matrix = numpy.linalg.inv(numpy.reshape(view["clip_from_world"], (4, 4)).T)
    x = (numpy.arange(width) + 0.5) / width * 2 - 1
    y = 1 - (numpy.arange(height) + 0.5) / height * 2
    places = numpy.stack(numpy.broadcast_arrays(x[None, :], y[:, None], 0.0, 1.0), -1) @ matrix.T
    points = places[..., :3] / places[..., 3:]
    return points, numpy.array(view["direction"]) / numpy.linalg.norm(view["direction"])


def node(*arguments):
    """What a script of Node prints."""
    return run("node", *arguments, cwd=HERE)


def version(package):
    """The version of an npm package."""
    path = HERE / "node_modules" / package / "package.json"
    return json.loads(path.read_text())["version"]
