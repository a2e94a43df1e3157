"""Writes models of a standing person in a long shirt for scenes of data/gallery: one closed surface.

python3 tools/person.py data/gallery/person_white_left.glb

The name chooses the clothes (dark: all of one colour, white, or powdered: white with splashes of colour) and the arms that
are raised (none, left, right or both). Needs numpy.
The body is a signed distance [m], a smooth union of round cones and ellipsoids (Quilez 2008), and its surface the
dual of a grid (surface nets, Gibson 1998) moved onto it along the gradient.
"""
import pathlib
import sys

import numpy as np

from glb import write_glb

CELL = 0.031  # of the grid [m]
MERGE = 0.035  # over which parts join [m]
DARK = [0.15, 0.14, 0.15]
PARTS = {"skin": [0.42, 0.22, 0.13], "hair": [0.02, 0.015, 0.012], "shirt": [0.85, 0.83, 0.79], "trousers": [0.26, 0.3, 0.42],
         "shoe": [0.12, 0.06, 0.03]}
POWDER = [[0.95, 0.06, 0.36], [1, 0.62, 0.03], [0.06, 0.5, 0.14], [0.06, 0.22, 0.85], [0.45, 0.06, 0.7]]
RAISED = {"none": (False, False), "left": (True, False), "right": (False, True), "both": (True, True)}


def ellipsoid(p, center, radii):
    q = (p - np.array(center)) / np.array(radii)
    length = np.linalg.norm(q, axis=-1)
    return length * (length - 1) / np.maximum(np.linalg.norm(q / np.array(radii), axis=-1), 1e-9)


def limb(p, a, b, first, last, flat=1.0):
    """A cone with round ends, its depth `flat` times its width."""
    a, b, p = (np.array(v) * [1, 1, 1 / flat] for v in (a, b, p))
    way = b - a
    t = np.clip((p - a) @ way / (way @ way), 0, 1)[..., None]
    return (np.linalg.norm(p - a - t * way, axis=-1) - first - (last - first) * t[..., 0]) * min(flat, 1)


def join(a, b, width=MERGE):
    part = np.clip(0.5 + 0.5 * (b - a) / width, 0, 1)
    return b + (a - b) * part - width * part * (1 - part)


def parts(p, raised):
    """What each part is, and its distance."""
    found = [
        ("skin", ellipsoid(p, (0, 1.63, 0.012), (0.088, 0.122, 0.106))),
        ("skin", limb(p, (0, 1.44, -0.005), (0, 1.56, 0), 0.058, 0.054)),
        ("shirt", limb(p, (-0.15, 1.405, 0), (0.15, 1.405, 0), 0.06, 0.06)),
        ("shirt", limb(p, (0, 1.3, 0), (0, 1.02, 0), 0.17, 0.145, 0.68)),
        # the shirt, cut off above the knees
        ("shirt", np.maximum(limb(p, (0, 1.05, 0), (0, 0.5, 0), 0.145, 0.225, 0.74), 0.58 - p[..., 1])),
    ]
    for side, up in zip((-1, 1), raised):
        shoulder = (0.175 * side, 1.4, 0)
        elbow = (0.34 * side, 1.6, 0.04) if up else (0.245 * side, 1.13, -0.03)
        hand = (0.4 * side, 1.86, 0.08) if up else (0.26 * side, 0.87, 0.06)
        palm = np.array(hand) + ((0.012 * side, 0.06, 0.01) if up else (0, -0.06, 0.015))
        found += [
            ("shirt", limb(p, shoulder, elbow, 0.064, 0.054)),
            ("skin", limb(p, elbow, hand, 0.053, 0.04)),
            ("skin", ellipsoid(p, palm, (0.04, 0.085, 0.032))),
            ("trousers", limb(p, (0.085 * side, 0.85, 0), (0.1 * side, 0.47, 0.01), 0.1, 0.086)),
            ("trousers", limb(p, (0.1 * side, 0.47, 0.01), (0.105 * side, 0.1, -0.02), 0.086, 0.058)),
            ("shoe", ellipsoid(p, (0.115 * side, 0.035, 0.05), (0.052, 0.045, 0.13))),
        ]
    return found


def body(p, raised):
    (_, whole), *others = parts(p, raised)
    for _, part in others:
        whole = join(whole, part)
    return whole


