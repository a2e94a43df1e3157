"""Draws docs/tile.svg: the casters that one tile of a shadow map walks, front to back, and what each leaves of the light.

python3 tools/tile_figure.py target/release/gobo docs/tile.svg

The casters are soft discs that this script makes. Map and view are those that `gobo render --maps` writes. Which tiles a disc touches
and what it lets pass is calculated here by the formulas of docs/scene.md; where gobo's count of pairs, its depths or its filter
differ, the script fails.
"""
import base64
import json
import math
import random
import subprocess
import sys
import tempfile

from curve_figure import array_of

SIZE, TILE = 64, 16  # [texels]
TEXEL = (28, 21)
MAP, LEFT, TOP, ROW = 352, 10, 40, 18  # [units of the drawing]
DEPTHS, LIGHT, LONG, WIDTH = (440, 740), 790, 150, 960
SCENE = f"""
[shadow]
size = {SIZE}
[camera]
size = [16, 16]
samples = 1
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
[[material]]
name = "smoke"
[[material]]
name = "solid"
transfer = "opaque"
[[particles]]
file = "smoke.csv"
material = "smoke"
[[shape]]
kind = "plane"
material = "solid"
scale = [4, 1, 4]
[[shape]]
kind = "plane"
material = "solid"
translation = [0.7, 1.6, 0.7]
scale = [1.8, 1, 1.8]
"""


def discs():
    """Rows of x, y, z, radius and rgba."""
    chance = random.Random(11)
    colors = ((1, 0.5, 0.1), (0.2, 0.5, 1), (0.9, 0.2, 0.5), (0.3, 0.8, 0.3))
    place = lambda: chance.uniform(-1.3, 1.3)
    return [
        (place(), chance.uniform(0.2, 3.4), place(), chance.uniform(0.25, 0.8), *chance.choice(colors), chance.uniform(0.3, 0.85))
        for _ in range(34)
    ]


def projected(row, view):
    """Position and radius of a disc in the map [texels], and its light depth."""
    clip = view["clip_from_world"]
    x, y, depth = (sum(clip[4 * c + r] * row[c] for c in range(3)) + clip[12 + r] for r in range(3))
    scale = math.sqrt(sum(clip[4 * c] ** 2 for c in range(3))) * SIZE / 2
    return (x + 1) / 2 * SIZE, (1 - y) / 2 * SIZE, row[3] * scale, depth


def touches(disc, tile):
    """Whether a disc may reach centres of a tile's texels."""
    gaps = [max(low * TILE + 0.5 - at, 0, at - (low + 1) * TILE + 0.5) for low, at in zip(tile, disc)]
    return math.hypot(*gaps) <= disc[2]


def transmittance(row, disc, texel):
    square = sum((t + 0.5 - at) ** 2 for t, at in zip(texel, disc)) / disc[2] ** 2
    opacity = row[7] * max(1 - square, 0) ** 2
    return [1 - opacity * (1 - c) for c in row[4:7]]


def css(rgb):
    """A linear colour for the screen."""
    return "#" + "".join(f"{round(255 * min(max(c, 0), 1) ** (1 / 2.2)):02x}" for c in rgb)


def text(x, y, words, anchor="start", fill="#333"):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{fill}">{words}</text>'


def rendered(gobo, folder, *more):
    """Counts of a frame, its view, and the folder of its maps."""
    command = [gobo, "render", f"{folder}/scene.toml", "--maps", "--json", "-o", folder, *more]
    counts = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[-1])
    maps = f"{folder}/maps/frame_0000"
    with open(f"{maps}/views.json") as file:
        return counts, json.load(file)[0], maps


