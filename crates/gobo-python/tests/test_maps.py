"""Maps and pictures, beside those of the command line."""

import json
import os
import struct
import subprocess
import sys
import zlib

import gobo_shadows as gobo
import numpy as np
import pytest
from conftest import pane

SCENE = """
[camera]
eye = [0, 3, 6]
target = [0, 1, 0]
size = [64, 36]
samples = 1

[shadow]
size = 64
receiver = "curve"
nodes = 4

[[light]]
name = "sun"
kind = "directional"
direction = [-0.4, -1, -0.3]
size = 64

[[light]]
name = "lamp"
kind = "point"
position = [0.5, 4, 0.25]
size = 32

[[material]]
name = "smoke"
tint = [0.5, 0.75, 1, 0.5]

[[material]]
name = "ground"
transfer = "opaque"

[[particles]]
file = "smoke.csv"
material = "smoke"

[[shape]]
kind = "plane"
material = "ground"
scale = [4, 1, 4]
"""


def program(*arguments, **keys):
    """Runs the program in a process of its own."""
    command = [sys.executable, "-m", "gobo_shadows", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, **keys)


@pytest.fixture
def files(tmp_path, rng):
    """A scene file with particles, and their arrays."""
    positions = rng.uniform(-1, 1, (300, 3)).astype(np.float32) + np.float32([0, 2, 0])
    radii = rng.uniform(0.05, 0.3, 300).astype(np.float32)
    colors = rng.uniform(0, 1, (300, 4)).astype(np.float32)
    rows = ["x,y,z,radius,red,green,blue,alpha"]
    rows += [",".join(repr(float(v)) for v in (*p, r, *c)) for p, r, c in zip(positions, radii, colors)]
    (tmp_path / "smoke.csv").write_text("\n".join(rows))
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path, positions, radii, colors


def made(positions, radii, colors):
    """The same scene from arrays."""
    scene = gobo.Scene(shadow={"size": 64, "receiver": "curve", "nodes": 4})
    scene.add_light("directional", name="sun", direction=(-0.4, -1, -0.3), size=64)
    scene.add_light("point", name="lamp", position=(0.5, 4, 0.25), size=32)
    scene.add_particles(positions, radii, colors, tint=[0.5, 0.75, 1, 0.5])
    scene.add_shape("plane", transfer="opaque", scale=(4, 1, 4))
    return scene


def test_maps_have_the_bits_of_the_command_line(files):
    folder, *arrays = files
    written = program("render", folder / "scene.toml", "--maps", "-o", folder / "out")
    assert written.returncode == 0, written.stderr
    maps = folder / "out" / "maps" / "frame_0000"
    views = json.loads((maps / "views.json").read_text())
    assert len(views) == 7
    of_file, of_arrays = gobo.load(folder / "scene.toml"), made(*arrays)
    camera = gobo.Camera((0, 3, 6), (0, 1, 0), size=(64, 36))
    for light in ("sun", "lamp"):
        for scene in (of_file, of_arrays):
            every = scene.all_maps(light, camera=camera)
            described = [view for view in views if view["light"] == light]
            assert list(every) == [view["view"] for view in described]
            for view in described:
                found = every[view["view"]]
                for name in ("filter", "nearest", "opaque", "curve"):
                    written = np.load(maps / f"{light}.{view['view']}.{name}.npy")
                    np.testing.assert_array_equal(found[name], written, err_msg=f"{light} {name}")
                for name in ("clip_from_world", "view_from_world"):
                    columns = np.reshape(view[name], (4, 4)).T
                    np.testing.assert_allclose(found[name], columns, rtol=1e-6, atol=1e-12)
                assert found["near"] == pytest.approx(view["near"]) and found["kind"] == view["kind"]
    assert of_file.maps("sun")["filter"].min() < 0.5


def test_light_has_the_bits_of_the_command_line(files):
    folder, *arrays = files
    points = np.random.default_rng(3).uniform(-2, 3, (100, 3)).astype(np.float32)
    np.save(folder / "points.npy", points)
    written = program("light", folder / "scene.toml", "--points", folder / "points.npy", "-o", folder / "light.npy")
    assert written.returncode == 0, written.stderr
    expected = np.load(folder / "light.npy")
    np.testing.assert_array_equal(gobo.load(folder / "scene.toml").light(points), expected)
    np.testing.assert_array_equal(made(*arrays).light(points), expected)
    assert expected.min() < 0.5


def test_one_view_is_asked_for(down):
    down.add_light("point", name="lamp", position=(0, 3, 0))
    down.add_light("point", name="dark", position=(0, 3, 0), casts=False)
    assert down.maps(0)["view"] == down.maps("sun", 0)["view"] == "0"
    assert down.maps("lamp", "ny")["view"] == down.maps(1, 3)["view"] == "ny"
    for light, view in ((1, None), (1, "up"), (1, 6), ("dark", None), ("moon", None), (3, None), (1.0, None)):
        with pytest.raises(gobo.InputError) as caught:
            down.maps(light, view)
        assert caught.value.remedy
    assert down.maps(-3)["kind"] == "directional"


