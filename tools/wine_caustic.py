"""Writes data/gallery/wine_caustic.png: sunlight on a table behind the glass of wine of tools/wine_glass.py.

python3 tools/wine_caustic.py data/gallery/wine_caustic.png [RAYS]

Rays of 64 bits follow Snell's law and Fresnel's equations through glass and wine, are absorbed on their way
(Beer and Lambert), and are counted where they reach the table. The picture is the irradiance over that of the
bare table, for `gain` on a plane just above the table; prints its tint and its place. Needs numpy.
"""
import math
import struct
import sys
import zlib

import numpy as np

import wine_glass

SUN = (-0.5, -1.3, 0.72)  # direction of the light in data/gallery/wine.toml
ANGLE = 0.9  # whole, of the sun [degrees]
AIR, GLASS, WINE = range(3)
REFRACTION = np.array([1.0, 1.52, 1.345])
# What a centimetre leaves of the light.
LEFT = np.array([[1.0, 1.0, 1.0]] + [
    [share ** (0.01 / distance) for share in color]
    for color, distance in (wine_glass.GLASS_BODY, wine_glass.WINE_BODY)
])
CUTS = 8  # of a smooth segment of the profiles
MEETINGS = 16  # of a ray with surfaces, at most
CHUNK = 100_000  # rays at once
# The part of the table: along the sun's way and across it, from the middle of the foot [cm].
ALONG, ACROSS = (-8.0, 24.0), (-9.0, 9.0)
TEXELS = (512, 288)
HEIGHT = 0.3  # of the plane over the table [cm]
BARE = 99  # sRGB value of 1
BORDER = 1.5  # on which the picture goes to 1 [cm]


def linear(srgb):
    return srgb / 12.92 if srgb <= 0.04045 else ((srgb + 0.055) / 1.055) ** 2.4


SCALE = 1 / linear(BARE / 255)


class Surface:
    """Frusta of a profile: the body `inside` of them, and what is beyond."""

    def __init__(self, points, inside, beyond):
        self.inside, self.beyond = inside, beyond
        points = np.array(points)
        self.starts, self.ends = points[:-1], points[1:]
        ways = self.ends - self.starts
        flat = np.stack((ways[:, 1], -ways[:, 0]), 1) / np.hypot(*ways.T)[:, None]
        self.normals = np.stack((flat, flat), 1)
        sharp = wine_glass.corners([tuple(point) for point in points])
        for i in range(1, len(flat)):
            if not sharp[i]:
                mean = flat[i - 1] + flat[i]
                self.normals[i - 1, 1] = self.normals[i, 0] = mean / np.hypot(*mean)


def surfaces():
    """Glass in air, glass in wine, and the wine's mirror."""
    fine = wine_glass.smooth(wine_glass.GLASS, CUTS)
    foot = next(i for i, point in enumerate(fine) if point[0] > 0)
    rim = max(range(len(fine)), key=lambda i: fine[i][1])
    wet = next(i for i in range(rim, len(fine)) if fine[i][1] <= wine_glass.LEVEL)
    (r0, h0), (r1, h1) = fine[wet - 1], fine[wet]
    edge = (r0 + (r1 - r0) * (h0 - wine_glass.LEVEL) / (h0 - h1), wine_glass.LEVEL)
    return [
        Surface(fine[foot:wet] + [edge], GLASS, AIR),
        Surface([edge] + fine[wet:], GLASS, WINE),
        Surface([edge, (0, wine_glass.LEVEL)], WINE, AIR),
    ]


def cross(origin, way, start, end):
    """Least distances at which rays meet a frustum, and how far from start to end; infinite where they don't."""
    (r0, y0), (r1, y1) = start, end
    if abs(y1 - y0) < 1e-9:
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (y0 - origin[:, 1]) / way[:, 1]
            r = np.hypot(origin[:, 0] + t * way[:, 0], origin[:, 2] + t * way[:, 2])
        share = (r - r0) / (r1 - r0)
        return np.where((t > 1e-7) & (share >= 0) & (share <= 1), t, np.inf), share
    slope = (r1 - r0) / (y1 - y0)
    radius = r0 + slope * (origin[:, 1] - y0)
    a = way[:, 0] ** 2 + way[:, 2] ** 2 - (slope * way[:, 1]) ** 2
    b = origin[:, 0] * way[:, 0] + origin[:, 2] * way[:, 2] - slope * way[:, 1] * radius
    c = origin[:, 0] ** 2 + origin[:, 2] ** 2 - radius**2
    best = np.full(len(origin), np.inf)
    best_share = np.zeros(len(origin))
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - a * c)
        for t in ((-b - root) / a, (-b + root) / a):
            share = (origin[:, 1] + t * way[:, 1] - y0) / (y1 - y0)
            nearer = (t > 1e-7) & (share >= 0) & (share <= 1) & (t < best)
            best, best_share = np.where(nearer, t, best), np.where(nearer, share, best_share)
    return best, best_share


