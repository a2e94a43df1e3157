"""What arrays and tables may be, and what is said of those that may not."""

import pickle
import tracemalloc

import gobo_shadows as gobo
import numpy as np
import pytest
from conftest import heights, pane


def quats(count):
    return np.tile([1.0, 0, 0, 0], (count, 1))


@pytest.mark.parametrize(
    "positions",
    [
        np.array([[0, 1, 0], [0, 2, 0]], np.float32),
        np.array([[0, 1, 0], [0, 2, 0]], np.float64),
        np.array([[0, 1, 0], [0, 2, 0]], np.float16),
        np.array([[0, 1, 0], [0, 2, 0]], np.int32),
        np.array([[0, 1, 0], [0, 2, 0]], ">f4"),
        np.array([[0, 1, 0, 7], [9, 9, 9, 9], [0, 2, 0, 7]], np.float32)[::2, :3],
        np.asfortranarray(np.array([[0, 1, 0], [0, 2, 0]], np.float32)),
        np.array([[0, 2, 0], [0, 1, 0]], np.float32)[::-1],
        [[0, 1, 0], [0, 2, 0]],
        [(0, 1.0, 0), (0, 2, 0)],
    ],
)
def test_any_type_and_stride_is_read(down, positions):
    assert down.add_particles(positions, 1.0, (0, 0, 0), 0.5, profile="flat") == 2
    np.testing.assert_allclose(down.light(heights(0, 1.5))[:, 0, 0], [0.25, 0.5], atol=2e-3)


def test_arrays_that_cannot_be_written_are_read(down):
    positions = np.array([[0, 1, 0]], np.float32)
    positions.flags.writeable = False
    assert down.add_particles(positions, 1.0) == 1


@pytest.mark.parametrize(
    "change",
    [
        {"positions": np.zeros((4, 2))},
        {"positions": np.zeros(3)},
        {"positions": np.zeros((2, 4, 3))},
        {"positions": np.zeros((4, 3), complex)},
        {"positions": np.zeros((4, 3), bool)},
        {"positions": [["a", "b", "c"]]},
        {"positions": [[0, 1], [2]]},
        {"positions": object()},
        {"positions": None},
        {"positions": np.ma.masked_array(np.zeros((4, 3)), True)},
        {"radius": np.ones(3)},
        {"radius": np.ones((4, 2))},
        {"radius": None},
        {"radius": "wide"},
        {"color": np.ones((3, 3))},
        {"color": np.ones((4, 2))},
        {"color": 1.0},
        {"opacity": np.ones(5)},
        {"color": np.ones((4, 4)), "opacity": 0.5},
        {"rotation": np.ones(2)},
        {"material": 7},
        {"material": "unknown"},
        {"transfer": "glass"},
        {"tranfser": "filter"},
        {"transfer": object()},
        {"tint": [1, 2, 3, 1]},
        {"tint": [np.nan, 0, 0, 1]},
        {"texture": np.zeros((4, 4))},
        {"texture": "/does/not/exist.png"},
        {"emission": 10**30},
    ],
)
def test_particles_refuse(down, change):
    given = {"positions": np.zeros((4, 3)), "radius": 0.1, **change}
    with pytest.raises(gobo.GoboError) as caught:
        down.add_particles(given.pop("positions"), given.pop("radius"), **given)
    assert caught.value.remedy and "help:" in str(caught.value)
    assert down.counts["particles"] == 0
    assert isinstance(caught.value, (gobo.InputError, gobo.SceneError))


def test_errors_are_values_errors_too(down):
    with pytest.raises(ValueError):
        down.light(np.zeros((3, 2)))
    with pytest.raises(gobo.GoboError, match="probably|transfer") as caught:
        down.add_particles([[0, 0, 0]], 1, tranfser="filter")
    assert "transfer" in caught.value.remedy
    assert isinstance(pickle.loads(pickle.dumps(caught.value)), gobo.InputError)


