"""Writes data/gallery/column.glb: a column of stone with a base and a capital, 2.4 m high, on the origin.

python3 tools/column.py data/gallery/column.glb
"""
import struct
import sys

import wine_glass
from glb import write_glb

wine_glass.SIDES = 28
# Radius and height [cm], a body of revolution, between a square plinth and a square abacus.
SHAFT = [
    (0, 6), (27, 6), (29, 9), (27, 12), (23, 13), (22, 16), (24, 18), (24, 20), (19.5, 21), (18.5, 26), (18.6, 80), (17.8, 150),
    (15.6, 214), (17, 215), (17, 218), (15.4, 219), (15.4, 222), (19, 225), (24, 230), (25, 233), (0, 233),
]
PLATES = (((30, 0), (30, 6)), ((27, 233), (27, 240)))  # half an edge, and bottom and top [cm]


def plate(low, high):
    """A box, with normals of its own on each side."""
    half, bottom, top = low[0] / 100, low[1] / 100, high[1] / 100
    corner = lambda x, y, z: (x * half, top if y > 0 else bottom, z * half)
    positions, normals, triangles = [], [], []
    for axis in range(3):
        for sign in (1, -1):
            first = len(positions)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                point = [0, 0, 0]
                point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3] = sign, a * sign, b
                positions.append(corner(*point))
                normals.append(tuple(sign if k == axis else 0 for k in range(3)))
            triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return positions, normals, triangles


def main(path):
    positions, normals, triangles = wine_glass.lathe(wine_glass.smooth(SHAFT, 2))
    for ends in PLATES:
        more, directions, faces = plate(*ends)
        triangles += [tuple(len(positions) + i for i in face) for face in faces]
        positions += more
        normals += directions
    parts = [(positions, "f", 34962), (normals, "f", 34962), (triangles, "H", 34963)]
    views, binary = [], b""
    for values, code, target in parts:
        data = b"".join(struct.pack("<3" + code, *value) for value in values)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), "target": target})
        binary += data
    bound = lambda of: [struct.unpack("<f", struct.pack("<f", of(p[k] for p in positions)))[0] for k in range(3)]
    count = len(positions)
    document = {
        "asset": {"version": "2.0", "generator": "gobo, tools/column.py"},
        "materials": [{"name": "stone", "pbrMetallicRoughness": {
            "baseColorFactor": [0.72, 0.71, 0.68, 1], "metallicFactor": 0, "roughnessFactor": 0.8}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "nodes": [{"name": "column", "mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3", "min": bound(min), "max": bound(max)},
            {"bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": 3 * len(triangles), "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    write_glb(path, document, binary)


if __name__ == "__main__":
    main(sys.argv[1])
