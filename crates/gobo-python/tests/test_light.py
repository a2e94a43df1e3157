"""Light at points beside the formulas of docs/scene.md, which share nothing with the code."""

import gobo_shadows as gobo
import numpy as np
import pytest
from conftest import heights, pane

HALF_STEP = 1.5e-3


def test_discs_filter_by_the_product_of_their_transmittances(down):
    """T = 1 - a (1 - c) for each disc above the point, and for no other."""
    ys = np.array([1.0, 2.0, 3.0, 4.0])
    colors = np.array([[1.0, 0.5, 0.2], [0.3, 0.9, 0.6], [0.8, 0.1, 1.0], [0.4, 0.4, 0.7]])
    opacities = np.array([0.5, 0.25, 0.8, 0.3])
    centers = np.stack([0 * ys, ys, 0 * ys], axis=1)
    assert down.add_particles(centers, 1.0, colors, opacities, profile="flat") == 4
    points = np.array([0.5, 1.5, 2.5, 3.5, 4.5])
    light = down.light(heights(*points))
    assert light.shape == (5, 1, 3) and light.dtype == np.float32
    transmittances = 1 - opacities[:, None] * (1 - colors)
    expected = [transmittances[ys > y].prod(axis=0) for y in points]
    np.testing.assert_allclose(light[:, 0], expected, atol=HALF_STEP)
    # Beside the discs there is nothing in between.
    np.testing.assert_array_equal(down.light([[5, 0, 0]]), 1)


@pytest.mark.parametrize(
    "transfer, formula",
    [
        ("filter", lambda a, c: 1 - a * (1 - c)),
        ("stain", lambda a, c: c * (1 - a)),
        ("smoke", lambda a, c: (1 - a) * (1 - a * (1 - c))),
        ("none", lambda a, c: np.ones(3)),
        ("opaque", lambda a, c: np.zeros(3)),
    ],
)
def test_panes_of_each_transfer(down, transfer, formula):
    color, alpha = np.array([0.9, 0.5, 0.25]), 0.4
    vertices, faces = pane(2.0)
    assert down.add_mesh(vertices, faces, {"transfer": transfer, "tint": [*color, alpha]}) == 2
    light = down.light(heights(0.0))[0, 0]
    np.testing.assert_allclose(light, formula(alpha, color), atol=HALF_STEP)


def test_a_shape_is_where_it_is_put(down):
    """However small: scene files of small shapes are moved near the origin."""
    for scale in (1.0, 0.05, 1e-3):
        scene = gobo.Scene()
        scene.add_shape("box", translation=(3, 0.7, -0.2), scale=scale)
        half = scale / 2
        np.testing.assert_allclose(
            scene.bounds, [[3 - half, 0.7 - half, -0.2 - half], [3 + half, 0.7 + half, -0.2 + half]], atol=1e-6
        )


def test_a_soft_disc_has_its_profile(down):
    """Opacity (1 - (q / r)^2)^2 at the distance q."""
    down.configure(shadow={"size": 1024, "receiver": "curve", "filter": {"kind": "spline"}})
    down.add_particles([[0, 1, 0]], 1.0, (0, 0, 0), 0.8)
    q = np.array([0.0, 0.3, 0.6, 0.9])
    light = down.light(np.stack([q, 0 * q, 0 * q], axis=1))[:, 0, 0]
    np.testing.assert_allclose(light, 1 - 0.8 * (1 - q**2) ** 2, atol=4e-3)


@pytest.mark.parametrize("cast", ["neutral", "own", "none"])
def test_a_splat_filters_by_its_opacity(down, cast):
    color = np.array([0.8, 0.4, 0.1])
    splats = down.add_gaussians([[0, 2, 0]], [[1, 0, 0, 0]], [[2.0, 0.1, 2.0]], [0.6], [color], cast=cast)
    assert (splats.rows, splats.count) == (1, 1)
    light = down.light(heights(0.0))[0, 0]
    expected = {"neutral": 1 - 0.6 * np.ones(3), "own": 1 - 0.6 * (1 - color), "none": np.ones(3)}
    np.testing.assert_allclose(light, expected[cast], atol=5e-3)


def test_quats_are_wxyz(down):
    """A needle along x, turned by 90 degrees about y: along z."""
    half = np.sqrt(0.5)
    down.configure(shadow={"size": 512, "receiver": "curve"})
    down.add_gaussians([[0, 2, 0]], [[3 * half, 0, 3 * half, 0]], [[1.0, 0.05, 0.05]], [0.9], [[0, 0, 0]])
    along_x, along_z = down.light([[0.7, 0, 0], [0, 0, 0.7]])[:, 0, 0]
    assert along_x > 0.99 and along_z < 0.4


def test_a_volume_absorbs_exponentially(down):
    """T = exp(-factor * density * length * color) through 8 voxels of 0.1 m, with half a voxel of ramp at each end."""
    density = np.full((21, 8, 21), 2.0)
    color = np.array([1.0, 0.5, 0.25])
    down.add_volume(density, 0.1, (-1, 1, -1), factor=1.5, color=color)
    light = down.light(heights(0.0))[0, 0]
    np.testing.assert_allclose(light, np.exp(-1.5 * 2.0 * 0.8 * color), rtol=4e-3)
    # Axes are x, y, z: it is wide in x.
    assert down.light([[0.9, 0, 0]])[0, 0, 0] < 0.5


