"""Draws docs/curve.svg: the light along one ray through smoke, as it is, and as 8 nodes of a curve keep it.

python3 tools/curve_figure.py target/release/gobo docs/curve.svg

The smoke is a column of soft discs that this script makes; what they let pass it evaluates by the formulas of docs/scene.md, and the
nodes are those that `gobo render --maps` writes.
"""
import array
import json
import math
import random
import struct
import subprocess
import sys
import tempfile

SIZE, TEXEL, NODES = 64, (32, 32), 8
WIDTH, HEIGHT, LEFT, TOP = 760, 300, 46, 14
CHANNELS = ("#d33", "#2a2", "#26d")
SCENE = f"""
[shadow]
size = {SIZE}
receiver = "curve"
nodes = {NODES}
[camera]
size = [16, 16]
samples = 1
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
[[material]]
name = "smoke"
[[particles]]
file = "smoke.csv"
material = "smoke"
"""


def discs():
    """Rows of x, y, z, radius and rgba: amber smoke above blue smoke, and a veil of red glass between them."""
    chance = random.Random(4)
    rows = []
    for color, low, high, count in (((1, 0.55, 0.2), 2.3, 3.9, 26), ((0.25, 0.5, 1), 0.2, 1.5, 30)):
        for _ in range(count):
            place = [chance.gauss(0, 0.16), chance.uniform(low, high), chance.gauss(0, 0.16)]
            rows.append((*place, 0.5, *color, chance.uniform(0.03, 0.12)))
    rows.append((0, 1.9, 0, 0.9, 1, 0.25, 0.2, 0.45))
    return rows


def array_of(path):
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<H", data, 8)[0]
    values = array.array("f")
    values.frombytes(data[10 + length :])
    return values


def solved(rows, right):
    """Solution of three linear equations (Cramer)."""
    def determinant(a):
        return sum(a[0][i] * (a[1][(i + 1) % 3] * a[2][(i + 2) % 3] - a[1][(i + 2) % 3] * a[2][(i + 1) % 3]) for i in range(3))

    whole = determinant(rows)
    return [
        determinant([[right[r] if c == k else rows[r][c] for c in range(3)] for r in range(3)]) / whole for k in range(3)
    ]


def truth(rows, view):
    """Light depth and transmittance of each hit of the ray through the texel, in order."""
    clip = view["clip_from_world"]
    row = lambda r: ([clip[4 * c + r] for c in range(3)], clip[12 + r])
    ndc = ((TEXEL[0] + 0.5) / SIZE * 2 - 1, 1 - (TEXEL[1] + 0.5) / SIZE * 2)
    axes = [row(0), row(1), row(2)]
    point = solved([axis for axis, _ in axes], [ndc[0] - axes[0][1], ndc[1] - axes[1][1], -axes[2][1]])
    hits = []
    for x, y, z, radius, *rgb, alpha in rows:
        square = ((x - point[0]) ** 2 + (z - point[2]) ** 2) / radius**2
        if square < 1:
            opacity = alpha * (1 - square) ** 2
            depth = sum(a * b for a, b in zip(axes[2][0], (x, y, z))) + axes[2][1]
            hits.append((depth, [1 - opacity * (1 - c) for c in rgb]))
    return sorted(hits)


def main(gobo, path):
    rows = discs()
    with tempfile.TemporaryDirectory() as folder:
        with open(f"{folder}/smoke.csv", "w") as file:
            file.write("x,y,z,radius,red,green,blue,alpha\n" + "".join(",".join(map(str, row)) + "\n" for row in rows))
        with open(f"{folder}/scene.toml", "w") as file:
            file.write(SCENE)
        subprocess.run([gobo, "render", f"{folder}/scene.toml", "--maps", "-o", folder], check=True, stdout=subprocess.DEVNULL)
        maps = f"{folder}/maps/frame_0000"
        with open(f"{maps}/views.json") as file:
            view = json.load(file)[0]
        nodes = array_of(f"{maps}/sun.0.curve.npy")
    first = (TEXEL[1] * SIZE + TEXEL[0]) * NODES * 5
    nodes = [nodes[first + 5 * k : first + 5 * k + 5] for k in range(NODES)]
    nodes = [node for node in nodes if node[0] < 2]
    hits = truth(rows, view)
    print(f"{len(hits)} hits, {len(nodes)} nodes")
    x = lambda depth: LEFT + depth * (WIDTH - LEFT - 10)
    y = lambda light: TOP + (1 - light) * (HEIGHT - TOP - 40)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
    ]
    for light in (0, 0.5, 1):
        lines.append(f'<path d="M{LEFT} {y(light):.1f}H{WIDTH - 10}" stroke="#ddd"/>')
        lines.append(f'<text x="{LEFT - 8}" y="{y(light) + 4:.1f}" text-anchor="end" fill="#555">{light}</text>')
    lines.append(f'<text x="{LEFT}" y="{HEIGHT - 8}" fill="#555">light depth</text>')
    worst = 0.0
    for channel, color in enumerate(CHANNELS):
        light, path_of_truth = 1.0, f"M{x(0):.1f} {y(1):.1f}"
        for depth, transmittance in hits:
            path_of_truth += f"H{x(depth):.1f}"
            light *= transmittance[channel]
            path_of_truth += f"V{y(light):.1f}"
        path_of_truth += f"H{x(1):.1f}"
        before, path_of_nodes, dots = 1.0, f"M{x(0):.1f} {y(1):.1f}", []
        for start, end, *rgb in nodes:
            behind = rgb[channel]
            path_of_nodes += f"L{x(start):.1f} {y(before):.1f}L{x(max(end, start)):.1f} {y(behind):.1f}"
            dots.append(f'<circle cx="{x(max(end, start)):.1f}" cy="{y(behind):.1f}" r="3.2"/>')
            before = behind
        path_of_nodes += f"H{x(1):.1f}"
        lines.append(f'<path d="{path_of_truth}" fill="none" stroke="{color}" stroke-opacity="0.35" stroke-width="5"/>')
        lines.append(f'<path d="{path_of_nodes}" fill="none" stroke="{color}" stroke-width="1.4"/>')
        lines.append(f'<g fill="{color}">{"".join(dots)}</g>')
        steps = [i / 4000 for i in range(4001)]
        kept = lambda at: value_at(nodes, channel, at)
        real = lambda at: math.prod(t[channel] for depth, t in hits if depth <= at)
        apart = [abs(kept(at) - real(at)) for at in steps]
        worst = max(worst, sum(apart) / len(apart))
    lines.append(
        f'<text x="{WIDTH - 14}" y="{HEIGHT - 8}" text-anchor="end" fill="#333">wide and pale: the {len(hits)} hits of the ray; '
        f"thin: {len(nodes)} nodes, {8 * NODES} bytes; mean error {worst:.4f} at most</text>"
    )
    with open(path, "w") as file:
        file.write("\n".join(lines) + "\n</svg>\n")


def value_at(nodes, channel, at):
    before = 1.0
    for start, end, *rgb in nodes:
        if at < start:
            return before
        if at < end:
            return before + (rgb[channel] - before) * (at - start) / (end - start)
        before = rgb[channel]
    return before


if __name__ == "__main__":
    main(*sys.argv[1:])
