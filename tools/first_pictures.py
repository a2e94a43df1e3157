"""Renders sixty small files of its own by defaults alone, twelve of each kind whose first picture is easily poor, as five sheets.

GOBO=target/release/gobo target/pictures/bin/python tools/first_pictures.py [WORD]...

Files, pictures and sheets are in target/first_pictures; with words only files whose kind or name has one of them are rendered anew.
benches/NOTES.md lists what they show. Needs Pillow (`make pictures` installs it there).
"""
import math
import os
import pathlib
import struct
import subprocess
import sys
import time

from PIL import Image, ImageDraw, ImageFont

from glb import write_glb

ROOT = pathlib.Path(__file__).resolve().parent.parent
TO = ROOT / "target/first_pictures"
SIZE = (240, 135)  # [pixels]
COLUMNS = 4
LINE = 14  # height of a name below its picture [pixels]

# Colours, and alphas where below 1.
GRASS, SAND, CLAY, WOOD = (0.24, 0.4, 0.16), (0.62, 0.55, 0.42), (0.5, 0.24, 0.15), (0.45, 0.28, 0.14)
WHITE, GREY, BLACK = (0.8, 0.8, 0.8), (0.35, 0.35, 0.36), (0.02, 0.02, 0.02)
RED, BLUE, YELLOW, TEAL = (0.65, 0.06, 0.05), (0.08, 0.2, 0.6), (0.8, 0.55, 0.06), (0.05, 0.42, 0.4)
GLASS = (0.35, 0.65, 0.85, 0.35)


class Model:
    """Objects of polygons, each in a colour, and lamps."""

    def __init__(self):
        self.objects, self.lights = [], []

    def add(self, color, faces, two_sided=False, glow=None):
        self.objects.append((tuple(color), faces, two_sided, glow))
        return self

    def light(self, kind, at, intensity, color=(1, 1, 1)):
        """A lamp that shines down, or a sun."""
        self.lights.append((kind, at, intensity, color))
        return self

    def write(self, path):
        binary, accessors, views, meshes, nodes, materials = b"", [], [], [], [], []
        for color, faces, two_sided, glow in self.objects:
            positions, normals = triangles(faces)
            attributes = {}
            for name, rows in (("POSITION", positions), ("NORMAL", normals)):
                data = b"".join(struct.pack("<3f", *row) for row in rows)
                views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
                accessor = {"bufferView": len(views) - 1, "componentType": 5126, "count": len(rows), "type": "VEC3"}
                if name == "POSITION":
                    single = [struct.unpack("<3f", struct.pack("<3f", *row)) for row in rows]
                    accessor |= {"min": [min(p) for p in zip(*single)], "max": [max(p) for p in zip(*single)]}
                attributes[name] = len(accessors)
                accessors.append(accessor)
                binary += data
            surface = {"baseColorFactor": [*color[:3], color[3] if len(color) > 3 else 1], "metallicFactor": 0, "roughnessFactor": 0.7}
            material = {"pbrMetallicRoughness": surface, "doubleSided": two_sided}
            if len(color) > 3:
                material["alphaMode"] = "BLEND"
            if glow:
                material["emissiveFactor"] = list(glow)
            materials.append(material)
            meshes.append({"primitives": [{"attributes": attributes, "material": len(materials) - 1}]})
            nodes.append({"mesh": len(meshes) - 1})
        document = {"asset": {"version": "2.0"}, "scene": 0, "nodes": nodes, "meshes": meshes, "materials": materials, "accessors": accessors,
                    "bufferViews": views, "buffers": [{"byteLength": len(binary)}]}
        if self.lights:
            lights = []
            for kind, at, intensity, color in self.lights:
                # A quarter turn about x looks down, less of one aslant.
                half = math.radians(-90 if kind == "spot" else -50) / 2
                lights.append({"type": kind, "intensity": intensity, "color": list(color)} | ({"spot": {}} if kind == "spot" else {}))
                turn = [math.sin(half), 0, 0, math.cos(half)]
                nodes.append({"translation": list(at), "rotation": turn, "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}})
            document |= {"extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": lights}}}
        document["scenes"] = [{"nodes": list(range(len(nodes)))}]
        write_glb(path, document, binary)


