"""Scenes: casters from arrays, lights, and the shadows that they cast."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np

from . import _native
from ._adding import Contents, Gaussians, warn_of
from ._arrays import as_rows, as_vector
from .camera import Camera
from .errors import GoboWarning, InputError
from .image import Image

#: A camera, or ``None`` for the scene's own, or else one that sees everything.
CameraLike = Optional[Camera]
#: Time from which a picture of the CPU reference is announced [s].
LONG = 10.0
#: Name of a light, or its number.
LightLike = Union[str, int]


class Scene(Contents):
    """Casters and lights.

    World space is right-handed with y up, in metres; colours are linear. Invalid rows (numbers that are not
    finite, positions beyond 1e7 m, radii that are not positive, colours or opacities out of range) are left
    out, counted in ``skipped`` and reported by a ``GoboWarning``; they change nothing else.

    Scenes are independent of each other. Long calls release the interpreter's lock, so that threads work with
    several scenes at once; calls of one scene wait for each other. Nothing here has gradients.

    Args:
        origin: world position [m] that is subtracted from all positions before they are rounded to 32 bits: a
            point close to the scene, for a scene far from (0, 0, 0). Results are in world space all the same.
        tables: ``shadow``, ``environment``, ``air``, ``mask`` and ``clusters``, each a dictionary with the
            keys of docs/scene.md: ``Scene(shadow={"size": 2048, "nodes": 16})``. The default is that
            of a scene file without the table.
    """

    def __init__(self, *, origin: Sequence[float] = (0.0, 0.0, 0.0), **tables: Mapping[str, Any] | None) -> None:
        self._native = _native.Scene(_tables(tables), as_vector(origin, "origin"))

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, set: Mapping[str, Any] | None = None, ground: bool = True) -> Scene:
        """Reads a file: a scene (.toml), a model (.glb, .gltf), particles (.ply, .csv), splats (.ply, .splat,
        .spz, .sog) or a volume (.vdb).

        Args:
            path: the file.
            set: values that replace those of the file: ``{"shadow.size": 512, "light.sun.intensity": 2}``.
            ground: whether a model, particles, splats or a volume alone get a floor to cast their shadow on.

        ``notes`` lists the unread parts of the file. A file without lights has a sun; ``remove_lights``
        removes it.
        """
        scene = cls.__new__(cls)
        values = [(str(key), _toml(value)) for key, value in (set or {}).items()]
        scene._native = _native.Scene.load(os.fspath(path), values, ground)
        skipped = scene._native.skipped
        if skipped:
            warn_of(skipped, "the file:")
        return scene

    def configure(self, **tables: Mapping[str, Any] | None) -> None:
        """Sets whole tables anew: ``shadow``, ``environment``, ``air``, ``mask``, ``clusters``. Keys that a
        table leaves out take their defaults."""
        self._native.configure(_tables(tables))

    def remove_lights(self) -> None:
        """Removes all lights, including the default sun of a file without lights."""
        self._native.remove_lights()

    def set_time(self, seconds: float) -> None:
        """Sets the time of a file's animation [s]."""
        if not 0 <= seconds < 1e9:
            raise InputError(f"the time is {seconds!r}", "give seconds from the start")
        self._native.set_time(seconds)

    def render(
        self,
        camera: CameraLike = None,
        *,
        size: Sequence[int] | None = None,
        progress: Callable[[float], object] | None = None,
        **keys: Any,
    ) -> Image:
        """The lit picture.

        Args:
            camera: default: the scene's own, or one that sees everything.
            size: width and height [pixels], instead of the camera's.
            progress: called with the share that is done, 0 to 1, after the maps and each sample, in a thread of its own; an
                exception that it raises ends the work and is raised here.
            keys: of a ``[camera]`` table of docs/scene.md: ``samples`` per pixel (default 4), ``exposure``
                [stops], ``tone``, ``occlusion``, ``bloom``, ``lens`` [m], ``focus`` [m].

        Returns:
            (H, W, 3) float32: linear light, before exposure and tone curve; its ``srgb`` is the displayed
            picture.
        """
        look = self._look(camera, size, keys)
        seconds = self._native.estimate(look)
        if seconds is not None and seconds > LONG:
            remedy = "fewer samples, smaller pictures and maps take less"
            warnings.warn(f"the CPU reference will take about {seconds:.0f} s: {remedy}", GoboWarning, stacklevel=2)
        light, srgb, messages = self._native.render(look, progress)
        for message in messages:
            warnings.warn(message, GoboWarning, stacklevel=2)
        if camera is not None and camera.crop is not None and size is None:
            x, y, width, height = camera.crop
            part = np.s_[y : y + height, x : x + width]
            light, srgb = light[part].copy(), srgb[part].copy()
        return Image(light, srgb)

    def maps(
        self,
        light: LightLike = 0,
        view: str | int | None = None,
        *,
        curve: bool | int | None = None,
        camera: CameraLike = None,
    ) -> dict[str, Any]:
        """The shadow maps of one view of a light.

        Args:
            light: name or number.
            view: its name or number, for a light with several: the six faces of a point light's cube
                (``"px"``, ``"nx"``, ...), the cascades of a sun.
            curve: nodes of curves (4, 8 or 16), ``True`` for 8 and ``False`` for none. Default: that of the
                scene's ``shadow``.
            camera: cascades follow it, and lights that are small in its picture may have half their maps'
                size (unless the light sets ``size``).

        Returns:
            A dictionary. Rows are from the top; light depth is 0 at the near and 1 at the far plane, linear
            along the view axis.

            - ``filter``: (H, W, 3) float32, product of the filters in front of the opaque surface.
            - ``nearest``: (H, W), light depth of the nearest translucent hit, 1 without one.
            - ``opaque``: (H, W), light depth of the nearest opaque surface, 1 without one.
            - ``curve``: (H, W, K, 5), if there are curves: start and end of each ramp [light depth] and the
              light behind it, linear rgb; unused nodes start at 2.
            - ``colored``: (H, W, 3), ``opaque`` per channel, with coloured dithering.
            - ``clip_from_world``, ``view_from_world``: (4, 4) float64, for ``matrix @ [x, y, z, 1]``.
            - ``near``, ``far`` [m]; ``kind``; the light's ``position`` [m] or ``direction``; ``view``: its name.

            The arrays have the bits of ``gobo render --maps``.
        """
        every = self.all_maps(light, curve=curve, camera=camera)
        names = list(every)
        if view is None and len(names) == 1:
            return every[names[0]]
        if isinstance(view, str) and view in every:
            return every[view]
        if view is not None and not isinstance(view, str) and -len(names) <= view < len(names):
            return every[names[view]]
        if not names:
            raise InputError(f"light {light!r} has no maps", "give it casts=True")
        raise InputError(f"light {light!r} has {len(names)} views, and view is {view!r}", f"use one of {', '.join(names)}")

    def all_maps(
        self, light: LightLike = 0, *, curve: bool | int | None = None, camera: CameraLike = None
    ) -> dict[str, dict[str, Any]]:
        """The maps of all views of a light, by their names: see ``maps``."""
        nodes: int | None = None
        if curve is not None:
            nodes = 8 if curve is True else int(curve)
            if nodes not in (0, 4, 8, 16):
                raise InputError(f"curve is {curve!r}", "a curve has 4, 8 or 16 nodes")
        if isinstance(light, (bool, float)) or not isinstance(light, (str, int, np.integer)):
            raise InputError(f"there is no light {light!r}", "give its name or its number")
        named = light if isinstance(light, str) else int(light)
        found, messages = self._native.maps(named, self._look(camera, None, {}), nodes)
        for message in messages:
            warnings.warn(message, GoboWarning, stacklevel=2)
        return dict(found)

    def light(self, points: Any, normals: Any = None) -> np.ndarray:
        """Share of each light that reaches points.

        Args:
            points: (N, 3) world positions [m].
            normals: (N, 3), of any length; points without normals have no normal offset.

        Returns:
            (N, lights, 3) float32, linear rgb in the order of ``lights``: 1 where nothing is between, without
            falloff and cosine.
        """
        places = as_rows(points, "points", 3, origin=self._native.origin)
        found, message = self._native.light(places, None if normals is None else as_rows(normals, "normals", 3))
        if message is not None:
            warnings.warn(message, GoboWarning, stacklevel=2)
        return found

    def relight(self, gaussians: Gaussians | None = None, *, factors: bool = False) -> np.ndarray:
        """Colours of Gaussians in the scene's light, ambient light included, like those of ``gobo relight``.

        Args:
            gaussians: the result of ``add_gaussians``. Default: all of the scene, in its order.
            factors: whether to return only the factors, for colours of other kinds: multiply every
                coefficient of spherical harmonics by them.

        Returns:
            (N, 3) float32, a row for each given Gaussian: its colour, in 0 to 1, times the light that reaches
            it. Rows that were left out keep their colours (or have the factor 1).
        """
        if gaussians is None:
            start, end = 0, self._native.counts["gaussians"]
        elif not isinstance(gaussians, Gaussians) or gaussians._scene is not self:
            raise InputError("these are no Gaussians of this scene", "give what its add_gaussians returned")
        else:
            start, end = gaussians._start, gaussians._end
        result, message = self._native.relight(start, end)
        if message is not None:
            warnings.warn(message, GoboWarning, stacklevel=2)
        if not factors:
            result = result * self._native.colors(start, end)
        if gaussians is None or len(gaussians._left_out) == 0:
            return result
        whole = np.ones((gaussians.rows, 3), np.float32)
        stays = np.ones(gaussians.rows, bool)
        stays[gaussians._left_out] = False
        whole[stays] = result
        if not factors:
            whole[gaussians._left_out] = gaussians._colors_left_out
        return whole

    @property
    def camera(self) -> Camera | None:
        """The scene's own camera, or ``None``: calls without one then see everything. Assign one to place
        it."""
        found = self._native.camera
        if found is None:
            return None
        eye, target, up, fov, size = found
        return Camera(eye, target, up, fov, size)

    @camera.setter
    def camera(self, camera: Camera) -> None:
        if not isinstance(camera, Camera) or camera.crop is not None or camera.shift != (0.0, 0.0):
            raise InputError("this is no camera that a scene can keep", "give a Camera; one that is off the middle to render()")
        self._native.place_camera(camera._table(self._native.origin))

    @property
    def lights(self) -> list[str]:
        """Names of the lights, in their order."""
        return self._native.lights

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of ``particles``, ``gaussians``, ``triangles``, ``bricks``, ``strands``, ``lights``, ..."""
        return self._native.counts

    @property
    def skipped(self) -> dict[str, int]:
        """Numbers of inputs that were left out, by reason."""
        return self._native.skipped

    @property
    def notes(self) -> list[str]:
        """Unread parts of its file, a sentence each."""
        return self._native.notes

    @property
    def bounds(self) -> np.ndarray | None:
        """(2, 3): lowest and highest corner of all casters and receivers, world space [m]; ``None`` if
        empty."""
        found = self._native.bounds
        return None if found is None else np.array(found)

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {noun}" for noun, count in self.counts.items() if count)
        return f"<Scene: {counts or 'empty'}>"

    def __reduce__(self) -> Any:
        raise TypeError("a Scene cannot be pickled: make it anew in each process")

    def _repr_png_(self) -> bytes:
        """A small picture, for notebooks."""
        own = self.camera
        width, height = own.size if own is not None else (960, 540)
        share = min(1.0, 640 / max(width, height))
        return self.render(size=(max(1, round(width * share)), max(1, round(height * share)))).png()

    def _look(self, camera: CameraLike, size: Sequence[int] | None, keys: dict[str, Any]) -> dict[str, Any]:
        if camera is not None and not isinstance(camera, Camera):
            raise InputError(f"camera is a {type(camera).__name__}", "give a Camera")
        placed = {} if camera is None else camera._table(self._native.origin)
        for key in ("eye", "target", "up", "fov_y"):
            if key in keys:
                raise InputError(f"{key} is not of a picture", "give a Camera")
        return {**placed, **({} if size is None else {"size": list(size)}), **keys}


def _tables(tables: Mapping[str, Mapping[str, Any] | None]) -> dict[str, Any]:
    for name, table in tables.items():
        if table is not None and not isinstance(table, Mapping):
            raise InputError(f"{name} is a {type(table).__name__}", "give a dictionary with the keys of docs/scene.md")
    return {name: dict(table) for name, table in tables.items() if table is not None}


def _toml(value: Any) -> str:
    """A value in the format of the command line's --set."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return str(value)