def test_channels_of_a_volume_absorb_their_own(down):
    """Each channel by its own density, the last of which rises along x, times `color`."""
    density = np.zeros((21, 8, 21, 3))
    density[..., 0], density[..., 1], density[..., 2] = 2.0, 0.5, 1.0
    density[13:, :, :, 2] = 3.0
    down.add_volume(density, 0.1, (-1, 1, -1), factor=1.5, color=(1, 1, 0.5))
    light = down.light([[-0.5, 0, 0], [0.7, 0, 0]])[:, 0]
    depths = [[2.0, 0.5, 0.5], [2.0, 0.5, 1.5]]
    np.testing.assert_allclose(light, np.exp(-1.5 * 0.8 * np.array(depths)), rtol=6e-3)


def test_densities_of_any_size_keep_their_product(down):
    for scale in (1e-8, 1e8):
        scene = gobo.Scene(shadow={"size": 64})
        scene.add_light(direction=(0, -1, 0))
        scene.add_volume(np.full((9, 10, 9), 2.0 * scale), 0.1, (-0.4, 1, -0.4), factor=min(0.5 / scale, 1e6))
        expected = np.exp(-2.0 * scale * min(0.5 / scale, 1e6))
        np.testing.assert_allclose(scene.light(heights(0.0)), expected, rtol=4e-3)


def test_glass_attenuates_by_its_thickness(down):
    tint = {"attenuation_color": [0.9, 0.5, 0.2], "attenuation_distance": 0.5, "transfer": "filter", "tint": [1, 1, 1, 0]}
    down.add_shape("box", tint, translation=(0, 2, 0), scale=(1, 1.5, 1))
    light = down.light(heights(0.0))[0, 0]
    np.testing.assert_allclose(light, np.array([0.9, 0.5, 0.2]) ** (1.5 / 0.5), atol=5e-3)


def test_each_light_has_a_column(down):
    vertices, faces = pane(1.0)
    down.add_mesh(vertices, faces, transfer="opaque")
    down.add_light("point", name="lamp", position=(0, 0.5, 0))
    assert down.lights == ["sun", "lamp"]
    light = down.light(heights(0.0, 2.0))
    np.testing.assert_array_equal(light[:, :, 0], [[0, 1], [1, 0]])
    down.remove_lights()
    assert down.light(heights(0.0)).shape == (1, 0, 3)


def test_far_from_the_origin_nothing_changes():
    """4e6 m away 32 bits have steps of a quarter of a metre."""
    found = []
    for origin in ((0.0, 0.0, 0.0), (4e6, 100.0, -3e6)):
        scene = gobo.Scene(origin=origin, shadow={"size": 64, "receiver": "curve"})
        scene.add_light("spot", position=np.add(origin, (0, 5, 0)), direction=(0, -1, 0), angle=30)
        scene.add_particles(np.add(origin, [[0, 1, 0], [0.1, 2, 0]]), 0.3, (0.2, 0.5, 0.7), 0.5)
        scene.add_mesh(np.add(origin, [[0.2, 1, -1], [1, 1, -1], [1, 1, 1]]), [[0, 1, 2]], transfer="opaque")
        points = np.add(origin, [[0, 0, 0], [0.1, 1.5, 0], [0.3, 0, 0]])
        maps = scene.maps()
        eye = maps["clip_from_world"] @ [*np.add(origin, (0, 2, 0)), 1]
        found.append((scene.light(points), maps["filter"], eye, scene.bounds - np.asarray(origin)))
    for near, far in zip(*found):
        np.testing.assert_allclose(near, far, atol=1e-5)
    assert found[0][0].min() < 0.9


def test_splats_that_are_shadowed_are_darker(down):
    down.configure(shadow={"size": 128, "receiver": "curve"}, environment={"ambient": [0, 0, 0]})
    vertices, faces = pane(3.0)
    down.add_mesh(vertices, faces, transfer="filter", tint=[0.5, 0.25, 1.0, 1.0])
    means = [[0, 1, 0], [9, 1, 0], [np.nan, 0, 0]]
    with pytest.warns(gobo.GoboWarning, match="1 gaussian not finite"):
        splats = down.add_gaussians(
            means, np.tile([1, 0, 0, 0], (3, 1)), np.full((3, 3), 0.05), np.full(3, 0.9), np.full((3, 3), 0.8)
        )
    assert (splats.rows, splats.count, splats.skipped) == (3, 2, {"gaussian not finite": 1})
    colors = down.relight(splats)
    np.testing.assert_allclose(colors, 0.8 * np.array([[0.5, 0.25, 1], [1, 1, 1], [1, 1, 1]]), atol=5e-3)
    factors = down.relight(splats, factors=True)
    np.testing.assert_allclose(factors * 0.8, colors, atol=1e-6)
    np.testing.assert_array_equal(down.relight(), colors[:2])
    with pytest.raises(gobo.InputError, match="of this scene"):
        gobo.Scene().relight(splats)


def test_the_reference_agrees_with_the_adapter(down, rng):
    down.add_particles(rng.uniform(-1, 1, (200, 3)), 0.3, rng.uniform(0, 1, (200, 3)), 0.3, shape="puff")
    points = rng.uniform(-1, 1, (50, 3))
    with_adapter = down.light(points)
    try:
        gobo.use_adapter("cpu")
        assert gobo.adapter() == "the CPU reference"
        reference = down.light(points)
    finally:
        gobo.use_adapter()
    np.testing.assert_allclose(with_adapter, reference, atol=2e-3)
    assert np.ptp(reference) > 0.3
