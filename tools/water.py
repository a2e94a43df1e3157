"""Writes data/gallery/pool_water.glb: the water of a pool, a closed body under waves that run in all directions.

python3 tools/water.py data/gallery/pool_water.glb
"""
import math
import random
import struct
import sys

from glb import write_glb

SIZE = (9.2, 6.4)  # [m]
CELLS = (124, 86)
BOTTOM = -1.4  # below the mean surface, and so below the floor of tiles [m]
WAVES = 26
LENGTHS = (0.36, 0.9)  # of the waves [m]
SLOPE = 0.11  # root mean square: water is in focus where its curvature is 1.33 / (0.33 depth)
SEED = 7
# What is left of light after a distance [m].
BODY = ([0.62, 0.93, 0.97], 3.0)
STEPS = 32767  # positions and normals are 16 bits


def waves():
    """Wave vectors [1/m], amplitudes [m] and phases; each wave has the same slope."""
    chance = random.Random(SEED)
    found = []
    for i in range(WAVES):
        length = LENGTHS[0] * (LENGTHS[1] / LENGTHS[0]) ** ((i + chance.random()) / WAVES)
        heading = 2 * math.pi * (i * 0.618034 + 0.1 * chance.random())
        number = 2 * math.pi / length
        amplitude = SLOPE * math.sqrt(2 / WAVES) / number
        found.append((number * math.cos(heading), number * math.sin(heading), amplitude, 2 * math.pi * chance.random()))
    return found


def surface(x, z, all_waves):
    """Height [m] and normal."""
    height, along, across = 0.0, 0.0, 0.0
    for kx, kz, amplitude, phase in all_waves:
        angle = kx * x + kz * z + phase
        height += amplitude * math.sin(angle)
        along += amplitude * kx * math.cos(angle)
        across += amplitude * kz * math.cos(angle)
    long = math.sqrt(1 + along * along + across * across)
    return height, (-along / long, 1 / long, -across / long)


def body():
    """Positions [m], normals and triangles of the closed body."""
    (columns, rows), all_waves = CELLS, waves()
    positions, normals, triangles = [], [], []
    for row in range(rows + 1):
        for column in range(columns + 1):
            x, z = SIZE[0] * (column / columns - 0.5), SIZE[1] * (row / rows - 0.5)
            height, normal = surface(x, z, all_waves)
            positions.append((x, height, z))
            normals.append(normal)
    for row in range(rows):
        for column in range(columns):
            a = row * (columns + 1) + column
            b, c, d = a + 1, a + columns + 1, a + columns + 2
            triangles += [(a, c, b), (b, c, d)]
    # Around the surface, counterclockwise from above.
    front = [(column, rows, (0, 0, 1)) for column in range(columns)]
    right = [(columns, row, (1, 0, 0)) for row in range(rows, 0, -1)]
    back = [(column, 0, (0, 0, -1)) for column in range(columns, 0, -1)]
    left = [(0, row, (-1, 0, 0)) for row in range(rows)]
    edge = front + right + back + left
    middle = len(positions)
    positions.append((0, BOTTOM, 0))
    normals.append((0, -1, 0))
    for (column, row, normal), (next_column, next_row, _) in zip(edge, edge[1:] + edge[:1]):
        first = len(positions)
        ends = [positions[y * (columns + 1) + x] for x, y in ((column, row), (next_column, next_row))]
        low = [(x, BOTTOM, z) for x, _, z in ends]
        positions += ends + low + low
        normals += [normal] * 4 + [(0, -1, 0)] * 2
        triangles += [(first, first + 2, first + 1), (first + 1, first + 2, first + 3), (middle, first + 5, first + 4)]
    return positions, normals, triangles


def main(path):
    positions, normals, triangles = body()
    scale = SIZE[0] / 2
    places = [[round(v / scale * STEPS) for v in p] for p in positions]
    binary = b"".join(struct.pack("<4h", *p, 0) for p in places)
    binary += b"".join(struct.pack("<4h", *(round(v * STEPS) for v in n), 0) for n in normals)
    count, indices = len(places), [i for triangle in triangles for i in triangle]
    binary += struct.pack(f"<{len(indices)}H", *indices)
    vector = {"componentType": 5122, "normalized": True, "count": count, "type": "VEC3"}
    ends = {"min": [min(p[i] for p in places) for i in range(3)], "max": [max(p[i] for p in places) for i in range(3)]}
    color, distance = BODY
    document = {
        "asset": {"version": "2.0", "generator": "gobo, tools/water.py"},
        "extensionsUsed": ["KHR_mesh_quantization", "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "materials": [{
            "name": "water",
            "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.05},
            "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1},
                "KHR_materials_volume": {"thicknessFactor": 1, "attenuationColor": color, "attenuationDistance": distance},
                "KHR_materials_ior": {"ior": 1.33},
            },
        }],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "nodes": [{"name": "water", "mesh": 0, "scale": [scale] * 3}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        "accessors": [
            {**vector, **ends, "bufferView": 0},
            {**vector, "bufferView": 1},
            {"bufferView": 2, "componentType": 5123, "count": len(indices), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 8 * count * i, "byteLength": 8 * count, "byteStride": 8, "target": 34962}
            for i in range(2)
        ] + [{"buffer": 0, "byteOffset": 16 * count, "byteLength": 2 * len(indices), "target": 34963}],
        "buffers": [{"byteLength": len(binary)}],
    }
    write_glb(path, document, binary)


if __name__ == "__main__":
    main(sys.argv[1])