def test_rows_that_cannot_be_used_are_counted_and_change_nothing(down):
    good = down.light(heights(0))
    positions = np.array([[0, 1, 0], [np.nan, 1, 0], [0, np.inf, 0], [0, 1e9, 0], [0, 1, 0], [0, 1, 0], [0, 1, 0]])
    radius = [1, 1, 1, 1, 0, -1, 1]
    opacity = [0, 1, 1, 1, 1, 1, 2]
    with pytest.warns(gobo.GoboWarning, match="2 not finite"):
        assert down.add_particles(positions, radius, (0, 0, 0), opacity) == 1
    assert down.skipped == {"not finite": 2, "too far": 1, "radius not positive": 2, "alpha out of range": 1}
    np.testing.assert_array_equal(down.light(heights(0)), good)
    assert down.bounds[1].max() < 5
    # Numbers that overflow 32 bits are not finite there.
    with pytest.warns(gobo.GoboWarning, match="1 not finite"):
        assert down.add_particles([[1e300, 0, 0]], 1.0) == 0


@pytest.mark.parametrize(
    "change",
    [
        {"quats": quats(3)},
        {"quats": np.zeros((2, 3))},
        {"scales": np.ones((1, 3))},
        {"opacities": np.ones(1)},
        {"opacities": np.ones((2, 2))},
        {"colors": np.ones((2, 4))},
        {"cast": "red"},
        {"density": -1.0},
        {"material": {"shape": "cube"}},
    ],
)
def test_gaussians_refuse(down, change):
    given = {
        "means": np.zeros((2, 3)),
        "quats": quats(2),
        "scales": np.ones((2, 3)),
        "opacities": np.ones(2),
        "colors": np.ones((2, 3)),
        **change,
    }
    with pytest.raises(gobo.InputError):
        down.add_gaussians(**given)
    assert down.counts["gaussians"] == 0


def test_gaussians_are_left_out_by_reason(down):
    scales = [[0.1, 0.1, 0.1], [-1, 1, 1], [0.1, 0.1, 0], [1, 1, 1]]
    rotations = quats(4)
    rotations[3] = 0
    with pytest.warns(gobo.GoboWarning):
        splats = down.add_gaussians(np.zeros((4, 3)), rotations, scales, [[0.5]] * 4, np.full((4, 3), 1.2))
    assert splats.count == 2 and sum(splats.skipped.values()) == 2, splats.skipped


def test_meshes_refuse(down):
    vertices, faces = pane(1.0)
    for wrong in ([[0, 1, 4]], [[0, 1, -1]], [[0.5, 1, 2]], [[0, 1]], np.zeros((1, 4), int)):
        with pytest.raises(gobo.InputError):
            down.add_mesh(vertices, wrong)
    for change in ({"normals": vertices[:2]}, {"uvs": vertices}, {"colors": np.ones((2, 3))}):
        with pytest.raises(gobo.InputError):
            down.add_mesh(vertices, faces, **change)
    glass = {"attenuation_color": [0.5, 0.5, 0.5], "attenuation_distance": 1.0}
    with pytest.raises(gobo.InputError, match="inside"):
        down.add_mesh(vertices, faces, glass)
    vertices[0, 0] = np.inf
    with pytest.warns(gobo.GoboWarning, match="2 triangle not finite"):
        assert down.add_mesh(vertices, faces) == 0
    assert down.counts["triangles"] == 0


def test_mesh_colors_multiply_the_tint(down):
    vertices, faces = pane(1.0)
    down.add_mesh(vertices, faces.astype(np.uint16), tint=[1, 0.5, 1, 1], colors=(0.25, 1, 1))
    np.testing.assert_allclose(down.light(heights(0))[0, 0], [0.25, 0.5, 1], atol=4e-3)


def test_textures_are_arrays(down):
    image = np.zeros((2, 2, 4), np.uint8)
    image[..., :3], image[..., 3] = 255, 255
    image[..., 1] = 0
    vertices, faces = pane(1.0)
    uvs = np.full((4, 2), 0.5)
    down.add_mesh(vertices, faces, texture=image, uvs=uvs)
    np.testing.assert_allclose(down.light(heights(0))[0, 0], [1, 0, 1], atol=2e-3)
    down.add_particles([[9, 1, 0]], 1.0, texture=image[..., :3], shape="quad")
    assert down.counts["textures"] == 2


