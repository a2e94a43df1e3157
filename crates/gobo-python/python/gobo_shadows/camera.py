"""Cameras: placed by hand, or those of captures."""

from __future__ import annotations

import json
import math
import os
import struct
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, Union

import numpy as np

from ._arrays import as_few, as_numbers, as_vector
from .errors import GoboWarning, InputError, SceneError

PathLike = Union[str, "os.PathLike[str]"]

#: Most pixels of an edge of a picture.
MAX_SIZE = 4096
#: Share by which two focal lengths may differ.
SQUARE = 1e-3


class Camera:
    """A pinhole camera.

    Args:
        eye: position, world space [m].
        target: a point that it looks at, world space [m].
        up: approximate up direction. Default +y.
        fov: vertical field of view [degrees], 0.01 to 179.9.
        size: width and height of the picture [pixels], each 1 to 4096.
    """

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float]
    fov: float
    size: tuple[int, int]
    #: Kept part of the rendered picture: first column and row, width and height [pixels]. ``None``: all.
    crop: tuple[int, int, int, int] | None
    #: Offset right and down from the rendered picture's middle to the axis [pixels], at most half a pixel.
    shift: tuple[float, float]

    def __init__(
        self,
        eye: Sequence[float],
        target: Sequence[float] = (0.0, 0.0, 0.0),
        up: Sequence[float] = (0.0, 1.0, 0.0),
        fov: float = 45.0,
        size: Sequence[int] = (960, 540),
    ) -> None:
        self.eye = as_vector(eye, "eye")
        self.target = as_vector(target, "target")
        self.up = as_vector(up, "up")
        self.fov = float(fov)
        if not 0.01 <= self.fov <= 179.9:
            raise InputError(f"fov is {fov!r}", "give the vertical field of view in degrees, 0.01 to 179.9")
        self.size = _size(size)
        self.crop = None
        self.shift = (0.0, 0.0)
        if self.eye == self.target:
            raise InputError("eye and target are the same", "move one of them")

    def __repr__(self) -> str:
        return f"Camera(eye={self.eye}, target={self.target}, up={self.up}, fov={self.fov:g}, size={self.size})"

    @classmethod
    def from_matrix(
        cls,
        world_from_camera: Any,
        focal: float | Sequence[float],
        size: Sequence[int],
        center: Sequence[float] | None = None,
        convention: str = "opengl",
    ) -> Camera:
        """The camera of a pose and a focal length.

        Args:
            world_from_camera: (4, 4) or (3, 4): columns are the camera's axes and its position, world space
                [m]; at most a rotation and a uniform scale.
            focal: focal length [pixels], or two that are equal, along x and y.
            size: width and height of the picture [pixels].
            center: principal point [pixels], (0, 0) at the upper left corner of the picture. Default: the
                middle. If it is more than half a pixel off, a larger picture is rendered and cropped.
            convention: ``"opengl"``: the camera looks along -z with +y up (nerfstudio, Blender);
                ``"opencv"``: along +z with +y down (COLMAP, gsplat).
        """
        matrix = as_numbers(world_from_camera, "world_from_camera", np.float64)
        if matrix.shape not in ((4, 4), (3, 4)):
            raise InputError(f"the shape of world_from_camera is {matrix.shape}", "give it the shape (4, 4) or (3, 4)")
        if not np.isfinite(matrix).all():
            raise InputError("world_from_camera has numbers that are not finite", "give it a rotation and a position")
        axes, eye = matrix[:3, :3], matrix[:3, 3]
        lengths = np.linalg.norm(axes, axis=0)
        unit = axes / np.where(lengths > 0, lengths, 1)
        if not np.allclose(unit.T @ unit, np.eye(3), atol=1e-3) or np.linalg.det(unit) < 0:
            raise InputError("world_from_camera is no rotation", "give the pose of a camera, not its inverse or a projection")
        flip = _flip(convention)
        up, forward = flip * unit[:, 1], flip * -unit[:, 2]
        width, height = _size(size)
        focal_x, focal_y = as_few(focal, "focal", 2)
        if not (math.isfinite(focal_x) and math.isfinite(focal_y) and focal_x > 0 and focal_y > 0):
            raise InputError(f"focal is {focal!r}", "give the focal length in pixels")
        if abs(focal_x - focal_y) > SQUARE * focal_y:
            remedy = "undistort the images to square pixels, or give the mean of the two"
            raise InputError(f"the focal lengths differ: {focal_x:g} and {focal_y:g}", remedy)
        crop, shift = None, (0.0, 0.0)
        if center is not None:
            x, y = as_few(center, "center", 2)
            if not (0 <= x <= width and 0 <= y <= height):
                raise InputError(f"the principal point is {(x, y)}", "it must be in the picture")
            # Margin rendered beside the picture, so that the principal point is in the middle, and the rest
            # of the shift.
            first_x, first_y = round(max(width - 2 * x, 0)), round(max(height - 2 * y, 0))
            last_x, last_y = round(max(2 * x - width, 0)), round(max(2 * y - height, 0))
            shift = (x - (width + last_x - first_x) / 2, y - (height + last_y - first_y) / 2)
            if first_x or first_y or last_x or last_y:
                crop = (first_x, first_y, width, height)
                width, height = width + first_x + last_x, height + first_y + last_y
        if max(width, height) > MAX_SIZE:
            raise InputError(
                f"{width} x {height} pixels are needed, for what is off the middle", "scale the size, focal and center down"
            )
        fov = math.degrees(2 * math.atan(height / (2 * focal_y)))
        # As long as the world's numbers, so that rounding to 32 bits does not turn it.
        reach = max(1.0, float(np.abs(eye).max()))
        camera = cls(eye.tolist(), (eye + forward * reach).tolist(), up.tolist(), fov, (width, height))
        camera.crop, camera.shift = crop, shift
        return camera

    @classmethod
    def from_transforms(cls, transforms: PathLike | Mapping[str, Any], frame: int | str = 0, scale: float = 1.0) -> Camera:
        """A camera of nerfstudio's, or instant-ngp's, ``transforms.json``.

        Args:
            transforms: the file, or its contents.
            frame: number of the frame, or (the end of) its ``file_path``.
            scale: size of the picture as a share of the image's.

        Lens distortion is not rendered: a warning says so. The camera stands in the space of the file's
        matrices: for splats that nerfstudio exported, apply its ``dataparser_transforms.json`` first.
        """
        path: str | None = None
        if not isinstance(transforms, Mapping):
            path = os.fspath(transforms)
            transforms = _json(path)
        frames = transforms.get("frames")
        if not isinstance(frames, Sequence) or isinstance(frames, (str, bytes)) or not frames:
            raise _file_error(path, "there are no frames", "is it a transforms.json of nerfstudio?")
        entry = _entry(path, list(frames), frame)
        values: dict[str, Any] = {**transforms, **entry}
        if "transform_matrix" not in entry:
            raise _file_error(path, f"frame {frame!r} has no transform_matrix", "export it again")

        def number(key: str) -> float | None:
            value = values.get(key)
            if value is None:
                return None
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
                raise _file_error(path, f"{key} is {value!r}", "it must be a finite number")
            return float(value)

        width, height = number("w"), number("h")
        if width is None or height is None:
            raise _file_error(path, "the size of the images is not given", "add w and h [pixels]")
        focal_x, focal_y = number("fl_x"), number("fl_y")
        angle_x, angle_y = number("camera_angle_x"), number("camera_angle_y")
        if focal_x is None and angle_x is not None:
            focal_x = width / (2 * math.tan(angle_x / 2))
        if focal_y is None and angle_y is not None:
            focal_y = height / (2 * math.tan(angle_y / 2))
        focal_x, focal_y = focal_x or focal_y, focal_y or focal_x
        if focal_x is None or focal_y is None:
            raise _file_error(path, "there is no focal length", "add fl_x and fl_y, or camera_angle_x")
        distorted = [key for key in ("k1", "k2", "k3", "k4", "p1", "p2") if number(key)]
        if distorted:
            _warn_of_distortion(distorted)
        center_x, center_y = number("cx"), number("cy")
        center = (
            (center_x if center_x is not None else width / 2) * scale,
            (center_y if center_y is not None else height / 2) * scale,
        )
        size = (round(width * scale), round(height * scale))
        if min(focal_x, focal_y) <= 0:
            raise _file_error(path, f"the focal length is {focal_x:g}", "it must be above 0")
        return cls.from_matrix(entry["transform_matrix"], (focal_x * scale, focal_y * scale), size, center)

    @classmethod
    def from_colmap(cls, model: PathLike, image: int | str, scale: float = 1.0) -> Camera:
        """A camera of a COLMAP model.

        Args:
            model: folder with ``cameras`` and ``images``, as ``.bin`` or ``.txt``, such as ``sparse/0``.
            image: id of the image, or its name.
            scale: size of the picture as a share of the image's.

        Lens distortion is not rendered: a warning says so; ``colmap image_undistorter`` makes images without.
        """
        folder = Path(model)
        cameras = _colmap_cameras(folder)
        found = _colmap_image(folder, image)
        camera_id, rotation, translation = found
        if camera_id not in cameras:
            raise _file_error(str(folder), f"there is no camera {camera_id}", "export the model again")
        kind, (width, height), numbers = cameras[camera_id]
        if kind in _ONE_FOCAL:
            focal, center, rest = (numbers[0], numbers[0]), numbers[1:3], numbers[3:]
        else:
            focal, center, rest = (numbers[0], numbers[1]), numbers[2:4], numbers[4:]
        if any(rest):
            _warn_of_distortion([kind])
        world_from_camera = np.eye(4)
        world_from_camera[:3, :3] = rotation.T
        world_from_camera[:3, 3] = -rotation.T @ translation
        size = (round(width * scale), round(height * scale))
        scaled = [value * scale for value in (*focal, *center)]
        return cls.from_matrix(world_from_camera, scaled[:2], size, scaled[2:], "opencv")

    def _table(self, origin: Sequence[float]) -> dict[str, Any]:
        """The keys of a scene file, less an origin."""
        eye = [a - b for a, b in zip(self.eye, origin)]
        target = [a - b for a, b in zip(self.target, origin)]
        table = {"eye": eye, "target": target, "up": self.up, "fov_y": self.fov, "size": list(self.size)}
        return {**table, "shift": list(self.shift)}


