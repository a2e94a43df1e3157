"""Writes data/gallery/car_red.glb and car_white.glb: the cars of data/gallery/chase.toml, 4 m long, their fronts towards +x.

python3 tools/car.py data/gallery
"""
import math
import struct
import sys

from glb import write_glb

# Outlines seen from aside, x and y [m], and half of their widths.
BODY = [(-2.0, 0.42), (-2.05, 0.78), (-1.92, 0.98), (-1.5, 1.02), (0.75, 0.98), (1.75, 0.84), (2.02, 0.62), (2.05, 0.4), (1.9, 0.28), (-1.85, 0.28)]
CABIN = [(-1.72, 1.0), (-1.15, 1.4), (-0.95, 1.43), (0.05, 1.43), (0.25, 1.38), (0.95, 0.96)]
ROOF = [(-1.12, 1.41), (-0.9, 1.46), (0.02, 1.46), (0.2, 1.41)]
BODY_HALF, CABIN_HALF, ROOF_HALF = 0.88, 0.72, 0.66
BEVEL = 0.1  # of the outlines' edges [m]
WHEELS = [(x, z) for x in (-1.25, 1.28) for z in (-0.8, 0.8)]
WHEEL, RIM, HALF_TYRE, SIDES = 0.36, 0.2, 0.13, 24


def faces_of(outline, half, bevel):
    """Polygons of a body with an outline and beveled sides."""
    middle = [sum(p[i] for p in outline) / len(outline) for i in (0, 1)]
    inner = [tuple(c + (m - c) * bevel / 0.9 for c, m in zip(p, middle)) for p in outline]
    rings = [[(x, y, side * z) for x, y in ring] for side, ring, z in
             ((-1, inner, half), (-1, outline, half - bevel), (1, outline, half - bevel), (1, inner, half))]
    faces = [list(rings[0]), list(reversed(rings[3]))]
    for a, b in zip(rings, rings[1:]):
        for i in range(len(outline)):
            j = (i + 1) % len(outline)
            faces.append([a[j], a[i], b[i], b[j]])
    return faces


def wheel(x, z):
    """Polygons of a tyre and of a rim."""
    def ring(radius, at):
        return [(x + radius * math.cos(2 * math.pi * i / SIDES), WHEEL + radius * math.sin(2 * math.pi * i / SIDES), at) for i in range(SIDES)]

    tyre, rims = [], []
    for side in (-1, 1):
        outer, edge = ring(WHEEL, z + side * HALF_TYRE), ring(RIM, z + side * HALF_TYRE)
        for i in range(SIDES):
            j = (i + 1) % SIDES
            face = [outer[i], outer[j], edge[j], edge[i]]
            tyre.append(face if side > 0 else face[::-1])
        rims.append(edge if side > 0 else edge[::-1])
    near, far = ring(WHEEL, z - HALF_TYRE), ring(WHEEL, z + HALF_TYRE)
    tyre += [[near[i], near[(i + 1) % SIDES], far[(i + 1) % SIDES], far[i]] for i in range(SIDES)]
    return tyre, rims


def box(low, high):
    """Polygons of a box."""
    (a, b, c), (x, y, z) = low, high
    return [
        [(a, b, z), (x, b, z), (x, y, z), (a, y, z)], [(x, b, c), (a, b, c), (a, y, c), (x, y, c)],
        [(x, b, z), (x, b, c), (x, y, c), (x, y, z)], [(a, b, c), (a, b, z), (a, y, z), (a, y, c)],
        [(a, y, z), (x, y, z), (x, y, c), (a, y, c)], [(a, b, c), (x, b, c), (x, b, z), (a, b, z)],
    ]


def triangles(faces):
    """Positions and flat normals of fans over polygons."""
    positions, normals = [], []
    for face in faces:
        for b, c in zip(face[1:], face[2:]):
            u, v = ([q - p for p, q in zip(face[0], end)] for end in (b, c))
            normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            length = math.sqrt(sum(n * n for n in normal))
            if length > 1e-9:
                positions += [face[0], b, c]
                normals += [tuple(n / length for n in normal)] * 3
    return positions, normals


def car(path, paint):
    tyres, rims = [], []
    for place in WHEELS:
        tyre, rim = wheel(*place)
        tyres, rims = tyres + tyre, rims + rim
    lamps = [face for z in (-0.66, 0.66) for face in box((1.93, 0.6, z - 0.14), (2.02, 0.74, z + 0.14))]
    tails = [face for z in (-0.66, 0.66) for face in box((-2.06, 0.72, z - 0.16), (-1.98, 0.84, z + 0.16))]
    dark = {"baseColorFactor": [0.02, 0.02, 0.022, 1], "metallicFactor": 0}
    parts = [
        ("paint", faces_of(BODY, BODY_HALF, BEVEL) + faces_of(ROOF, ROOF_HALF, 0.05), {"baseColorFactor": [*paint, 1], "metallicFactor": 0, "roughnessFactor": 0.25}, None),
        ("glass", faces_of(CABIN, CABIN_HALF, 0.08), {**dark, "roughnessFactor": 0.1}, None),
        ("tyre", tyres, {**dark, "roughnessFactor": 0.9}, None),
        ("rim", rims, {"baseColorFactor": [0.5, 0.5, 0.52, 1], "metallicFactor": 1, "roughnessFactor": 0.4}, None),
        ("lamp", lamps, {"baseColorFactor": [0.9, 0.9, 0.85, 1], "metallicFactor": 0}, [1, 0.9, 0.7]),
        ("tail", tails, {"baseColorFactor": [0.5, 0.02, 0.02, 1], "metallicFactor": 0}, [0.9, 0.05, 0.02]),
    ]
    views, accessors, materials, primitives, binary = [], [], [], [], b""
    for name, faces, look, emission in parts:
        attributes = {}
        for kind, values in zip(("POSITION", "NORMAL"), triangles(faces)):
            views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": 12 * len(values), "target": 34962})
            binary += b"".join(struct.pack("<3f", *value) for value in values)
            accessor = {"bufferView": len(views) - 1, "componentType": 5126, "count": len(values), "type": "VEC3"}
            if kind == "POSITION":
                flat = [struct.unpack("<3f", struct.pack("<3f", *value)) for value in values]
                accessor |= {"min": [min(c) for c in zip(*flat)], "max": [max(c) for c in zip(*flat)]}
            attributes[kind] = len(accessors)
            accessors.append(accessor)
        materials.append({"name": name, "pbrMetallicRoughness": look, **({"emissiveFactor": emission} if emission else {})})
        primitives.append({"attributes": attributes, "material": len(materials) - 1})
    write_glb(path, {
        "asset": {"version": "2.0", "generator": "gobo, tools/car.py"},
        "materials": materials,
        "meshes": [{"primitives": primitives}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }, binary)


def main(folder):
    car(f"{folder}/car_red.glb", (0.7, 0.04, 0.03))
    car(f"{folder}/car_white.glb", (0.85, 0.86, 0.88))


if __name__ == "__main__":
    main(*sys.argv[1:])