def test_volumes_refuse(down):
    cube = np.ones((4, 4, 4))
    for density in (np.ones(4), np.ones((4, 4)), np.ones((4, 4, 4, 1)), np.ones((4, 4, 4, 3, 1)), np.ones((2, 2, 2), complex)):
        with pytest.raises(gobo.InputError):
            down.add_volume(density)
    for change in (
        {"spacing": 0},
        {"spacing": np.nan},
        {"factor": -1},
        {"factor": np.nan},
        {"color": (2, 0, 0)},
        {"color": (1, 1)},
        {"anisotropy": 1},
        {"origin": (np.nan, 0, 0)},
        {"matrix": np.eye(3)},
        {"matrix": np.zeros((4, 4))},
        {"origin": (9e8, 0, 0)},
    ):
        with pytest.raises(gobo.InputError):
            down.add_volume(cube, **change)
    assert down.counts["bricks"] == 0
    cube[0, 0, 0], cube[1, 1, 1] = np.nan, -1
    with pytest.warns(gobo.GoboWarning, match="2 voxel"):
        down.add_volume(cube)


def test_lights_refuse(down):
    for kind, keys in [
        ("spot", {}),
        ("sun", {}),
        ("directional", {"direction": (0, 0, 0)}),
        ("directional", {"direction": (0, np.nan, 0)}),
        ("point", {"position": (0, 1)}),
        ("point", {"position": (0, 1, 0), "intensity": -1}),
        ("point", {"position": (0, 1, 0), "colour": (1, 1, 1)}),
        ("directional", {"direction": (0, -1, 0), "name": "sun"}),
        ("directional", {"direction": (0, -1, 0), "source": {"kind": "sphere", "radius": 1}}),
    ]:
        with pytest.raises(gobo.InputError) as caught:
            down.add_light(kind, **keys)
        assert caught.value.remedy
    assert down.lights == ["sun"]
    nested = {}
    nested["source"] = nested
    with pytest.raises(gobo.InputError, match="deep"):
        down.add_light(**nested)


def test_scenes_and_settings_refuse():
    for tables in ({"shadow": {"size": 7}}, {"shadows": {}}, {"shadow": 3}, {"camera": {}}, {"air": {"density": "thick"}}):
        with pytest.raises(gobo.InputError):
            gobo.Scene(**tables)
    with pytest.raises(gobo.InputError):
        gobo.Scene(origin=(0, 0, np.inf))
    with pytest.raises(TypeError):
        pickle.dumps(gobo.Scene())


def test_an_empty_scene_is_one(down):
    assert down.bounds is None and down.camera is None
    assert down.add_particles(np.zeros((0, 3)), 1.0) == 0
    assert down.add_particles([], np.zeros(0)) == 0
    assert down.add_mesh(np.zeros((0, 3)), np.zeros((0, 3), int)) == 0
    assert down.add_volume(np.zeros((0, 4, 4))) == 0
    assert down.add_volume(np.zeros((4, 4, 4))) == 0
    splats = down.add_gaussians(np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)))
    assert down.relight(splats).shape == (0, 3) and down.relight().shape == (0, 3)
    assert down.light(np.zeros((0, 3))).shape == (0, 1, 3)
    assert down.light([]).shape == (0, 1, 3)
    np.testing.assert_array_equal(down.maps()["filter"], 1)
    assert down.render(size=(8, 4)).shape == (4, 8, 3)


def test_points_that_are_none_name_their_row(down):
    for bad in (np.nan, np.inf, 1e8):
        with pytest.raises(gobo.InputError, match="row 1"):
            down.light([[0, 0, 0], [0, bad, 0]])
    with pytest.raises(gobo.InputError, match="row 0"):
        down.light([[0, 0, 0]], [[np.nan, 0, 0]])
    with pytest.raises(gobo.InputError, match="normals"):
        down.light(heights(0, 1), [[0, 1, 0]])