#: Models of COLMAP by number: name and number of parameters.
_MODELS = {
    0: ("SIMPLE_PINHOLE", 3),
    1: ("PINHOLE", 4),
    2: ("SIMPLE_RADIAL", 4),
    3: ("RADIAL", 5),
    4: ("OPENCV", 8),
    5: ("OPENCV_FISHEYE", 8),
    6: ("FULL_OPENCV", 12),
    7: ("FOV", 5),
    8: ("SIMPLE_RADIAL_FISHEYE", 4),
    9: ("RADIAL_FISHEYE", 5),
    10: ("THIN_PRISM_FISHEYE", 12),
}
_ONE_FOCAL = ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE")
_COUNTS = dict(_MODELS.values())

_ColmapCamera = tuple[str, tuple[int, int], list[float]]
_ColmapImage = tuple[int, np.ndarray, np.ndarray]


def _flip(convention: str) -> float:
    if convention not in ("opengl", "opencv"):
        raise InputError(f"no convention is named {convention!r}", 'use "opengl" or "opencv"')
    return 1.0 if convention == "opengl" else -1.0


def _size(size: Sequence[int]) -> tuple[int, int]:
    array = as_numbers(size, "size", np.float64)
    valid = array.shape == (2,) and np.isfinite(array).all() and (array == np.floor(array)).all()
    if not valid or not ((array >= 1) & (array <= MAX_SIZE)).all():
        raise InputError(f"size is {size!r}", f"give width and height in pixels, each 1 to {MAX_SIZE}")
    return (int(array[0]), int(array[1]))


