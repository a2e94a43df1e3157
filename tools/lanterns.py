"""Writes data/gallery/market_lanterns.glb: a paper lantern around each point light of the market; and what they hang from,
data/gallery/market_ropes.csv.

python3 tools/lanterns.py data/gallery/market.toml data/gallery/market_lanterns.glb data/gallery/market_ropes.csv

A body of revolution between two dark caps; it shines brightest where the lamp is near, and its ribs are darker.
Lanterns of one colour are instances of one mesh (EXT_mesh_gpu_instancing).
"""
import math
import struct
import sys
import tomllib
import zlib

import wine_glass
from glb import write_glb

wine_glass.SIDES = 20
RIBS = 5
ROWS = 64  # of the texture
BRIGHTEST = 3.4  # light of the paper, times the lamp's colour
# Radius and height [cm].
PAPER = [(11 * (1 - 0.85 * (t / RIBS - 1) ** 2) ** 0.5 * (0.965 if t % 2 else 1), 1.5 * t) for t in range(2 * RIBS + 1)]
CAP = [(0, 0), (5, 0), (5, 1.6), (0, 1.6)]
MIDDLE = 1.5 * RIBS / 100  # [m]


def bodies():
    """Paper and caps: positions around the middle, normals and triangles."""
    def moved(body, by):
        positions, normals, triangles = body
        return [(x, y + by - MIDDLE, z) for x, y, z in positions], normals, triangles

    paper = moved(wine_glass.lathe(wine_glass.smooth(PAPER, 2)), 0)
    low, high = (moved(wine_glass.lathe(CAP), by) for by in (-0.012, 2 * MIDDLE - 0.004))
    first = len(low[0])
    caps = low[0] + high[0], low[1] + high[1], low[2] + [tuple(i + first for i in t) for t in high[2]]
    return paper, caps


def glow(v):
    """Share of the brightest light at a height, 0 at the bottom and 1 at the top."""
    rib = abs(math.sin(v * RIBS * math.pi)) ** 0.35
    return (0.1 + 0.9 * math.exp(-(((v - 0.46) / 0.25) ** 2))) * (0.55 + 0.45 * rib)


def png():
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    def srgb(x):
        return round(255 * (12.92 * x if x < 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055))

    rows = b"".join(b"\0" + bytes([srgb(glow(1 - (i + 0.5) / ROWS))] * 12) for i in range(ROWS))
    header = struct.pack(">IIBBBBB", 4, ROWS, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


# Slope and height of the awnings at x = 0 [m], and where the houses begin.
AWNING, HOUSES = (-0.445, 3.644), 3.7


def ropes(lamps):
    """Rows of x, y, z, radius and id: a rope for each eight lanterns across the street, a cord for each under an awning."""
    rows = []

    def strand(points, radius, number):
        rows.extend(f"{x:.3f},{y:.3f},{z:.3f},{radius},{number}" for x, y, z in points)

    across = [lamp["position"] for lamp in lamps if lamp["intensity"] > 2]
    for i in range(0, len(across), 8):
        row = sorted(across[i : i + 8])
        ends = [(side * HOUSES, end[1] + 0.42, end[2]) for side, end in ((-1, row[0]), (1, row[-1]))]
        tops = [(x, y + MIDDLE + 0.028, z) for x, y, z in row]
        strand([ends[0], *tops, ends[1]], 0.008, i // 8)
    under = [lamp["position"] for lamp in lamps if lamp["intensity"] <= 2]
    for i, (x, y, z) in enumerate(under):
        strand([(x, y + 0.6 * MIDDLE, z), (x, AWNING[0] * abs(x) + AWNING[1], z)], 0.004, 1000 + i)
    return rows


def main(scene, path, path_of_ropes):
    with open(scene, "rb") as file:
        lamps = [light for light in tomllib.load(file)["light"] if light["kind"] == "point"]
    with open(path_of_ropes, "w") as file:
        file.write("x,y,z,radius,id\n" + "\n".join(ropes(lamps)) + "\n")
    views, accessors, binary = [], [], b""

    def view(data, **more):
        nonlocal binary
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), **more})
        binary += data + b"\0" * (-len(data) % 4)
        return len(views) - 1

    def add(values, code, component, kind, **more):
        place = view(b"".join(struct.pack("<" + code * len(v), *v) for v in values), **more)
        count = len(values) * (3 if kind == "SCALAR" else 1)
        accessors.append({"bufferView": place, "componentType": component, "count": count, "type": kind})
        return len(accessors) - 1

    def primitive(body, material, heights=None):
        positions, normals, triangles = body
        attributes = {
            "POSITION": add(positions, "f", 5126, "VEC3", target=34962),
            "NORMAL": add(normals, "f", 5126, "VEC3", target=34962),
        }
        flat = [struct.unpack("<3f", struct.pack("<3f", *p)) for p in positions]
        accessors[attributes["POSITION"]] |= {"min": [min(c) for c in zip(*flat)], "max": [max(c) for c in zip(*flat)]}
        if heights:
            attributes["TEXCOORD_0"] = add([(0.5, 1 - v) for v in heights], "f", 5126, "VEC2", target=34962)
        return {"attributes": attributes, "indices": add(triangles, "H", 5123, "SCALAR", target=34963), "material": material}

    paper, caps = bodies()
    heights = [0.5 + y / (2 * MIDDLE) for _, y, _ in paper[0]]
    paper, caps = primitive(paper, 1, heights), primitive(caps, 0)
    materials = [{"name": "cap", "pbrMetallicRoughness": {"baseColorFactor": [0.03, 0.025, 0.02, 1], "metallicFactor": 0}}]
    meshes, nodes = [], []
    for color in sorted({tuple(lamp["color"]) for lamp in lamps}):
        most = max(color)
        materials.append({
            "name": f"paper{len(meshes)}",
            "pbrMetallicRoughness": {"baseColorFactor": [0.15 + 0.5 * c for c in color] + [1], "metallicFactor": 0},
            "emissiveFactor": [c / most for c in color],
            "emissiveTexture": {"index": 0},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": BRIGHTEST * most}},
        })
        meshes.append({"primitives": [{**paper, "material": len(materials) - 1}, caps]})
        own = [lamp for lamp in lamps if tuple(lamp["color"]) == color]
        # Lamps of little light are small.
        sizes = [1.0 if lamp["intensity"] > 2 else 0.6 for lamp in own]
        places = {
            "TRANSLATION": add([lamp["position"] for lamp in own], "f", 5126, "VEC3"),
            "SCALE": add([(size, size, size) for size in sizes], "f", 5126, "VEC3"),
        }
        nodes.append({"mesh": len(meshes) - 1, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": places}}})
    image = view(png())
    document = {
        "asset": {"version": "2.0", "generator": "gobo, tools/lanterns.py"},
        "extensionsUsed": ["EXT_mesh_gpu_instancing", "KHR_materials_emissive_strength"],
        "images": [{"bufferView": image, "mimeType": "image/png"}],
        "textures": [{"source": 0}],
        "materials": materials,
        "meshes": meshes,
        "nodes": nodes,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "scene": 0,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    write_glb(path, document, binary)


if __name__ == "__main__":
    main(*sys.argv[1:])
