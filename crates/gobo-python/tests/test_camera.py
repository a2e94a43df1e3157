"""Cameras of captures: what they see is where the formulas of their formats put it."""

import json
import math
import struct

import gobo_shadows as gobo
import numpy as np
import pytest

MARK = np.array([0.4, 0.7, -0.2])
WIDTH, HEIGHT = 120, 80


def rotation(axis, degrees):
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    turn = math.radians(degrees)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(turn) * k + (1 - math.cos(turn)) * (k @ k)


def quat(axis, degrees):
    """w, x, y, z."""
    half = math.radians(degrees) / 2
    return np.array([math.cos(half), *(math.sin(half) * np.asarray(axis) / np.linalg.norm(axis))])


def seen(camera):
    """Where a picture shows a small bright ball at MARK [pixels from the upper left corner]."""
    scene = gobo.Scene(environment={"ambient": [0, 0, 0], "background": [0, 0, 0]})
    scene.add_shape("sphere", translation=MARK, scale=0.05, transfer="opaque", emission=[1, 1, 1])
    image = scene.render(camera, samples=16, occlusion=False)
    weights = np.asarray(image)[..., 0]
    assert weights.sum() > 1
    rows, columns = np.indices(weights.shape) + 0.5
    return image.shape, np.array([(weights * columns).sum(), (weights * rows).sum()]) / weights.sum()


def looking(eye, opencv):
    """World from camera, at a place that shows MARK aside of the middle."""
    forward = (MARK + [0.15, -0.1, 0.1]) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.2, 1, 0.1])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, -up, forward] if opencv else [right, up, -forward], axis=1)
    matrix[:3, 3] = eye
    return matrix


@pytest.mark.parametrize("center", [None, (60, 40), (50, 47), (70.5, 33), (61.3, 40), (59.85, 40.2), (44.375, 52.125)])
def test_a_pose_sees_what_it_should(center):
    focal, eye = 150.0, np.array([1.5, 2.0, 3.0])
    x, y = center or (WIDTH / 2, HEIGHT / 2)
    for convention in ("opengl", "opencv"):
        pose = looking(eye, convention == "opencv")
        local = np.linalg.inv(pose) @ [*MARK, 1]
        if convention == "opengl":
            local = local * [1, -1, -1, 1]
        expected = np.array([x + focal * local[0] / local[2], y + focal * local[1] / local[2]])
        camera = gobo.Camera.from_matrix(pose, focal, (WIDTH, HEIGHT), center, convention)
        shape, found = seen(camera)
        assert shape == (HEIGHT, WIDTH, 3)
        np.testing.assert_allclose(found, expected, atol=0.06)
        assert np.abs(expected - [WIDTH / 2, HEIGHT / 2]).max() > 2


def transforms(**keys):
    frames = [
        {"file_path": f"images/{i:04}.png", "transform_matrix": looking(np.array([i, 2.0, 3.0]), False).tolist()}
        for i in range(3)
    ]
    return {"w": WIDTH, "h": HEIGHT, "fl_x": 150, "fl_y": 150, "cx": 60, "cy": 40, "frames": frames, **keys}