def meet(bodies, origin, way):
    """The first surface of each ray: distance, normal away from the inside, media inside and beyond."""
    count = len(origin)
    nearest, normal = np.full(count, np.inf), np.zeros((count, 2))
    inside, beyond = np.zeros(count, int), np.zeros(count, int)
    for body in bodies:
        for start, end, normals in zip(body.starts, body.ends, body.normals):
            t, share = cross(origin, way, start, end)
            at = np.flatnonzero(t < nearest)
            if len(at):
                nearest[at], inside[at], beyond[at] = t[at], body.inside, body.beyond
                normal[at] = normals[0] + share[at, None] * (normals[1] - normals[0])
    hit = np.isfinite(nearest)
    point = origin + np.where(hit, nearest, 0)[:, None] * way
    outward = point[:, ::2] / np.maximum(np.hypot(point[:, 0], point[:, 2]), 1e-12)[:, None]
    normal = np.stack((normal[:, 0] * outward[:, 0], normal[:, 1], normal[:, 0] * outward[:, 1]), 1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
    return nearest, point, normal, inside, beyond


def turn(way, normal, inside, beyond, chance):
    """The way on, refracted or by chance reflected, and the medium there."""
    enters = (way * normal).sum(1) < 0
    facing = np.where(enters[:, None], normal, -normal)
    before, behind = np.where(enters, beyond, inside), np.where(enters, inside, beyond)
    ratio = REFRACTION[before] / REFRACTION[behind]
    c0 = -(way * facing).sum(1)
    c1 = np.sqrt(np.maximum(1 - ratio**2 * (1 - c0**2), 0))
    across = (ratio * c0 - c1) / (ratio * c0 + c1)
    along = (c0 - ratio * c1) / (c0 + ratio * c1)
    reflects = chance < (across**2 + along**2) / 2
    mirrored = way + 2 * c0[:, None] * facing
    refracted = ratio[:, None] * way + (ratio * c0 - c1)[:, None] * facing
    way = np.where(reflects[:, None], mirrored, refracted)
    return way / np.linalg.norm(way, axis=1)[:, None], np.where(reflects, before, behind)


def basis():
    """Along the sun's way on the table, and across it, as `rotation` about y has them."""
    x, z = SUN[0] / math.hypot(SUN[0], SUN[2]), SUN[2] / math.hypot(SUN[0], SUN[2])
    return np.array([x, 0, z]), np.array([-z, 0, x])


def suns(u, v):
    """Directions over the sun's disc."""
    middle = np.array(SUN) / np.linalg.norm(SUN)
    side = np.cross(middle, (0, 1, 0))
    side /= np.linalg.norm(side)
    radius = math.tan(math.radians(ANGLE / 2)) * np.sqrt(u)
    x, y = radius * np.cos(2 * math.pi * v), radius * np.sin(2 * math.pi * v)
    ways = middle + x[:, None] * side + y[:, None] * np.cross(side, middle)
    return ways / np.linalg.norm(ways, axis=1)[:, None]


def count(picture, point, light):
    """Adds light at points of the table, over the four texels around each."""
    axes = basis()
    x = (point @ axes[0] - ALONG[0]) / (ALONG[1] - ALONG[0]) * TEXELS[0] - 0.5
    y = (point @ axes[1] - ACROSS[0]) / (ACROSS[1] - ACROSS[0]) * TEXELS[1] - 0.5
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    for i, wide in ((0, 1 - (x - column)), (1, x - column)):
        for j, high in ((0, 1 - (y - row)), (1, y - row)):
            at = (column + i >= 0) & (column + i < TEXELS[0]) & (row + j >= 0) & (row + j < TEXELS[1])
            np.add.at(picture, (row[at] + j, column[at] + i), (light * (wide * high)[:, None])[at])


def trace(bodies, rays):
    """Irradiance over that of the bare table."""
    height = max(point[1] for point in wine_glass.GLASS)
    reach = max(point[0] for point in wine_glass.GLASS) + 0.5
    length = height * math.hypot(SUN[0], SUN[2]) / -SUN[1]
    # Aims on the table, in what a cylinder around the glass shades.
    low, high = np.array([-reach, -reach]), np.array([length + reach, reach])
    axes = basis()
    cells = (ALONG[1] - ALONG[0]) * (ACROSS[1] - ACROSS[0]) / (TEXELS[0] * TEXELS[1])
    weight = np.prod(high - low) / cells / rays
    picture = np.zeros((TEXELS[1], TEXELS[0], 3))
    golden = 1.1673039782614187  # of R_4 (Roberts 2018)
    chances = np.random.default_rng(1)
    for first in range(0, rays, CHUNK):
        index = np.arange(first, min(first + CHUNK, rays))
        sequence = [(0.5 + index * golden**-k) % 1 for k in range(1, 5)]
        aim = low + np.stack(sequence[:2], 1) * (high - low)
        aim = aim[:, :1] * axes[0] + aim[:, 1:] * axes[1]
        way = suns(*sequence[2:])
        origin = aim - way * ((height + 1) / -way[:, 1])[:, None]
        light, medium = np.full((len(aim), 3), weight), np.zeros(len(aim), int)
        for meeting in range(MEETINGS):
            distance, point, normal, inside, beyond = meet(bodies, origin, way)
            with np.errstate(divide="ignore"):
                table = np.where(way[:, 1] < 0, -origin[:, 1] / way[:, 1], np.inf)
            lands = (table <= distance) & np.isfinite(table)
            if meeting == 0:
                # What misses the glass is the bare table's.
                count(picture, aim[~lands], np.full((np.count_nonzero(~lands), 3), -weight))
            else:
                left = light[lands] * LEFT[medium[lands]] ** table[lands, None]
                count(picture, origin[lands] + table[lands, None] * way[lands], left)
            on = ~lands & np.isfinite(distance)
            light = light[on] * LEFT[medium[on]] ** distance[on, None]
            origin = point[on]
            way, medium = turn(way[on], normal[on], inside[on], beyond[on], chances.random(len(origin)))
            if not len(origin):
                break
    return 1 + picture


def smooth(picture):
    """Without the rays' grain: the mean with its mirror, as the glass is round, and over 5 x 5 texels."""
    picture = (picture + picture[::-1]) / 2
    for axis in (0, 1):
        picture = sum(weight / 16 * np.roll(picture, shift, axis) for shift, weight in zip(range(-2, 3), (1, 4, 6, 4, 1)))
    return picture


def fade_to_bare(picture):
    """The same, with a border of 1."""
    size = (ALONG[1] - ALONG[0], ACROSS[1] - ACROSS[0])
    inner = 1.0
    for axis in (0, 1):
        at = (np.arange(TEXELS[axis]) + 0.5) / TEXELS[axis] * size[axis]
        share = np.clip(np.minimum(at, size[axis] - at) / BORDER - 0.1, 0, 1)
        rise = share**2 * (3 - 2 * share)
        inner = inner * (rise[None, :] if axis == 0 else rise[:, None])
    return 1 + (picture - 1) * inner[:, :, None]


def write(path, picture):
    """An sRGB PNG of light over SCALE."""
    light = np.clip(picture / SCALE, 0, 1)
    srgb = np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
    rows = np.round(srgb * 255).astype(np.uint8)
    data = b"".join(b"\0" + row.tobytes() for row in rows)

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", *TEXELS, 8, 2, 0, 0, 0)))
        file.write(chunk(b"IDAT", zlib.compress(data, 9)) + chunk(b"IEND", b""))


def main(path, rays):
    picture = smooth(trace(surfaces(), rays))
    write(path, fade_to_bare(picture))
    along, across = basis()
    # The plane lies where rays to its part of the table pass.
    middle = sum(ALONG) / 2 * along + sum(ACROSS) / 2 * across + np.array(SUN) * HEIGHT / SUN[1]
    size = (ALONG[1] - ALONG[0], ACROSS[1] - ACROSS[0])
    print(f"brightest {picture.max():.2f}, tint {SCALE:.4f}")
    print(f"translation = {(middle / 100).round(5).tolist()}")
    print(f"rotation = [0, {math.degrees(math.atan2(-along[2], along[0])):.3f}, 0]")
    print(f"scale = [{size[0] / 100}, 1, {size[1] / 100}]")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 2_000_000)