def test_curves_where_asked(down):
    down.add_particles([[0, 1, 0], [0, 2, 0]], 1.0, (0, 0, 0), 0.5, profile="flat")
    assert "curve" not in down.maps(curve=False)
    for nodes in (True, 4, 8, 16):
        maps = down.maps(curve=nodes)
        assert maps["curve"].shape == (64, 64, 8 if nodes is True else nodes, 5)
        middle = maps["curve"][32, 32]
        # Two nodes at the discs' depths, and the light behind each.
        np.testing.assert_allclose(middle[:2, 2], [0.5, 0.25], atol=2e-3)
        assert (middle[2:, 0] == 2).all()
        y = maps["view_from_world"] @ [0, 2, 0, 1]
        depth = (-y[2] - maps["near"]) / (maps["far"] - maps["near"])
        np.testing.assert_allclose(middle[0, 0], depth, atol=2e-3)
        np.testing.assert_allclose(maps["nearest"][32, 32], depth, atol=1e-5)
    for nodes in (3, -1, 17):
        with pytest.raises(gobo.InputError):
            down.maps(curve=nodes)


def test_curves_by_default_within_their_budget():
    """8 nodes of 8 bytes a texel; a smaller budget is reported."""
    scene = gobo.Scene(shadow={"size": 64})
    scene.add_light("directional", direction=(0, -1, 0))
    scene.add_particles([[0, 1, 0], [0, 2, 0]], 1.0, (0, 0, 0), 0.5)
    assert scene.maps()["curve"].shape == (64, 64, 8, 5)
    for nodes, message in ((4, "4 nodes instead of 8"), (0, "read nearest depths")):
        budget = 64 * 64 * 8 * (2 * nodes or 4) - 1
        scene.configure(shadow={"size": 64, "detail": False, "curve_budget": budget})
        for ask in (scene.maps, lambda: scene.light([[0, 0, 0]]), lambda: scene.render(size=(16, 16))):
            with pytest.warns(gobo.GoboWarning, match=message):
                ask()
        with pytest.warns(gobo.GoboWarning, match=message):
            assert scene.maps().get("curve", np.empty((64, 64, 0, 5))).shape == (64, 64, nodes, 5)


def test_a_texel_is_where_its_matrix_says(down):
    """The hole of a plate is at the texel that clip_from_world projects it to."""
    vertices, faces = pane(1.0, 0.1)
    down.add_mesh(vertices + np.float32([0.5, 0, -0.25]), faces, transfer="opaque")
    down.add_mesh(*pane(0.0, 2.0), transfer="none")
    maps = down.maps()
    rows, columns = np.nonzero(maps["opaque"] < 1)
    clip = maps["clip_from_world"] @ [0.5, 1, -0.25, 1]
    x, y = (clip[0] / clip[3] + 1) / 2 * 64, (1 - clip[1] / clip[3]) / 2 * 64
    np.testing.assert_allclose([columns.mean() + 0.5, rows.mean() + 0.5], [x, y], atol=0.6)