def triangles(faces):
    """Positions and flat normals of fans over polygons."""
    positions, normals = [], []
    for face in faces:
        for b, c in zip(face[1:], face[2:]):
            u, v = ([q - p for p, q in zip(face[0], end)] for end in (b, c))
            normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            length = math.sqrt(sum(n * n for n in normal))
            if length > 1e-12:
                positions += [face[0], b, c]
                normals += [tuple(n / length for n in normal)] * 3
    return positions, normals


def box(low, high, inside=False):
    """Faces of a box that look outward, or inward."""
    (a, b, c), (x, y, z) = low, high
    faces = [
        [(a, b, z), (x, b, z), (x, y, z), (a, y, z)], [(x, b, c), (a, b, c), (a, y, c), (x, y, c)],
        [(x, b, z), (x, b, c), (x, y, c), (x, y, z)], [(a, b, c), (a, b, z), (a, y, z), (a, y, c)],
        [(a, y, z), (x, y, z), (x, y, c), (a, y, c)], [(a, b, c), (x, b, c), (x, b, z), (a, b, z)],
    ]
    return [face[::-1] for face in faces] if inside else faces


def level(a, c, x, z, y=0.0):
    """A level rectangle that looks up."""
    return [[(a, y, z), (x, y, z), (x, y, c), (a, y, c)]]


def sheet(height, low, high, count):
    """A sheet over a level rectangle, `height` at each place."""
    steps = range(count + 1)

    def at(i, j):
        x, z = (low[k] + (high[k] - low[k]) * n / count for k, n in ((0, i), (1, j)))
        return (x, height(x, z), z)

    grid = [[at(i, j) for j in steps] for i in steps]
    return [[grid[i][j + 1], grid[i + 1][j + 1], grid[i + 1][j], grid[i][j]] for i in range(count) for j in range(count)]


def lathe(outline, sides=20, middle=(0, 0), capped=True):
    """A body of revolution: radii and heights from below to above."""
    def ring(radius, y):
        return [(middle[0] + radius * math.sin(2 * math.pi * i / sides), y, middle[1] + radius * math.cos(2 * math.pi * i / sides)) for i in range(sides)]

    rings = [ring(*corner) for corner in outline]
    faces = [[a[i], a[(i + 1) % sides], b[(i + 1) % sides], b[i]] for a, b in zip(rings, rings[1:]) for i in range(sides)]
    return faces + ([rings[0][::-1], rings[-1]] if capped else [])


def ball(radius, at, sides=20):
    turns = [math.pi * (i / 10 - 0.5) for i in range(11)]
    outline = [(max(radius * math.cos(t), 1e-4), at[1] + radius * math.sin(t)) for t in turns]
    return lathe(outline, sides, (at[0], at[2]), capped=False)


def moved(faces, turn=0.0, lean=0.0, to=(0, 0, 0)):
    """Faces that lean back and turn about the vertical [degrees], then move."""
    (s, c), (u, v) = ((math.sin(math.radians(t)), math.cos(math.radians(t))) for t in (turn, lean))

    def at(p):
        x, y, z = p[0], p[1] * v + p[2] * u, p[2] * v - p[1] * u
        return (x * c + z * s + to[0], y + to[1], z * c - x * s + to[2])

    return [[at(p) for p in face] for face in faces]


def chair(to=(0, 0, 0), turn=0.0):
    legs = [box((x, 0, z), (x + 0.05, 0.45, z + 0.05)) for x in (-0.22, 0.17) for z in (-0.22, 0.17)]
    parts = [*legs, box((-0.23, 0.45, -0.23), (0.23, 0.5, 0.23)), box((-0.23, 0.5, -0.23), (0.23, 1.0, -0.19))]
    return moved(sum(parts, []), turn, to=to)


def table():
    legs = [box((x, 0, z), (x + 0.06, 0.7, z + 0.06)) for x in (-0.6, 0.54) for z in (-0.4, 0.34)]
    return sum(legs, [])


def car(to=(0, 0, 0), turn=0.0):
    """Body, and wheels."""
    body = box((-2, 0.35, -0.85), (2, 0.85, 0.85)) + box((-1.3, 0.85, -0.75), (0.8, 1.4, 0.75))
    wheels = sum((box((x - 0.33, 0, z - 0.1), (x + 0.33, 0.66, z + 0.1)) for x in (-1.25, 1.25) for z in (-0.82, 0.82)), [])
    return [moved(part, turn, to=to) for part in (body, wheels)]