def test_transforms(tmp_path):
    path = tmp_path / "transforms.json"
    path.write_text(json.dumps(transforms()))
    expected = gobo.Camera.from_matrix(looking(np.array([1, 2.0, 3.0]), False), 150, (WIDTH, HEIGHT))
    for camera in (
        gobo.Camera.from_transforms(path, 1),
        gobo.Camera.from_transforms(transforms(), "0001.png"),
        gobo.Camera.from_transforms(transforms(), -2),
        gobo.Camera.from_transforms(transforms(fl_x=None, fl_y=None, camera_angle_x=2 * math.atan(0.4)), 1),
    ):
        np.testing.assert_allclose(camera.eye, expected.eye)
        np.testing.assert_allclose(camera.target, expected.target)
        assert camera.fov == pytest.approx(math.degrees(2 * math.atan(HEIGHT / 300)))
        assert (camera.size, camera.crop) == ((WIDTH, HEIGHT), None)
    half = gobo.Camera.from_transforms(path, 1, scale=0.5)
    assert half.size == (WIDTH // 2, HEIGHT // 2) and half.fov == pytest.approx(expected.fov)
    with pytest.warns(gobo.GoboWarning, match="k1"):
        gobo.Camera.from_transforms(transforms(k1=0.1, k2=0))


@pytest.mark.parametrize(
    "change, frame",
    [
        ({"frames": []}, 0),
        ({"frames": "many"}, 0),
        ({"frames": [{}]}, 0),
        ({"frames": [3]}, 0),
        ({"w": None}, 0),
        ({"h": "tall"}, 0),
        ({"fl_x": None, "fl_y": None}, 0),
        ({"fl_x": 100}, 0),
        ({"fl_x": 0, "fl_y": 0}, 0),
        ({"w": 1e9}, 0),
        ({"w": math.nan}, 0),
        ({"cx": 5000}, 0),
        ({}, 3),
        ({}, "9.png"),
        ({}, ".png"),
        ({"frames": [{"transform_matrix": [[1, 0], [0, 1]]}]}, 0),
        ({"frames": [{"transform_matrix": np.zeros((4, 4)).tolist()}]}, 0),
        ({"frames": [{"transform_matrix": np.diag([1, 1, -1, 1]).tolist()}]}, 0),
    ],
)
def test_transforms_refuse(change, frame):
    with pytest.raises(gobo.GoboError) as caught:
        gobo.Camera.from_transforms(transforms(**change), frame)
    assert caught.value.remedy


AXIS, DEGREES, TRANSLATION = (0.3, 1.0, -0.2), 40.0, np.array([0.1, -0.2, 3.0])
IMAGES = [(1, "a.jpg", (0, 1, 0), 0.0, (0, 0, 1)), (7, "with space.jpg", AXIS, DEGREES, TRANSLATION)]


def write_text(folder, model="SIMPLE_PINHOLE", numbers=(150, 60, 40)):
    folder.mkdir(exist_ok=True)
    parameters = " ".join(map(str, numbers))
    (folder / "cameras.txt").write_text(f"# cameras\n3 {model} {WIDTH} {HEIGHT} {parameters}\n")
    lines = ["# images", "# two lines each"]
    for image_id, name, axis, degrees, translation in IMAGES:
        pose = " ".join(repr(float(v)) for v in (*quat(axis, degrees), *translation))
        lines += [f"{image_id} {pose} 3 {name}", "" if image_id == 1 else "1.5 2.5 -1 3.5 4.5 -1"]
    (folder / "images.txt").write_text("\n".join(lines) + "\n")


def write_binary(folder, model=0, numbers=(150, 60, 40)):
    folder.mkdir(exist_ok=True)
    cameras = struct.pack("<Q", 1) + struct.pack("<iiQQ", 3, model, WIDTH, HEIGHT)
    (folder / "cameras.bin").write_bytes(cameras + struct.pack(f"<{len(numbers)}d", *numbers))
    images = struct.pack("<Q", len(IMAGES))
    for image_id, name, axis, degrees, translation in IMAGES:
        images += struct.pack("<i7di", image_id, *quat(axis, degrees), *translation, 3)
        images += name.encode() + b"\0" + struct.pack("<Q", 2) + bytes(48)
    (folder / "images.bin").write_bytes(images)


@pytest.mark.parametrize("write", [write_text, write_binary])
def test_colmap(tmp_path, write):
    write(tmp_path)
    turn = rotation(AXIS, DEGREES)
    # COLMAP: x_camera = R x_world + t, with +z ahead and +y down.
    pose = np.linalg.inv(np.block([[turn, TRANSLATION[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]]))
    expected = gobo.Camera.from_matrix(pose, 150, (WIDTH, HEIGHT), (60, 40), "opencv")
    for image in (7, "with space.jpg"):
        camera = gobo.Camera.from_colmap(tmp_path, image)
        np.testing.assert_allclose(camera.eye, expected.eye, atol=1e-9)
        np.testing.assert_allclose(camera.target, expected.target, atol=1e-9)
        assert camera.fov == pytest.approx(expected.fov)
    local = turn @ MARK + TRANSLATION
    x, y = 60 + 150 * local[0] / local[2], 40 + 150 * local[1] / local[2]
    assert 5 < x < WIDTH - 5 and 5 < y < HEIGHT - 5
    _, found = seen(camera)
    np.testing.assert_allclose(found, [x, y], atol=0.4)
    for image in (2, "b.jpg", 7.5):
        with pytest.raises(gobo.SceneError, match="no image"):
            gobo.Camera.from_colmap(tmp_path, image)


def test_colmap_refuses(tmp_path):
    with pytest.raises(gobo.SceneError, match="cameras.bin"):
        gobo.Camera.from_colmap(tmp_path, 7)
    write_text(tmp_path, "RADIAL", (150, 60, 40, 0.1, 0))
    with pytest.warns(gobo.GoboWarning, match="distortion"):
        gobo.Camera.from_colmap(tmp_path, 7)
    write_text(tmp_path, "RADIAL", (150, 60, 40))
    with pytest.raises(gobo.SceneError):
        gobo.Camera.from_colmap(tmp_path, 7)
    write_text(tmp_path, "MOVING", (150, 60, 40))
    with pytest.raises(gobo.SceneError):
        gobo.Camera.from_colmap(tmp_path, 7)
    write_binary(tmp_path)
    for name in ("cameras.bin", "images.bin"):
        write_binary(tmp_path)
        whole = (tmp_path / name).read_bytes()
        for length in range(0, len(whole), 3):
            (tmp_path / name).write_bytes(whole[:length])
            try:
                gobo.Camera.from_colmap(tmp_path, 7)
            except gobo.SceneError as error:
                assert error.path and error.remedy
    write_binary(tmp_path, model=99)
    with pytest.raises(gobo.SceneError, match="99"):
        gobo.Camera.from_colmap(tmp_path, 7)


@pytest.mark.parametrize(
    "keys",
    [
        {"eye": (0, 0)},
        {"eye": (0, 0, np.nan)},
        {"eye": "here"},
        {"eye": (0, 0, 0)},
        {"fov": 0},
        {"fov": 180},
        {"fov": np.nan},
        {"size": (0, 10)},
        {"size": (10.5, 10)},
        {"size": (4097, 10)},
        {"size": 10},
    ],
)
def test_cameras_refuse(keys):
    with pytest.raises(gobo.InputError):
        gobo.Camera(**{"eye": (0, 1, 3), **keys})


def test_up_along_the_view_is_refused(down):
    with pytest.raises(gobo.InputError, match="up"):
        down.render(gobo.Camera((0, 5, 0), size=(8, 8)))
