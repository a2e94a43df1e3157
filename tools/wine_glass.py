"""Writes data/gallery/wine_glass.glb: a glass and the wine in it, two closed bodies of revolution.

python3 tools/wine_glass.py data/gallery/wine_glass.glb
"""
import math
import struct
import sys

from glb import write_glb

SIDES = 72
CUTS = 4  # of a smooth segment
# Radius and height [cm], from the axis at the bottom, outside up and inside down to the axis.
GLASS = [
    (0, 0), (3.4, 0), (3.5, 0.1), (3.4, 0.2), (2.2, 0.35), (1.0, 0.7), (0.5, 1.3), (0.38, 2.5), (0.36, 5),
    (0.4, 7.6), (0.7, 8.5), (1.6, 9.2), (2.8, 10.1), (3.7, 11.3), (4.15, 12.8), (4.25, 14.2), (4.1, 16),
    (3.75, 18), (3.4, 20), (3.35, 20.05), (3.3, 20), (3.64, 18), (3.98, 16), (4.12, 14.2), (4.02, 12.8),
    (3.57, 11.4), (2.68, 10.25), (1.5, 9.4), (0.6, 9.0), (0, 8.9),
]
WINE = [
    (0, 8.93), (0.59, 9.03), (1.48, 9.43), (2.66, 10.28), (3.55, 11.43), (4.0, 12.82), (4.09, 14.0),
    (4.04, 14.05), (0, 14.0),
]
LEVEL = 14.0  # of the wine [cm]
# What is left of light after a distance [m].
GLASS_BODY = ([0.8, 0.88, 0.86], 0.012)
WINE_BODY = ([0.86, 0.08, 0.1], 0.03)


def corners(profile):
    """Whether each point is a corner: an end, or sharper than 40 degrees."""
    def heading(a, b):
        return math.atan2(b[1] - a[1], b[0] - a[0])

    sharp = [True]
    for a, b, c in zip(profile, profile[1:], profile[2:]):
        turn = heading(b, c) - heading(a, b)
        sharp.append(abs(math.remainder(turn, 2 * math.pi)) > math.radians(40))
    return sharp + [True]


def smooth(profile, cuts=CUTS):
    """The profile through the same points, rounded between its corners (Catmull and Rom 1974)."""
    sharp, points = corners(profile), [profile[0]]
    for i, (b, c) in enumerate(zip(profile, profile[1:])):
        if sharp[i] and sharp[i + 1]:
            points.append(c)
            continue
        a = b if sharp[i] else profile[i - 1]
        d = c if sharp[i + 1] else profile[i + 2]
        for cut in range(1, cuts + 1):
            t = cut / cuts
            weights = (-t + 2 * t**2 - t**3, 2 - 5 * t**2 + 3 * t**3, t + 4 * t**2 - 3 * t**3, -t**2 + t**3)
            points.append(tuple(sum(w * p[k] for w, p in zip(weights, (a, b, c, d))) / 2 for k in (0, 1)))
    return points


def lathe(profile):
    """Positions, normals and triangles of the body; its corners stay sharp."""
    points = smooth(profile)
    sharp = corners(points)
    ways = [(b[0] - a[0], b[1] - a[1]) for a, b in zip(points, points[1:])]

    def ring(at, *segments):
        x = sum(ways[s][0] / math.hypot(*ways[s]) for s in segments)
        y = sum(ways[s][1] / math.hypot(*ways[s]) for s in segments)
        n = (y / math.hypot(x, y), -x / math.hypot(x, y))
        first, (r, height) = len(positions), points[at]
        for side in range(SIDES):
            c, s = math.cos(2 * math.pi * side / SIDES), math.sin(2 * math.pi * side / SIDES)
            positions.append((r * c / 100, height / 100, -r * s / 100))
            normals.append((n[0] * c, n[1], -n[0] * s))
        return first

    positions, normals, triangles = [], [], []
    upper = None
    for segment in range(len(ways)):
        lower = ring(segment, segment) if sharp[segment] else upper
        ends = (segment,) if sharp[segment + 1] else (segment, segment + 1)
        upper = ring(segment + 1, *ends)
        for side in range(SIDES):
            turned = (side + 1) % SIDES
            if points[segment][0] > 0:
                triangles.append((lower + side, lower + turned, upper + turned))
            if points[segment + 1][0] > 0:
                triangles.append((lower + side, upper + turned, upper + side))
    return positions, normals, triangles


def main(path):
    views, accessors, binary = [], [], b""

    def add(values, code, component, kind, target):
        nonlocal binary
        data = b"".join(struct.pack("<" + code * len(v), *v) for v in values)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), "target": target})
        count = len(values) * (3 if kind == "SCALAR" else 1)
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count, "type": kind})
        if target == 34962:
            accessors[-1]["min"] = [struct.unpack("<f", struct.pack("<f", min(v[i] for v in values)))[0] for i in range(3)]
            accessors[-1]["max"] = [struct.unpack("<f", struct.pack("<f", max(v[i] for v in values)))[0] for i in range(3)]
        binary += data
        return len(accessors) - 1

    meshes = []
    for material, profile in enumerate((GLASS, WINE)):
        positions, normals, triangles = lathe(profile)
        attributes = {
            "POSITION": add(positions, "f", 5126, "VEC3", 34962),
            "NORMAL": add(normals, "f", 5126, "VEC3", 34962),
        }
        indices = add(triangles, "H", 5123, "SCALAR", 34963)
        meshes.append({"primitives": [{"attributes": attributes, "indices": indices, "material": material}]})

    def body(name, color, distance, roughness):
        return {
            "name": name,
            "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": roughness},
            "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1},
                "KHR_materials_volume": {
                    "thicknessFactor": 0.01, "attenuationColor": color, "attenuationDistance": distance,
                },
            },
        }

    document = {
        "asset": {"version": "2.0", "generator": "gobo, tools/wine_glass.py"},
        "extensionsUsed": ["KHR_materials_transmission", "KHR_materials_volume"],
        "materials": [body("glass", *GLASS_BODY, 0.05), body("wine", *WINE_BODY, 0.1)],
        "meshes": meshes,
        "nodes": [{"name": "glass", "mesh": 0}, {"name": "wine", "mesh": 1}],
        "scenes": [{"nodes": [0, 1]}],
        "scene": 0,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    write_glb(path, document, binary)


if __name__ == "__main__":
    main(sys.argv[1])
