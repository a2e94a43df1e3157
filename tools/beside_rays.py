"""Light on the floor of a scene of boxes, spheres, planes and panes, by gobo's look-up and by rays, and their difference.

python3 tools/beside_rays.py data/soft_lattice.toml docs/soft/rays_lattice.png -1.2 0.9 -1.1 1.0 [GOBO=target/release/gobo] [KEY=VALUE]...

The numbers are the part of the floor (y = 0) along x and z [m]. Each of its points sees 256 points of the first light's disc,
rectangle or sun, whose light each opaque shape takes and each other one filters; both as `gobo light` gives it, shares of 0 to 1.
Prints mean, 99th percentile and worst of the difference. Needs numpy and Pillow.
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib

import numpy as np
from PIL import Image, ImageDraw, ImageFont

WIDTH = 240  # of a picture [pixels]
SIDE = 16  # points of the light along an edge
GAIN = 4  # of the difference
GAP, WORDS = 8, 26  # [pixels]


def unit(v):
    return np.array(v, float) / np.linalg.norm(v)


def turned(degrees):
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_x @ about_y @ about_z


def source(light):
    """Points on the light; of a sun, directions to it."""
    u, v = (np.stack(np.meshgrid(*[(np.arange(SIDE) + 0.5) / SIDE] * 2), -1).reshape(-1, 2) * 2 - 1).T
    area = light["source"]
    toward = unit(light["direction"])
    right = unit(np.cross(toward, [0, 1, 0]) if abs(toward[1]) < 0.999 else np.cross(toward, [0, 0, 1]))
    up = np.cross(right, toward)
    if area["kind"] == "rect":
        u, v = u * area["width"] / 2, v * area["height"] / 2
    else:
        # Equal areas of a disc (Shirley and Chiu 1997).
        flat = abs(u) > abs(v)
        r = np.where(flat, u, v)
        angle = np.where(flat, np.pi / 4 * v / np.where(flat, u, 1), np.pi / 2 - np.pi / 4 * u / np.where(flat, 1, v))
        sun = area["kind"] == "sun"
        radius = np.tan(np.radians(area.get("angle", 0.53) / 2)) if sun else area["radius"]
        u, v = radius * r * np.cos(angle), radius * r * np.sin(angle)
    spread = u[:, None] * right + v[:, None] * up
    return spread - toward if area["kind"] == "sun" else spread + light["position"]


def passed(shape, material, start, way, ends):
    """What is left of light along `way` behind a shape: one number, or three."""
    scale = np.array(shape.get("scale", [1, 1, 1]), "f4")
    turn = turned(shape.get("rotation", [0, 0, 0])).astype("f4")
    p = (start - np.array(shape.get("translation", [0, 0, 0]), "f4")) @ turn / scale
    d = way @ turn / scale
    with np.errstate(all="ignore"):
        if shape["kind"] == "box":
            near, far = np.sort([(-0.5 - p) / d, (0.5 - p) / d], axis=0)
            near, far = near.max(-1), far.min(-1)
        elif shape["kind"] == "sphere":
            a, b, c = (d * d).sum(-1), (p * d).sum(-1), (p * p).sum(-1) - 0.25
            root = np.sqrt(b * b - a * c)
            near, far = (-b - root) / a, (-b + root) / a
        else:
            axis = {"plane": 1, "pane": 2}[shape["kind"]]
            near = -p[..., axis] / d[..., axis]
            q = p + near[..., None] * d
            inside = (abs(np.delete(q, axis, -1)) < 0.5).all(-1)
            near, far = np.where(inside, near, np.nan), np.full(near.shape, np.nan)
        meets = [(t > 1e-4) & (t < ends) & (near <= far) for t in (near, far)] if shape["kind"] in ("box", "sphere") else [
            (near > 1e-4) & (near < ends)
        ]
    transfer, tint = material.get("transfer", "filter"), np.array(material.get("tint", [1, 1, 1, 1]), float)
    if transfer == "opaque":
        return ~np.any(meets, axis=0)[..., None]
    if transfer != "filter" or "texture" in material or "attenuation_distance" in material:
        sys.exit(f"material {material['name']}: only opaque ones and filters without texture and attenuation")
    color = (1 - tint[3] * (1 - tint[:3])).astype("f4")
    return color ** np.sum(meets, axis=0)[..., None]


def rays(scene, points):
    light = scene["light"][0]
    materials = {m["name"]: m for m in scene["material"]}
    lamp, sun = source(light).astype("f4"), light["source"]["kind"] == "sun"
    light_at = np.zeros((len(points), 3))
    for part in np.array_split(np.arange(len(points)), max(1, len(points) // 500)):
        start = points[part, None, :].astype("f4")
        way = np.broadcast_to(lamp, (len(part), *lamp.shape)) if sun else lamp - start
        left = np.ones((*way.shape[:2], 3), "f4")
        for shape in scene["shape"]:
            material = materials[shape["material"]]
            if material.get("casts", True):
                left = left * passed(shape, material, start, way, np.inf if sun else 1)
        light_at[part] = left.mean(1)
    return light_at


def main(scene_path, path, *more):
    x0, x1, z0, z1 = map(float, more[:4])
    sets = list(more[4:])
    gobo = next((s[5:] for s in sets if s.startswith("GOBO=")), "target/release/gobo")
    sets = [s for s in sets if not s.startswith("GOBO=")]
    scene = tomllib.loads(pathlib.Path(scene_path).read_text())
    height = round(WIDTH * (z1 - z0) / (x1 - x0))
    x, z = np.meshgrid(x0 + (x1 - x0) * (np.arange(WIDTH) + 0.5) / WIDTH, z0 + (z1 - z0) * (np.arange(height) + 0.5) / height)
    points = np.stack([x, 0 * x, z], -1).reshape(-1, 3)
    with tempfile.TemporaryDirectory() as folder:
        ask, answer = os.path.join(folder, "points.npy"), os.path.join(folder, "light.npy")
        np.save(ask, np.hstack([points, np.tile([0, 1, 0], (len(points), 1))]).astype("<f4"))
        words = [word for s in sets for word in ("--set", s)]
        subprocess.run([gobo, "light", scene_path, "--points", ask, "-o", answer, *words], check=True)
        ours = np.load(answer)[:, 0, :]
    truth = rays(scene, points)
    wrong = abs(ours - truth)
    print(f"mean {wrong.mean():.4f}, 99 % {np.quantile(wrong.max(1), 0.99):.3f}, worst {wrong.max():.2f}")
    pictures = [("gobo", ours), ("256 rays", truth), (f"difference x {GAIN}", GAIN * wrong)]
    strip = Image.new("RGB", (3 * WIDTH + 2 * GAP, height + WORDS), "white")
    draw, font = ImageDraw.Draw(strip), ImageFont.load_default(14)
    for i, (word, light) in enumerate(pictures):
        light = np.clip(light, 0, 1)
        srgb = np.where(light < 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        picture = Image.fromarray(np.round(255 * srgb).astype("u1").reshape(height, WIDTH, 3))
        strip.paste(picture, (i * (WIDTH + GAP), 0))
        draw.text((i * (WIDTH + GAP) + WIDTH / 2, height + WORDS / 2), word, "black", font, "mm")
    grey = strip.convert("L")
    (grey if grey.convert("RGB") == strip else strip).save(path, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