def tree(to=(0, 0, 0)):
    """Trunk, and crown."""
    trunk = lathe([(0.22, 0), (0.13, 2.2)], 10)
    crown = ball(1.2, (0, 3.1, 0)) + ball(0.8, (0.9, 2.6, 0.3)) + ball(0.8, (-0.8, 2.7, -0.4))
    return [moved(part, to=to) for part in (trunk, crown)]


def person(to=(0, 0, 0), turn=0.0):
    limbs = [box((x, 0, -0.08), (x + 0.15, 0.85, 0.08)) for x in (-0.19, 0.04)]
    limbs += [box((-0.22, 0.85, -0.12), (0.22, 1.45, 0.12)), box((-0.32, 0.8, -0.06), (-0.23, 1.43, 0.06)), box((0.23, 0.8, -0.06), (0.32, 1.43, 0.06))]
    return moved(sum(limbs, []) + ball(0.13, (0, 1.62, 0)), turn, to=to)


def drone():
    arms = [moved(box((-0.3, 0, -0.02), (0.3, 0.03, 0.02)), turn) for turn in (45, 135)]
    rotors = [lathe([(0.13, 0.05), (0.13, 0.06)], 16, (x, z)) for x in (-0.21, 0.21) for z in (-0.21, 0.21)]
    return sum(arms + rotors, []) + box((-0.09, -0.05, -0.09), (0.09, 0.06, 0.09))


def grounds():
    field = level(-50, -50, 50, 50)
    body, wheels = car(turn=25)
    trunk, crown = tree()
    hills = sheet(lambda x, z: 1.2 * math.sin(x / 9) * math.cos(z / 11), (-40, -40), (40, 40), 32)
    bumps = sheet(lambda x, z: 0.02 * math.sin(3 * x) * math.cos(2.3 * z), (-15, -15), (15, 15), 60)
    tiles = sum((level(x, z, x + 2.96, z + 2.96) for x in range(-30, 30, 3) for z in range(-30, 30, 3)), [])
    people = [person((-1, 0, 0), 20), person((0.1, 0, 0.4), -15), person((1.2, 0, -0.2), 40)]
    one, two = car((-21, 0, 0), 30), car((21, 0, 0), -60)
    return {
        "car_200m": Model().add(GREY, level(-100, -100, 100, 100)).add(RED, body).add(BLACK, wheels),
        "chair_tiles": Model().add(SAND, tiles).add(WOOD, chair((1.5, 0, 1.5), 20)),
        "tree_bumps": Model().add(GRASS, bumps).add(WOOD, trunk).add(TEAL, crown),
        "people_strip": Model().add(SAND, level(-250, -4, 250, 4)).add(BLUE, people[0]).add(RED, people[1]).add(YELLOW, people[2]),
        "chair_one_mesh": Model().add(WOOD, field + chair((3, 0, -2), -30)),
        "table_glass": Model().add(GRASS, field).add(WOOD, table()).add(GLASS, box((-0.7, 0.7, -0.5), (0.7, 0.73, 0.5))),
        "chair_corner": Model().add(SAND, field).add(RED, chair((47, 0, 47), 30)),
        "tree_hills": Model().add(GRASS, hills).add(WOOD, trunk).add(TEAL, crown),
        "tree_disc": Model().add(GRASS, lathe([(40, -0.2), (40, 0)], 48)).add(WOOD, trunk).add(TEAL, crown),
        "two_cars_42m": Model().add(GREY, level(-80, -80, 80, 80)).add(RED, one[0]).add(BLACK, one[1]).add(WHITE, two[0]).add(BLACK, two[1]),
        "drone_above": Model().add(GRASS, field).add(GREY, moved(drone(), 15, to=(0, 4, 0))),
        "mug_desk": Model().add(WOOD, level(-1.2, -0.8, 1.2, 0.8)).add(WHITE, lathe([(0.035, 0), (0.042, 0.02), (0.042, 0.1), (0.038, 0.1), (0.036, 0.02)], 24, capped=False)),
    }