def colors(p, raised, clothes, seed):
    """Linear rgb: that of the nearest part; hair is the top and the back of the head."""
    names, distances = zip(*parts(p, raised))
    rgb = np.array([PARTS[name] for name in names])[np.argmin(distances, axis=0)]
    rgb[(p[:, 1] > 1.6) & (p[:, 1] - 0.9 * p[:, 2] > 1.65) & (np.abs(p[:, 0]) < 0.12)] = PARTS["hair"]
    if clothes == "powdered":
        random = np.random.default_rng(seed)
        for _ in range(9):
            middle = p[random.integers(len(p))]
            reach = random.uniform(0.1, 0.22)
            ragged = np.sin(p @ random.normal(size=(3, 4)) * 30).mean(axis=1)
            share = np.clip(2.2 * (1 - np.linalg.norm(p - middle, axis=1) / reach + 0.35 * ragged), 0, 0.92)[:, None]
            rgb = rgb + (np.array(POWDER[random.integers(len(POWDER))]) - rgb) * share
    return rgb


def gradient(p, raised):
    step = 1e-4
    ways = [body(p + step * e, raised) - body(p - step * e, raised) for e in np.eye(3)]
    return np.stack(ways, axis=-1) / (2 * step)


def surface(raised):
    """Positions, unit normals and triangles."""
    low, high = np.array([-0.56, -0.06, -0.3]), np.array([0.56, 2.06, 0.3])
    counts = np.ceil((high - low) / CELL).astype(int) + 1
    grid = np.stack(np.meshgrid(*(low[i] + CELL * np.arange(counts[i]) for i in range(3)), indexing="ij"), axis=-1)
    inside = body(grid, raised) < 0
    corners = sum(inside[i : counts[0] - 1 + i, j : counts[1] - 1 + j, k : counts[2] - 1 + k].astype(int)
                  for i in (0, 1) for j in (0, 1) for k in (0, 1))
    crossed = (corners > 0) & (corners < 8)
    number = np.full(crossed.shape, -1)
    number[crossed] = np.arange(crossed.sum())
    p = low + CELL * (np.argwhere(crossed) + 0.5)
    for _ in range(4):
        g = gradient(p, raised)
        p = p - g * (body(p, raised) / np.maximum((g * g).sum(-1), 1e-6))[:, None]
    g = gradient(p, raised)
    normals = g / np.linalg.norm(g, axis=-1, keepdims=True)
    triangles = []
    for axis in range(3):
        # Four cells share each edge of the grid whose ends differ.
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        ends = [inside.take(range(1, counts[axis]), axis), inside.take(range(counts[axis] - 1), axis)]
        for at in np.argwhere(ends[0] != ends[1]):
            quad = [number[tuple(at - d)] for d in (0 * u, u, u + v, v)]
            if ends[1][tuple(at)]:
                quad.reverse()
            triangles += [(quad[0], quad[2], quad[1]), (quad[0], quad[3], quad[2])]
    return p, normals, np.array(triangles)


def main(path):
    _, clothes, arms = pathlib.Path(path).stem.split("_")
    positions, normals, triangles = surface(RAISED[arms])
    rgb = colors(positions, RAISED[arms], clothes, seed=list(RAISED).index(arms))
    positions[:, 1] -= positions[:, 1].min()
    arrays = [positions.astype("<f4"), normals.astype("<f4"), triangles.astype("<u2").reshape(-1)]
    attributes, tint = {"POSITION": 0, "NORMAL": 1}, DARK
    if clothes != "dark":
        opaque = np.concatenate([rgb, np.ones((len(rgb), 1))], axis=1)
        arrays.append(np.round(255 * opaque).astype("u1"))
        attributes["COLOR_0"], tint = 3, [1, 1, 1]
    binary = b"".join(a.tobytes() + b"\0" * (-a.nbytes % 4) for a in arrays)
    starts = np.cumsum([0] + [a.nbytes + -a.nbytes % 4 for a in arrays]).tolist()
    document = {
        "asset": {"version": "2.0", "generator": "gobo, tools/person.py"},
        "materials": [{
            "name": clothes,
            "pbrMetallicRoughness": {"baseColorFactor": [*tint, 1], "metallicFactor": 0, "roughnessFactor": 1},
        }],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 2, "material": 0}]}],
        "nodes": [{"name": "person", "mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3",
             "min": arrays[0].min(0).tolist(), "max": arrays[0].max(0).tolist()},
            {"bufferView": 1, "componentType": 5126, "count": len(positions), "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": len(arrays[2]), "type": "SCALAR"},
            {"bufferView": 3, "componentType": 5121, "count": len(positions), "type": "VEC4", "normalized": True},
        ][:len(arrays)],
        "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": a.nbytes, "target": 34963 if i == 2 else 34962}
                        for i, (start, a) in enumerate(zip(starts, arrays))],
        "buffers": [{"byteLength": len(binary)}],
    }
    write_glb(path, document, binary)


if __name__ == "__main__":
    for path in sys.argv[1:]:
        main(path)
