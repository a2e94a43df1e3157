"""Makes the pictures of docs/python.md: `python pictures.py docs/python`. Needs matplotlib."""

import sys
from pathlib import Path

import gobo_shadows as gobo
import numpy as np
from matplotlib import pyplot

WHITE = {"transfer": "opaque", "tint": [0.8, 0.8, 0.8, 1.0]}


def knot(count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Places along a trefoil knot, and how far along it each is."""
    along = rng.uniform(0, 2 * np.pi, count)
    center = np.stack([np.sin(along) + 2 * np.sin(2 * along), np.cos(along) - 2 * np.cos(2 * along), -np.sin(3 * along)], axis=1)
    x, y, z = (center * [0.5, 0.5, 0.6] + rng.normal(0, 0.09, (count, 3))).T
    # Tilted back.
    lean = np.radians(50)
    return np.stack([x, y * np.cos(lean) + z * np.sin(lean) + 1.9, z * np.cos(lean) - y * np.sin(lean)], axis=1), along


def particles(folder: Path) -> None:
    rng = np.random.default_rng(1)
    positions, along = knot(200_000, rng)
    hues = 0.5 + 0.45 * np.cos(along[:, None] + [0, 2.1, 4.2])
    scene = gobo.Scene(shadow={"size": 1024})
    scene.add_particles(positions, radius=0.03, color=hues, opacity=0.06)
    scene.add_shape("plane", {**WHITE, "casts": False}, scale=(300, 1, 300))
    scene.add_light("directional", direction=(-0.75, -1, -0.1), intensity=3, source={"kind": "sun", "angle": 1})
    scene.render(gobo.Camera((0.8, 4.6, 5.4), (-0.55, 1.15, 0), fov=40, size=(800, 500))).save(folder / "particles.png")


def ball(count: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Splats on a table and on a ball, flat along the surfaces, as a trained scene has them."""
    table = rng.uniform(-2, 2, (count, 2))
    on_table = np.stack([table[:, 0], np.zeros(count), table[:, 1]], axis=1)
    outwards = rng.normal(0, 1, (count, 3))
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    on_ball = 0.6 * outwards + [0, 0.6, 0]
    squares = (np.floor(table * 2).sum(axis=1) % 2)[:, None]
    # Splats are thin along their y axis, which the shortest rotation turns outwards.
    standing = np.stack([1 + outwards[:, 1], outwards[:, 2], np.zeros(count), -outwards[:, 0]], axis=1)
    lying = np.tile([1.0, 0, 0, 0], (count, 1))
    return {
        "means": np.concatenate([on_table, on_ball]),
        "quats": np.concatenate([lying, standing]),
        "scales": np.tile([0.03, 0.003, 0.03], (2 * count, 1)),
        "opacities": np.full(2 * count, 0.9),
        "colors": np.concatenate([0.55 + 0.25 * squares + np.zeros((count, 3)), np.tile([0.75, 0.7, 0.62], (count, 1))]),
    }


def drawn(means: np.ndarray, colors: np.ndarray, camera: gobo.Camera) -> np.ndarray:
    """Round splats of one size, back to front: sRGB of linear colours."""
    width, height = camera.size
    eye, target = np.array(camera.eye), np.array(camera.target)
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, camera.up)
    right /= np.linalg.norm(right)
    local = (means - eye) @ np.stack([right, np.cross(right, ahead), ahead], axis=1)
    focal = height / 2 / np.tan(np.radians(camera.fov) / 2)
    columns = width / 2 + focal * local[:, 0] / local[:, 2]
    rows = height / 2 - focal * local[:, 1] / local[:, 2]
    picture = np.full((height, width, 3), 0.02)
    for i in np.argsort(-local[:, 2]):
        sigma = 0.03 * focal / local[i, 2]
        reach = int(np.ceil(3 * sigma))
        x, y = int(columns[i]), int(rows[i])
        if not (reach <= x < width - reach and reach <= y < height - reach):
            continue
        part = np.s_[y - reach : y + reach + 1, x - reach : x + reach + 1]
        offsets = np.arange(-reach, reach + 1) + 0.5
        squared = (offsets[:, None] + y - rows[i]) ** 2 + (offsets + x - columns[i]) ** 2
        alpha = 0.9 * np.exp(-squared / (2 * sigma**2))[..., None]
        picture[part] += alpha * (colors[i] - picture[part])
    linear = picture.clip(0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def splats(folder: Path) -> None:
    given = ball(30_000, np.random.default_rng(2))
    scene = gobo.Scene(shadow={"size": 1024, "nodes": 16}, environment={"ambient": [0.1, 0.1, 0.12]})
    cloud = scene.add_gaussians(**given)
    for i, tint in enumerate(([0.9, 0.15, 0.1, 1], [0.95, 0.75, 0.1, 1], [0.1, 0.35, 0.9, 1])):
        corners = np.array([[1.4, 0.1, 0], [1.4, 2.8, 0], [1.4, 2.8, 0.6], [1.4, 0.1, 0.6]]) + [0, 0, 0.6 * i - 0.9]
        scene.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], transfer="filter", tint=tint)
    scene.add_light("directional", direction=(-1, -0.75, 0.1), intensity=4)
    relit = scene.relight(cloud)
    camera = gobo.Camera((0.5, 2.6, 4.4), (-0.15, 0.3, 0), fov=36, size=(480, 400))
    before = drawn(given["means"], given["colors"], camera)
    after = drawn(given["means"], relit, camera)
    pyplot.imsave(folder / "splats.png", np.concatenate([before, np.ones((400, 8, 3)), after], axis=1))