def signs():
    def board(width, height, depth=0.04):
        return box((-width / 2, 0, -depth / 2), (width / 2, height, depth / 2))

    letter = sum((box(low, high) for low, high in [((-0.5, 0, 0), (-0.25, 1.5, 0.15)), ((-0.25, 0, 0), (0.5, 0.25, 0.15)), ((-0.25, 0.62, 0), (0.3, 0.87, 0.15)),
                                                    ((-0.25, 1.25, 0), (0.5, 1.5, 0.15))]), [])
    frame = [box((-0.8, 0, 0), (0.8, 0.1, 0.06)), box((-0.8, 1.0, 0), (0.8, 1.1, 0.06)), box((-0.8, 0.1, 0), (-0.7, 1, 0.06)), box((0.7, 0.1, 0), (0.8, 1, 0.06))]
    bend = [(1.6 * math.sin(t), 1.6 * (math.cos(t) - 1)) for t in (math.radians(8 * i - 24) for i in range(7))]
    screen = [[(a[0], 0.1, a[1]), (b[0], 0.1, b[1]), (b[0], 0.9, b[1]), (a[0], 0.9, a[1])] for a, b in zip(bend, bend[1:])]
    fence = sum((box((x, 0, -0.02), (x + 0.08, 1.1, 0.02)) for x in [i * 0.16 - 1 for i in range(13)]), [])
    rails = box((-1.05, 0.25, 0.02), (1.05, 0.33, 0.05)) + box((-1.05, 0.8, 0.02), (1.05, 0.88, 0.05))
    heart = [(0.06 * 16 * math.sin(t) ** 3, 0.06 * (13 * math.cos(t) - 5 * math.cos(2 * t) - 2 * math.cos(3 * t) - math.cos(4 * t)) + 1.05)
             for t in (2 * math.pi * i / 40 for i in range(40))]
    love = [[(0, 1.05, z), (*a, z), (*b, z)][::flip] for z, flip in ((0.08, -1), (0, 1)) for a, b in zip(heart, heart[1:] + heart[:1])]
    love += [[(*a, 0), (*a, 0.08), (*b, 0.08), (*b, 0)][::-1] for a, b in zip(heart, heart[1:] + heart[:1])]
    stripe = box((-0.7, 0.5, 0.021), (0.7, 0.7, 0.03))
    return {
        "board_45": Model().add(WHITE, moved(board(1.6, 1.0), 45)).add(RED, moved(stripe, 45)),
        "board_135": Model().add(WHITE, moved(board(1.6, 1.0), 135)).add(RED, moved(stripe, 135)),
        "face_-45": Model().add(YELLOW, moved([[(-0.7, 0, 0), (0.7, 0, 0), (0.7, 1, 0), (-0.7, 1, 0)]], -45)),
        "plate_on_post": Model().add(GREY, box((-0.05, 0, -0.05), (0.05, 2, 0.05))).add(BLUE, moved(box((-0.5, 1.3, 0.05), (0.5, 2, 0.08)), 60)),
        "letter_30": Model().add(RED, moved(letter, 30)),
        "painting_60": Model().add(WOOD, moved(sum(frame, []), 60)).add(TEAL, moved(board(1.4, 0.9, 0.02), 60, to=(0, 0.1, 0))),
        "screen_90": Model().add(BLACK, moved(screen, 90), two_sided=True),
        "leaning_110": Model().add(YELLOW, moved(board(1.4, 1.6), 110, 15)),
        "leaning_200": Model().add(CLAY, moved(board(1.0, 1.8), 200, -20)),
        "fence_75": Model().add(WOOD, moved(fence + rails, 75)),
        "pane_45": Model().add(GLASS, moved(board(1.4, 1.2, 0.03), 45)).add(GREY, moved(box((-0.8, 0, -0.1), (0.8, 0.06, 0.1)), 45)),
        "heart_-30": Model().add(RED, moved(love, -30)),
    }