def test_what_is_too_large_is_refused_before_memory_is_taken(down):
    # A view of one number, without memory for the others.
    many = np.broadcast_to(np.float32(0), (16_000_001, 3))
    with pytest.raises(gobo.InputError, match="at most"):
        down.add_particles(many, 1.0)
    with pytest.raises(gobo.InputError, match="4096"):
        down.render(gobo.Camera((0, 1, 3), size=(5000, 10)))
    with pytest.raises(gobo.InputError):
        down.render(size=(100_000, 100_000))
    with pytest.raises(gobo.InputError, match="1048576"):
        down.add_volume(np.zeros((1 << 21, 1, 1)))
    for i in range(1, 4096):
        down.add_light("point", position=(0, i, 0), casts=False)
    with pytest.raises(gobo.InputError, match="at most"):
        down.add_light("point", position=(0, 1, 0))


def test_a_contiguous_array_is_not_copied_by_python(down):
    positions = np.zeros((1_000_000, 3), np.float32)
    tracemalloc.start()
    down.add_particles(positions, 1.0, (0, 0, 0), 0.001)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1 << 20, f"{peak} bytes"


class Tensor:
    """What tells of a tensor."""

    def __init__(self, array, kind=1, requires_grad=False):
        self.array, self.kind, self.requires_grad = array, kind, requires_grad
        self.device = "cuda:0" if kind == 2 else "cpu"

    def __dlpack_device__(self):
        if self.kind is None:
            raise ValueError("Unknown device type meta for Dlpack")
        return (self.kind, 0)

    def __dlpack__(self, **keys):
        return self.array.__dlpack__()


def test_tensors(down):
    positions = np.array([[0, 1, 0]], np.float32)
    assert down.add_particles(Tensor(positions), 1.0) == 1
    with pytest.raises(gobo.InputError, match="cuda:0") as caught:
        down.add_particles(Tensor(positions, kind=2), 1.0)
    assert "CPU" in caught.value.remedy
    away = Tensor(positions, kind=2)
    away.cpu = lambda: Tensor(positions)
    with pytest.warns(gobo.GoboWarning, match="positions is on cuda:0, and is copied"):
        assert down.add_particles(away, 1.0) == 1
    assert down.counts["particles"] == 2
    with pytest.raises(gobo.InputError, match="gradients") as caught:
        down.light(Tensor(positions, requires_grad=True))
    assert "detach" in caught.value.remedy
    with pytest.raises(gobo.InputError, match="no memory"):
        down.add_particles(Tensor(positions, kind=None), 1.0)


def test_tensors_of_torch():
    """Where it is installed."""
    torch = pytest.importorskip("torch")
    rng = np.random.default_rng(3)
    given = [rng.uniform(0, 1, shape).astype(np.float32) for shape in ((200, 3), (200,), (200, 3), (200,))]
    found = []
    for parts in (given, [torch.from_numpy(part) for part in given]):
        scene = gobo.Scene(shadow={"size": 64, "receiver": "curve"})
        scene.add_light(direction=(0, -1, 0))
        scene.add_particles(parts[0], 0.1 * parts[1] + 0.01, parts[2], parts[3])
        found.append(scene.light(parts[0]))
    np.testing.assert_array_equal(*found)
    assert found[0].min() < 0.9


def test_materials_are_shared_by_what_they_are(down):
    for _ in range(3):
        down.add_particles([[0, 1, 0]], 0.1, material={"name": "smoke", "transfer": "smoke"})
        down.add_particles([[0, 1, 0]], 0.1, material=gobo.Material(name="smoke", transfer="smoke"))
    down.add_particles([[0, 1, 0]], 0.1, material="smoke")
    assert down.counts["materials"] == 1
    with pytest.raises(gobo.InputError, match="keys beside"):
        down.add_particles([[0, 1, 0]], 0.1, material="smoke", transfer="stain")
    # A material states the size of its particles.
    down.add_particles([[0, 1, 0]], material={"radius": 0.25})
    np.testing.assert_allclose(down.bounds[1], [0.25, 1.25, 0.25])
    for i in range(1000):
        try:
            down.add_particles([[0, 1, 0]], 0.1, tint=[1, 1, 1, i / 1000])
        except gobo.InputError as error:
            assert "at most" in str(error)
            break
    assert down.counts["materials"] == 512