def closed_form(folder: Path) -> None:
    scene = gobo.Scene(shadow={"size": 64, "nodes": 16})
    scene.add_light("directional", direction=(0, -1, 0))
    # Three discs, and a block of smoke between them.
    heights, opacities = np.array([0.5, 3.0, 3.5]), np.array([0.4, 0.3, 0.25])
    colors = np.array([[0.9, 0.3, 0.2], [0.2, 0.6, 0.9], [0.9, 0.9, 0.2]])
    centers = np.stack([0 * heights, heights, 0 * heights], axis=1)
    scene.add_particles(centers, 1.0, colors, opacities, profile="flat")
    scene.add_volume(np.ones((41, 11, 41)), 0.1, (-2, 1.2, -2), factor=0.6, color=(0.5, 0.8, 1.0))
    y = np.linspace(0, 4, 801)
    light = scene.light(np.stack([0 * y, y, 0 * y], axis=1))[:, 0]

    transmittances = 1 - opacities[:, None] * (1 - colors)
    discs = np.where(heights[:, None] > y, np.log(transmittances).T[:, :, None], 0).sum(axis=1).T
    # Density rises over a voxel on both ends: to 1 at 1.2 m, from 1 at 2.2 m.
    fine = np.linspace(0, 4, 40_001)
    density = np.interp(fine, [1.1, 1.2, 2.2, 2.3], [0, 1, 1, 0])
    above = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2) * (fine[1] - fine[0])])
    depth = np.interp(y, fine, above[-1] - above)
    exact = np.exp(discs - 0.6 * depth[:, None] * [0.5, 0.8, 1.0])

    figure, (upper, lower) = pyplot.subplots(2, 1, figsize=(8, 5), sharex=True, height_ratios=(3, 1), layout="constrained")
    for channel, color in enumerate(("#c03028", "#2c8c3c", "#2858c0")):
        upper.plot(y, exact[:, channel], color=color, linewidth=4, alpha=0.3, label=f"{'rgb'[channel]}, closed form")
        upper.plot(y, light[:, channel], color=color, linewidth=1, label=f"{'rgb'[channel]}, light()")
        # Within a bias of a disc it may be counted or not.
        near = (np.abs(y[:, None] - heights) < 0.02).any(axis=1)
        lower.plot(y, np.where(near, np.nan, light[:, channel] - exact[:, channel]), color=color, linewidth=1)
    upper.set_ylabel("share of the light")
    upper.legend(ncols=3, fontsize=8)
    lower.set_ylabel("difference")
    lower.set_xlabel("height of the point [m], light from above (right)")
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
    figure.savefig(folder / "closed_form.png", dpi=100)
    difference = np.abs(light - exact).max(axis=1)
    smoke = (y > 1.05) & (y < 2.35)
    print("largest difference:", difference[~near & ~smoke].max(), "and in the smoke", difference[smoke].max())


if __name__ == "__main__":
    target = Path(sys.argv[1])
    target.mkdir(parents=True, exist_ok=True)
    particles(target)
    splats(target)
    closed_form(target)