def cloths():
    def add(color, faces, *others):
        model = Model().add(color, faces, two_sided=True)
        for more in others:
            model.add(*more)
        return model

    def draped(x, z):
        """A blanket over a box of 0.8 m."""
        out = max(abs(x), abs(z)) - 0.42
        return 0.5 if out < 0 else max(0.5 - 2.2 * out, 0.02 + 0.015 * math.sin(14 * x + 9 * z))

    bar = box((-1.2, 0, -0.03), (-1.14, 1.8, 0.03)) + box((1.14, 0, -0.03), (1.2, 1.8, 0.03))
    umbrella = lathe([(1.0, 1.7), (0.9, 1.87), (0.65, 2.03), (0.33, 2.13), (0.01, 2.17)], 16, capped=False)
    net = sum((box((x, 0.5, -1), (x + 0.02, 0.52, 1)) + box((-1, 0.5, x), (1, 0.52, x + 0.02)) for x in [i * 0.2 - 1 for i in range(11)]), [])
    posts = sum((box((x, 0, z), (x + 0.05, 0.5, z + 0.05)) for x in (-1.02, 0.98) for z in (-1.02, 0.98)), [])
    flag = [[(a, 1.2 + 0.03 * math.sin(4 * a), 0.12 * math.sin(6 * a)), (b, 1.2 + 0.03 * math.sin(4 * b), 0.12 * math.sin(6 * b)),
             (b, 2 + 0.03 * math.sin(4 * b), 0.12 * math.sin(6 * b)), (a, 2 + 0.03 * math.sin(4 * a), 0.12 * math.sin(6 * a))] for a, b in
            ((0.05 + 0.06 * i, 0.11 + 0.06 * i) for i in range(20))]
    folds = [[(a, 0.02, 0.09 * math.sin(8 * a)), (b, 0.02, 0.09 * math.sin(8 * b)), (b, 1.8, 0.09 * math.sin(8 * b)), (a, 1.8, 0.09 * math.sin(8 * a))]
             for a, b in ((-1.1 + 0.055 * i, -1.045 + 0.055 * i) for i in range(40))]
    sail = [[(0, 0.3 + 2.7 * i / 12, 0), (1.6 * (1 - i / 12), 0.3 + 2.7 * i / 12, 0.25 * math.sin(math.pi * i / 12)),
             (1.6 * (11 - i) / 12, 0.3 + 2.7 * (i + 1) / 12, 0.25 * math.sin(math.pi * (i + 1) / 12)), (0, 0.3 + 2.7 * (i + 1) / 12, 0)] for i in range(12)]
    return {
        "waves": add(BLUE, sheet(lambda x, z: 0.08 * math.sin(5 * x + 2 * z), (-1, -1), (1, 1), 30)),
        "tent": add(YELLOW, sheet(lambda x, z: 0.05 + 0.9 * (1 - abs(x)) ** 1.3, (-1, -1), (1, 1), 24)),
        "hammock": add(RED, sheet(lambda x, z: 0.35 + 0.5 * x * x - 0.25 * (1 - z * z), (-1.1, -0.5), (1.1, 0.5), 24), (WOOD, bar)),
        "curtain": add(TEAL, moved(folds, 40)),
        "blanket_box": add(CLAY, sheet(draped, (-0.8, -0.8), (0.8, 0.8), 40)),
        "net": Model().add(WHITE, net).add(WOOD, posts),
        "umbrella": add(RED, umbrella, (GREY, lathe([(0.02, 0), (0.02, 2.17)], 8))),
        "carpet": Model().add(CLAY, box((-1.5, 0, -1), (1.5, 0.02, 1))).add(YELLOW, box((-1.2, 0.02, -0.7), (1.2, 0.024, 0.7))),
        "flag": add(RED, flag, (GREY, lathe([(0.03, 0), (0.03, 2.1)], 8))),
        "paper_curled": add(WHITE, sheet(lambda x, z: 0.3 * max(x, 0) ** 2 + 0.2 * max(-z, 0) ** 2 + 0.004, (-1, -0.7), (1, 0.7), 24)),
        "veil_over_ball": add((0.8, 0.5, 0.6, 0.5), sheet(lambda x, z: 0.02 + 0.75 * math.exp(-3 * (x * x + z * z)), (-1.1, -1.1), (1.1, 1.1), 30), (GREY, ball(0.33, (0, 0.34, 0)))),
        "sail": add(WHITE, moved(sail, 70), (WOOD, lathe([(0.04, 0), (0.03, 3.1)], 8))),
    }