def test_pictures(down, tmp_path):
    down.add_shape("plane", transfer="opaque", scale=(6, 1, 6))
    down.add_particles([[0, 1, 0]], 0.5, (1, 0, 0), 1.0, profile="flat", visible=False)
    above = gobo.Camera((0, 5, 0), (0, 0, 0), up=(0, 0, -1), fov=60, size=(40, 30))
    image = down.render(above, samples=1)
    assert image.shape == (30, 40, 3) and image.dtype == np.float32 and image.srgb.shape == (30, 40, 3)
    lit, shadowed = image[15, 5], image[15, 20]
    # Red light alone reaches the middle, apart from the sky's.
    assert lit[1] > 2 * shadowed[1] and shadowed[0] == pytest.approx(lit[0], rel=0.05)
    png = image._repr_png_()
    assert png[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", png[16:24]) == (40, 30)
    start = png.index(b"IDAT")
    length = struct.unpack(">I", png[start - 4 : start])[0]
    assert len(zlib.decompress(png[start + 4 : start + 4 + length])) == 30 * (1 + 3 * 40)
    image.save(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == png
    for plain in (image * 2, image[:10], image.mean(axis=2)):
        assert getattr(plain, "srgb", None) is None
    with pytest.raises(gobo.InputError):
        image[:10].png()
    assert image[:10]._repr_png_() is None
    # Exposure changes the displayed picture, and not the light.
    brighter = down.render(above, samples=1, exposure=1)
    np.testing.assert_array_equal(image, brighter)
    assert brighter.srgb.mean() > image.srgb.mean() + 5
    assert down._repr_png_().startswith(b"\x89PNG")
    for keys in ({"eye": (0, 0, 1)}, {"sample": 1}, {"samples": 0}, {"tone": "warm"}):
        with pytest.raises(gobo.InputError):
            down.render(above, **keys)
    with pytest.raises(gobo.InputError):
        down.render((0, 1, 2))


def test_a_scene_keeps_its_camera(down):
    down.add_particles([[0, 1, 0]], 0.5)
    free = down.render(size=(16, 8))
    down.camera = gobo.Camera((0, 1, 9), (0, 1, 0), fov=30, size=(20, 10))
    assert down.camera.eye == (0, 1, 9) and down.camera.size == (20, 10)
    assert down.render().shape == (10, 20, 3)
    assert down.render(gobo.Camera((1, 1, 9), size=(6, 4))).shape == (4, 6, 3)
    assert down.render().shape == (10, 20, 3) and free.shape == (8, 16, 3)
    with pytest.raises(gobo.InputError):
        down.camera = None


def test_files_are_read(files, tmp_path):
    folder, *_ = files
    scene = gobo.load(folder / "scene.toml", set={"shadow.size": 32, "light.sun.direction": [0, -1, 0]})
    assert scene.counts["particles"] == 300 and scene.lights == ["sun", "lamp"]
    assert scene.camera.size == (64, 36)
    alone = gobo.load(str(folder / "smoke.csv"), ground=False)
    assert alone.counts["particles"] == 300 and alone.counts["triangles"] == 0
    # A scene that was read can be extended.
    scene.add_particles([[0, 1, 0]], 0.1)
    scene.add_light("point", position=(0, 1, 0))
    assert scene.counts["particles"] == 301 and len(scene.lights) == 3
    (folder / "bad.toml").write_text("[shadow]\nsize = 512\nreciever = 'curve'\n")
    with pytest.raises(gobo.SceneError) as caught:
        gobo.load(folder / "bad.toml")
    assert (caught.value.line, caught.value.path) == (3, str(folder / "bad.toml"))
    assert "receiver" in caught.value.remedy
    for path in ("missing.toml", "missing.glb", "."):
        with pytest.raises(gobo.SceneError):
            gobo.load(folder / path)
    with pytest.raises(gobo.SceneError):
        gobo.load(folder / "scene.toml", set={"shadow.sise": 3})


def test_rows_of_a_file_that_are_left_out_are_told_of(tmp_path):
    (tmp_path / "a.csv").write_text("x,y,z,radius\n0,0,0,1\nnan,0,0,1\n")
    with pytest.warns(gobo.GoboWarning, match="1 not finite"):
        scene = gobo.load(tmp_path / "a.csv")
    assert scene.skipped == {"not finite": 1}


def test_scenes_that_move(tmp_path):
    (tmp_path / "a.toml").write_text(
        SCENE.replace('[[particles]]\nfile = "smoke.csv"\nmaterial = "smoke"\n', "")
        + "name = 'floor'\n[[animate]]\ntarget = 'shape.floor.translation'\ntimes = [0, 1]\nvalues = [[0, 0, 0], [0, 2, 0]]\n"
    )
    scene = gobo.load(tmp_path / "a.toml")
    assert scene.bounds[1][1] == pytest.approx(0)
    scene.set_time(0.5)
    assert scene.bounds[1][1] == pytest.approx(1)
    for bad in (-1, np.nan, np.inf):
        with pytest.raises(gobo.InputError):
            scene.set_time(bad)


@pytest.mark.skipif("GOBO_DATA" not in os.environ, reason="needs the scenes of the repository")
def test_scenes_of_the_repository_have_the_bits_of_the_command_line(tmp_path):
    scene = os.path.join(os.environ["GOBO_DATA"], "glass.toml")
    set = {"shadow.size": 128, "camera.size": [32, 18]}
    arguments = [word for key, value in set.items() for word in ("--set", f"{key}={value}")]
    written = program("render", scene, "--maps", "-o", tmp_path, *arguments)
    assert written.returncode == 0, written.stderr
    views = json.loads((tmp_path / "maps" / "frame_0000" / "views.json").read_text())
    loaded = gobo.load(scene, set=set)
    for view in views:
        found = loaded.all_maps(view["light"])[view["view"]]
        for name in ("filter", "nearest", "opaque"):
            expected = np.load(tmp_path / "maps" / "frame_0000" / f"{view['light']}.{view['view']}.{name}.npy")
            np.testing.assert_array_equal(found[name], expected)


def test_the_program_runs(tmp_path):
    version = program("--version")
    assert version.stdout.split()[1] == gobo.__version__ and version.returncode == 0
    wrong = program("render")
    assert wrong.returncode == 2 and "Usage" in wrong.stderr
    missing = program("check", tmp_path / "missing.toml")
    assert missing.returncode == 2 and "help:" in missing.stderr
    code = "import gobo_shadows, sys; sys.exit(gobo_shadows.main(['check', 'missing.toml']) + 40)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=60).returncode == 42
