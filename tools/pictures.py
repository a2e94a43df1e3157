"""Makes the pictures of the documents by the commands of docs/pictures.toml, or compares them: `make pictures`.

GOBO=target/release/gobo CHECK=1 ONLY="glass soft" python3 tools/pictures.py

With CHECK nothing is written, and pictures that are not as their commands make them are listed: status 1. ONLY: those whose path has
one of the words. Without CHECK a picture that is as its commands make it stays as it is. What is made is kept in target/pictures/new.
Needs Pillow, and numpy for `beside_rays`.
"""
import base64
import importlib.util
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
import tomllib

from PIL import Image, ImageChops, ImageSequence

ROOT = pathlib.Path(__file__).resolve().parent.parent
NEW = ROOT / "target/pictures/new"
APART = 8  # steps of 255 by which a pixel may be off: another driver rounds differently
MOST = 0.005  # share of pixels that may be further off: edges fall to one side or the other
LOSSY = {".webp": 24}  # of what is stored with losses [steps of 255]


def entries():
    """Each picture's files and what is run for it."""
    table = tomllib.loads((ROOT / "docs/pictures.toml").read_text())
    for entry in table["picture"]:
        for row in entry.get("each", [{}]):
            words = {key: value for key, value in row.items() if key.isupper()}

            def filled(text):
                for key, value in words.items():
                    text = text.replace(key, value)
                return text

            files = [filled(file) for file in entry["files"]]
            yield files, [filled(line) for line in entry["commands"] + entry.get("then", [])], entry.get("needs")


def is_there(need, gobo):
    if need is None:
        return True
    if need == "gobo view":
        said = subprocess.run([gobo, "view", os.devnull], capture_output=True, text=True).stderr
        return bool(shutil.which("xvfb-run")) and "without a window" not in said
    if "/" in need:
        return (ROOT / need).exists()
    return all(importlib.util.find_spec(module) for module in need.split(", "))


def workplace(gobo):
    """A folder in which the commands of the documents work, and write no picture of ours."""
    shutil.rmtree(NEW, ignore_errors=True)
    for folder in ("docs", "crates", "target/release"):
        (NEW / folder).mkdir(parents=True)
    for name in ("data", "tools", "crates/gobo-python"):
        (NEW / name).symlink_to(ROOT / name)
    for path in (ROOT / "docs").rglob("*"):
        here = NEW / path.relative_to(ROOT)
        if path.is_dir():
            here.mkdir()
        elif path.suffix not in (".png", ".webp", ".svg"):
            here.symlink_to(path)
    (NEW / "target/release/gobo").symlink_to(pathlib.Path(gobo).resolve())
    paths = [str(NEW / "target/release"), str(pathlib.Path(sys.executable).parent), os.environ["PATH"]]
    return {**os.environ, "PATH": os.pathsep.join(paths), "XDG_RUNTIME_DIR": os.environ.get("XDG_RUNTIME_DIR", "/tmp")}


def run(lines, environment):
    shutil.rmtree(NEW / "out", ignore_errors=True)
    for line in lines:
        if line.startswith("gobo view"):
            line = f'xvfb-run -a -s "-screen 0 1280x800x24" {line}'
        subprocess.run(["sh", "-euc", line], cwd=NEW, env=environment, check=True, stdout=subprocess.DEVNULL)


def drawing(path):
    """Text of an SVG without its numbers, these, and the pictures in it."""
    text, number, held = path.read_text(), r"-?\d+\.?\d*", r"base64,([^\"]*)"
    pictures = [Image.open(io.BytesIO(base64.b64decode(it))) for it in re.findall(held, text)]
    text = re.sub(held, "", text)
    return re.sub(number, "0", text), [float(it) for it in re.findall(number, text)], pictures


def apart(one, other, limit):
    """Pixels that are further off than `limit`, all pixels, and the largest difference."""
    bands = ImageChops.difference(one.convert("RGB"), other.convert("RGB")).split()
    counts = ImageChops.lighter(ImageChops.lighter(*bands[:2]), bands[2]).histogram()
    return sum(counts[limit + 1 :]), sum(counts), max(step for step, count in enumerate(counts) if count)


def difference(old, new):
    """What is apart, in words; nothing where two pictures are alike."""
    if not old.exists():
        return "is not there"
    if old.suffix == ".svg":
        (text, numbers, pictures), (others, values, more) = drawing(old), drawing(new)
        is_near = text == others and all(abs(a - b) <= 0.5 + 0.01 * abs(a) for a, b in zip(numbers, values))
        is_near = is_near and all(a.size == b.size and not apart(a, b, APART)[0] for a, b in zip(pictures, more))
        return "" if is_near else "other lines"
    with Image.open(old) as a, Image.open(new) as b:
        if a.size != b.size:
            return f"has {a.size[0]} x {a.size[1]} pixels, not {b.size[0]} x {b.size[1]}"
        frames = [[it.convert("RGB") for it in ImageSequence.Iterator(picture)] for picture in (a, b)]
    if len(frames[0]) != len(frames[1]):
        return f"has {len(frames[0])} frames, not {len(frames[1])}"
    limit = LOSSY.get(old.suffix, APART)
    off, total, worst = zip(*(apart(one, other, limit) for one, other in zip(*frames)))
    share, worst = sum(off) / sum(total), max(worst)
    return "" if share <= MOST else f"{100 * share:.1f} % of its pixels are off by more than {limit} of 255, the worst by {worst}"


def main():
    gobo = str(pathlib.Path(os.environ.get("GOBO") or "target/release/gobo").resolve())
    check, only = os.environ.get("CHECK"), os.environ.get("ONLY", "").split()
    environment = workplace(gobo)
    stale, left_out, failed = [], [], []
    for files, lines, need in entries():
        if only and not any(word in file for word in only for file in files):
            continue
        if not is_there(need, gobo):
            left_out += [f"{file}: {need} is not here" for file in files]
            continue
        start = time.monotonic()
        try:
            run(lines, environment)
        except subprocess.CalledProcessError as error:
            failed.append(f"{files[0]}: {error}")
            continue
        for file in files:
            made = NEW / file
            if not made.exists():
                shutil.copyfile(NEW / "out/frame_0000.png", made)
            what = difference(ROOT / file, made)
            print(f"{time.monotonic() - start:7.1f} s  {file}{': ' + what if what else ''}", flush=True)
            if what:
                stale.append(f"{file}: {what}")
                if not check:
                    shutil.copyfile(made, ROOT / file)
    for title, list_ in (("left out", left_out), ("not as its command makes it" if check else "made anew", stale), ("failed", failed)):
        for line in list_:
            print(f"{title}: {line}")
    sys.exit(bool(failed or check and stale))


if __name__ == "__main__":
    main()