def rooms():
    def room(low, high, *objects, color=WHITE):
        model = Model().add(color, box(low, high, inside=True))
        for shade, faces in objects:
            model.add(shade, faces)
        return model

    def walls(plan, height):
        """Walls, floor and ceiling around a plan, seen from above against the clock."""
        pairs = list(zip(plan, plan[1:] + plan[:1]))
        return [[(b[0], 0, b[1]), (a[0], 0, a[1]), (a[0], height, a[1]), (b[0], height, b[1])] for a, b in pairs]

    block = box((-0.4, 0, -0.4), (0.4, 0.8, 0.4))
    circle = [(2.5 * math.sin(2 * math.pi * i / 24), 2.5 * math.cos(2 * math.pi * i / 24)) for i in range(24)]
    floor, lid = [[(x, 0, z) for x, z in circle]], [[(x, 2.6, z) for x, z in circle[::-1]]]
    dome = lathe([(2.5, 0), (2.4, 0.8), (2.0, 1.6), (1.3, 2.2), (0.01, 2.5)], 24, capped=False)
    attic = [[(-2, 0, 3), (2, 0, 3), (2, 0, -3), (-2, 0, -3)], [(2, 0, 3), (0, 2.4, 3), (0, 2.4, -3), (2, 0, -3)],
             [(0, 2.4, 3), (-2, 0, 3), (-2, 0, -3), (0, 2.4, -3)], [(2, 0, 3), (-2, 0, 3), (0, 2.4, 3)], [(-2, 0, -3), (2, 0, -3), (0, 2.4, -3)]]
    plan = [(0, 0), (0, 6), (2.5, 6), (2.5, 2.5), (6, 2.5), (6, 0)]
    ell = walls(plan, 2.5) + [f for y, flip in ((0, 1), (2.5, -1)) for f in
                             ([(0, y, 6), (2.5, y, 6), (2.5, y, 0), (0, y, 0)][::flip], [(2.5, y, 2.5), (6, y, 2.5), (6, y, 0), (2.5, y, 0)][::flip])]
    open_wall = [[(-2, 0, 3), (-0.6, 0, 3), (-0.6, 2.5, 3), (-2, 2.5, 3)][::-1], [(0.4, 0, 3), (2, 0, 3), (2, 2.5, 3), (0.4, 2.5, 3)][::-1],
                 [(-0.6, 2, 3), (0.4, 2, 3), (0.4, 2.5, 3), (-0.6, 2.5, 3)][::-1]]
    doored = [f for f in box((-2, 0, -3), (2, 2.5, 3), inside=True) if not all(p[2] == 3 for p in f)] + open_wall
    bed = box((0.4, 0, -2.8), (1.9, 0.5, -0.9))
    pillars = sum((lathe([(0.3, 0), (0.25, 4)], 14, (x, z)) for x in (-2.5, 2.5) for z in (-5, -1.7, 1.7, 5)), [])
    thick = box((-2.2, -0.2, -3.2), (2.2, 2.7, 3.2)) + box((-2, 0, -3), (2, 2.5, 3), inside=True)
    shelves = sum((box((-1.98, 0.4 * i, -1), (-1.6, 0.4 * i + 0.03, 1)) for i in range(1, 5)), [])
    desk = box((0.3, 0.7, -2.9), (1.8, 0.75, -2.2)) + box((0.35, 0, -2.85), (0.4, 0.7, -2.3)) + box((1.7, 0, -2.85), (1.75, 0.7, -2.3))
    return {
        "room_4x6": room((-2, 0, -3), (2, 2.5, 3), (RED, block)),
        "cube_2m": room((-1, 0, -1), (1, 2, 1), (BLUE, moved(block, 20, to=(0.2, 0, -0.3)))),
        "hall_10x8": room((-5, 0, -4), (5, 3, 4), (CLAY, block), (TEAL, moved(block, 30, to=(2.5, 0, -2)))),
        "corridor": room((-1, 0, -8), (1, 2.5, 8), (YELLOW, moved(block, 10, to=(0.3, 0, -2)))),
        "round": Model().add(SAND, walls(circle, 2.6) + floor + lid).add(RED, block),
        "dome": Model().add(WHITE, [f[::-1] for f in dome] + floor).add(TEAL, block),
        "attic": Model().add(WOOD, attic).add(WHITE, moved(block, 25, to=(0, 0, -1))),
        "ell": Model().add(WHITE, ell).add(RED, moved(block, 15, to=(1.2, 0, 4.5))).add(BLUE, moved(block, 40, to=(4.6, 0, 1.2))),
        "with_door": Model().add(WHITE, doored).add(WOOD, bed),
        "thick_walls": Model().add(WHITE, thick).add(WOOD, bed),
        "pillars": room((-4, 0, -7), (4, 4, 7), (GREY, pillars), color=SAND),
        "study": room((-2, 0, -3), (2, 2.5, 3), (WOOD, shelves + desk), (TEAL, chair((1, 0, -1.8), 180))),
    }