def _warn_of_distortion(what: list[str]) -> None:
    message = f"lens distortion ({', '.join(what)}) is not rendered: undistort the images"
    warnings.warn(message, GoboWarning, stacklevel=4)


def _file_error(path: str | None, message: str, remedy: str) -> Exception:
    if path is None:
        return InputError(f"transforms: {message}", remedy)
    error = SceneError(f"{path}: {message}", remedy)
    error.path = path
    return error


def _json(path: str) -> Mapping[str, Any]:
    try:
        with open(path, encoding="utf-8") as file:
            content = json.load(file)
    except (OSError, ValueError, RecursionError) as error:
        raise _file_error(path, str(error), "check the name, and that it is a JSON file") from error
    if not isinstance(content, dict):
        raise _file_error(path, "it holds no object", "is it a transforms.json of nerfstudio?")
    return content


def _entry(path: str | None, frames: list[Any], frame: int | str) -> Mapping[str, Any]:
    found: Any = None
    if isinstance(frame, str):
        named = [f for f in frames if isinstance(f, Mapping) and str(f.get("file_path", "")).endswith(frame)]
        found = named[0] if len(named) == 1 else None
        if len(named) > 1:
            raise _file_error(path, f"{len(named)} frames end in {frame!r}", "give more of the path")
    elif -len(frames) <= frame < len(frames):
        found = frames[frame]
    if not isinstance(found, Mapping):
        raise _file_error(path, f"there is no frame {frame!r} among {len(frames)}", "give a number, or the end of a file_path")
    return found