def lists_of(rows, view):
    """For each tile the casters that touch it, front to back."""
    casters = sorted(((projected(row, view), row) for row in rows), key=lambda caster: caster[0][3])
    tiles = [(x, y) for y in range(SIZE // TILE) for x in range(SIZE // TILE)]
    return {tile: [caster for caster in casters if touches(caster[0], tile)] for tile in tiles}


def near(found, stated, what):
    if any(abs(a - b) > 2e-3 for a, b in zip(found, stated)):
        sys.exit(f"{what}: gobo has {found}, the formulas {stated}")


def main(gobo, path):
    rows = discs()
    with tempfile.TemporaryDirectory() as folder:
        with open(f"{folder}/smoke.csv", "w") as file:
            file.write("x,y,z,radius,red,green,blue,alpha\n" + "".join(",".join(map(str, row)) + "\n" for row in rows))
        with open(f"{folder}/scene.toml", "w") as file:
            file.write(SCENE)
        counts, view, _ = rendered(gobo, folder, "--set", "material.solid.casts=false")
        pairs = sum(map(len, lists_of(rows, view).values()))
        if counts["pairs"] != pairs:
            sys.exit(f"gobo counts {counts['pairs']} pairs of discs and tiles, the formulas {pairs}")
        _, view, maps = rendered(gobo, folder)
        filters, nearest, opaque = (array_of(f"{maps}/sun.0.{name}.npy") for name in ("filter", "nearest", "opaque"))
        with open(f"{maps}/sun.0.filter.png", "rb") as file:
            picture = base64.b64encode(file.read()).decode()
    tile = tuple(t // TILE for t in TEXEL)
    walked = lists_of(rows, view)[tile]
    texel = TEXEL[1] * SIZE + TEXEL[0]
    end = max(opaque[(tile[1] * TILE + y) * SIZE + tile[0] * TILE + x] for y in range(TILE) for x in range(TILE))

    unit, bottom = MAP / SIZE, TOP + ROW * (len(walked) + 1)
    depth_at = lambda depth: DEPTHS[0] + depth * (DEPTHS[1] - DEPTHS[0])
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {max(bottom, TOP + MAP) + 34}" font-family="sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="#fff"/>',
        f'<image x="{LEFT}" y="{TOP}" width="{MAP}" height="{MAP}" style="image-rendering:pixelated" href="data:image/png;base64,{picture}"/>',
        text(LEFT, TOP - 12, f"filter map of {SIZE} x {SIZE} texels in tiles of {TILE} x {TILE}, and {len(rows)} discs"),
    ]
    corner = [LEFT + tile[0] * TILE * unit, TOP + tile[1] * TILE * unit]
    grid = "".join(f"M{LEFT} {TOP + k * TILE * unit}h{MAP}M{LEFT + k * TILE * unit} {TOP}v{MAP}" for k in range(SIZE // TILE + 1))
    lines.append(f'<path d="{grid}" stroke="#000" stroke-opacity="0.35"/>')
    for row in rows:
        disc = projected(row, view)
        dash = "" if touches(disc, tile) else ' stroke-dasharray="2 4"'
        lines.append(
            f'<circle cx="{LEFT + disc[0] * unit:.1f}" cy="{TOP + disc[1] * unit:.1f}" r="{disc[2] * unit:.1f}" fill="none" '
            f'stroke="{css([c * 0.5 for c in row[4:7]])}"{dash}/>'
        )
    lines.append(f'<rect x="{corner[0]}" y="{corner[1]}" width="{TILE * unit}" height="{TILE * unit}" fill="none" stroke="#000" stroke-width="3"/>')
    lines.append(f'<rect x="{LEFT + TEXEL[0] * unit}" y="{TOP + TEXEL[1] * unit}" width="{unit}" height="{unit}" fill="#fff" stroke="#000" stroke-width="1.5"/>')

    lines.append(text(DEPTHS[0], TOP - 12, "light depth"))
    lines.append(text(LIGHT, TOP - 12, "light left at the white texel"))
    lines.append(f'<path d="M{DEPTHS[0]} {TOP}V{bottom}M{DEPTHS[1]} {TOP}V{bottom}M{LIGHT} {TOP}V{bottom}M{LIGHT + LONG} {TOP}V{bottom}" stroke="#ddd"/>')
    for x, word in ((DEPTHS[0], "0"), (DEPTHS[1], "1"), (LIGHT, "0"), (LIGHT + LONG, "1")):
        lines.append(text(x, bottom + 16, word, "middle", "#777"))
    light, first = [1.0] * 3, None
    wall = f'<path d="M{depth_at(end):.1f} {TOP}V{bottom}" stroke="#333" stroke-width="2"/>'
    lines.append(wall + text(depth_at(end), bottom + 16, "Z", "middle"))
    for number, (disc, row) in enumerate(walked, 1):
        y = TOP + ROW * (number - 0.5)
        behind = disc[3] > end
        passed = transmittance(row, disc, TEXEL)
        hit = passed != [1, 1, 1]
        if hit and not behind:
            light = [l * t for l, t in zip(light, passed)]
            first = disc[3] if first is None else first
        lines.append(text(DEPTHS[0] - 34, y + 4, number, "end", "#aaa" if behind else "#333"))
        swatch = f'cx="{DEPTHS[0] - 20}" cy="{y}" r="6" fill="{css(row[4:7])}" fill-opacity="{row[7]:.2f}" stroke="{css(row[4:7])}"'
        lines.append(f'<circle {swatch}/>')
        solid = hit and not behind
        lines.append(f'<path d="M{DEPTHS[0]} {y}H{depth_at(disc[3]):.1f}" stroke="{css(row[4:7])}" stroke-opacity="{1 if solid else 0.3}"/>')
        lines.append(f'<circle cx="{depth_at(disc[3]):.1f}" cy="{y}" r="4" stroke="{css(row[4:7])}" fill="{css(row[4:7]) if solid else "#fff"}"/>')
        if behind:
            lines.append(text(LIGHT + 4, y + 4, "behind Z: not visited", fill="#aaa"))
            continue
        for k, color in enumerate(("#d33", "#2a2", "#26d")):
            fade = "" if hit else ' fill-opacity="0.3"'
            lines.append(f'<rect x="{LIGHT}" y="{y - 6.5 + 4 * k}" width="{light[k] * LONG:.1f}" height="3.4" fill="{color}"{fade}/>')
    lines.append(f'<path d="M{depth_at(first):.1f} {TOP}V{bottom}" stroke="#999" stroke-dasharray="3 3"/>' + text(depth_at(first), bottom + 16, "D", "middle"))
    near(filters[3 * texel : 3 * texel + 3], light, "F")
    near([nearest[texel], opaque[texel]], [first, end], "D and Z")
    visited = sum(disc[3] <= end for disc, _ in walked)
    print(f"{pairs} pairs; tile {tile}: {len(walked)} casters, {visited} in front of Z; F {light}, D {first}, Z {end}")
    lines.append(text(LEFT, max(bottom, TOP + MAP) + 28, "dashed: discs that the framed tile does not list. Open dots and pale bars: listed, but beside the white texel. Z: a roof over the whole tile"))
    with open(path, "w") as file:
        file.write("\n".join(lines) + "\n</svg>\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