def lights():
    def still(color=WHITE):
        """Two boxes and a ball on a board."""
        return Model().add(GREY, box((-2, -0.1, -2), (2, 0, 2))).add(color, box((-0.9, 0, -0.4), (-0.3, 0.9, 0.2)) + ball(0.4, (0.4, 0.4, 0.2))).add(
            WOOD, moved(box((-0.3, 0, -0.3), (0.3, 0.4, 0.3)), 30, to=(0.2, 0, -0.9)))

    def figure(color):
        return Model().add(color, lathe([(0.5, 0), (0.35, 0.15), (0.2, 0.5), (0.3, 0.9), (0.15, 1.1)], 24) + ball(0.28, (0, 1.35, 0)))

    above = (0.3, 2.2, 0.4)
    shade = Model().add(WHITE, box((-2, 0, -3), (2, 2.5, 3), inside=True)).add(RED, box((-0.4, 0, -0.4), (0.4, 0.8, 0.4)))
    return {
        "sun_10_lux": still().light("directional", above, 10),
        "sun_1000_lux": still().light("directional", above, 1000),
        "sun_100000_lux": still().light("directional", above, 100000),
        "lamp_30_cd": still().light("point", above, 30),
        "lamp_800_cd": still().light("point", above, 800),
        "lamp_54000_cd": still().light("point", above, 54000),
        "spot_2000_cd": still().light("spot", above, 2000),
        "red_blue_lamps": still().light("point", (-1.5, 1.5, 1), 200, (1, 0.2, 0.1)).light("point", (1.5, 1.5, 1), 200, (0.1, 0.3, 1)),
        "room_lamp_500_cd": shade.light("point", (0, 2.2, 0), 500),
        "white_figure": figure((0.95, 0.95, 0.95)),
        "black_figure": figure(BLACK),
        "glowing_sign": Model().add(BLACK, box((-1, 0.4, -0.05), (1, 1.2, 0.05))).add(BLACK, box((-0.8, 0.6, 0.05), (0.8, 1, 0.07)), glow=(1, 0.35, 0.1)).add(
            GREY, box((-0.04, 0, -0.04), (0.04, 0.4, 0.04))),
    }


KINDS = {"grounds": grounds, "signs": signs, "cloths": cloths, "rooms": rooms, "lights": lights}


def draw_sheet(kind, names):
    font = ImageFont.load_default(11)
    rows = -(-len(names) // COLUMNS)
    image = Image.new("RGB", (COLUMNS * (SIZE[0] + 2), rows * (SIZE[1] + LINE)), "white")
    draw = ImageDraw.Draw(image)
    for number, name in enumerate(names):
        x, y = number % COLUMNS * (SIZE[0] + 2), number // COLUMNS * (SIZE[1] + LINE)
        path = TO / kind / name / "frame_0000.png"
        if path.exists():
            image.paste(Image.open(path).convert("RGB"), (x, y))
        draw.text((x + 3, y + SIZE[1]), name, "black", font)
    image.save(TO / f"{kind}.png", optimize=True)


def main(*words):
    gobo = os.environ.get("GOBO", str(ROOT / "target/release/gobo"))
    failed = 0
    for kind, of in KINDS.items():
        models = of()
        (TO / kind).mkdir(parents=True, exist_ok=True)
        for name, model in models.items():
            if words and not any(word in f"{kind}/{name}" for word in words):
                continue
            path, start = TO / kind / f"{name}.glb", time.time()
            model.write(path)
            done = subprocess.run([gobo, "render", path, "--set", f"camera.size={list(SIZE)}", "-o", TO / kind / name], capture_output=True, text=True)
            failed += done.returncode != 0
            said = " ".join(line for line in done.stderr.splitlines() if not line.startswith("wrote"))
            print(f"{kind}/{name}: {time.time() - start:.1f} s{'' if done.returncode == 0 else ', failed'} {said[:300]}", flush=True)
        draw_sheet(kind, list(models))
    return failed


if __name__ == "__main__":
    sys.exit(bool(main(*sys.argv[1:])))