def _opened(folder: Path, stem: str) -> tuple[Path, bool]:
    for name, is_binary in ((f"{stem}.bin", True), (f"{stem}.txt", False)):
        if (folder / name).is_file():
            return folder / name, is_binary
    raise _file_error(str(folder), f"there is no {stem}.bin or {stem}.txt", "name the folder of a COLMAP model: sparse/0")


def _lines(path: Path) -> list[str]:
    """Lines without comments; an image without points has an empty second line."""
    text = path.read_text(encoding="utf-8", errors="replace")
    return [line for line in text.splitlines() if not line.startswith("#")]


def _colmap_cameras(folder: Path) -> dict[int, _ColmapCamera]:
    path, is_binary = _opened(folder, "cameras")
    cameras: dict[int, _ColmapCamera] = {}
    try:
        if not is_binary:
            for line in _lines(path):
                words = line.split()
                if words:
                    numbers = [float(word) for word in words[4:]]
                    cameras[int(words[0])] = (words[1], (int(words[2]), int(words[3])), numbers)
        else:
            with open(path, "rb") as file:
                (count,) = _unpacked(file, "<Q")
                for _ in range(count):
                    camera_id, kind, width, height = _unpacked(file, "<iiQQ")
                    name, parameters = _MODELS.get(kind, (f"number {kind}", 0))
                    if parameters == 0:
                        raise _file_error(str(path), f"the camera model {name} is unknown", "undistort the images")
                    cameras[camera_id] = (name, (width, height), list(_unpacked(file, f"<{parameters}d")))
    except (ValueError, IndexError, struct.error, OSError) as error:
        raise _file_error(str(path), f"it is damaged: {error}", "export the model again") from error
    for kind, _, numbers in cameras.values():
        if kind not in _COUNTS or len(numbers) != _COUNTS[kind]:
            raise _file_error(str(path), f"a camera {kind} of {len(numbers)} numbers", "undistort the images")
    return cameras


def _colmap_image(folder: Path, wanted: int | str) -> _ColmapImage:
    path, is_binary = _opened(folder, "images")
    try:
        images = _binary_images(path) if is_binary else _text_images(path)
        for image_id, name, camera_id, quat, translation in images:
            if wanted == name or (not isinstance(wanted, str) and wanted == image_id):
                return camera_id, _rotation(quat), np.asarray(translation)
    except (ValueError, IndexError, struct.error, OSError) as error:
        raise _file_error(str(path), f"it is damaged: {error}", "export the model again") from error
    raise _file_error(str(path), f"there is no image {wanted!r}", "give the id of an image, or its name")


def _text_images(path: Path) -> Any:
    # The first line of each image; the second has its points.
    for line in _lines(path)[::2]:
        words = line.split(maxsplit=9)
        if words:
            numbers = [float(word) for word in words[1:8]]
            yield int(words[0]), words[9].strip(), int(words[8]), numbers[:4], numbers[4:]


def _binary_images(path: Path) -> Any:
    with open(path, "rb") as file:
        (count,) = _unpacked(file, "<Q")
        for _ in range(count):
            image_id, *numbers, camera_id = _unpacked(file, "<i7di")
            name = bytearray()
            while (byte := _read(file, 1)) != b"\0":
                name += byte
            (points,) = _unpacked(file, "<Q")
            file.seek(24 * points, os.SEEK_CUR)
            yield image_id, name.decode("utf-8", "replace"), camera_id, numbers[:4], numbers[4:]


def _read(file: BinaryIO, size: int) -> bytes:
    data = file.read(size)
    if len(data) != size:
        raise ValueError("it ends early")
    return data


def _unpacked(file: BinaryIO, layout: str) -> tuple[Any, ...]:
    return struct.unpack(layout, _read(file, struct.calcsize(layout)))


def _rotation(quat: Sequence[float]) -> np.ndarray:
    """The matrix of w, x, y, z."""
    w, x, y, z = np.asarray(quat) / np.linalg.norm(quat)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
