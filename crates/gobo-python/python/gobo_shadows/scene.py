"""Scenes: casters from arrays, lights, and the shadows that they cast."""

from __future__ import annotations

import os
import warnings
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import _native
from ._arrays import as_array, as_colors, as_column, as_numbers, as_rows, as_texture, as_vector
from .camera import Camera
from .errors import GoboWarning, InputError
from .image import Image

#: A material: the name of one that the scene has, or the keys of a ``[[material]]`` of docs/scene.md.
MaterialLike = Union[str, Mapping[str, Any], None]
#: A camera, or ``None`` for the scene's own, or else one that sees everything.
CameraLike = Optional[Camera]
#: Name of a light, or its number.
LightLike = Union[str, int]


class Material(Dict[str, Any]):
    """A material: the keys of a ``[[material]]`` table of docs/scene.md.

    The most used: ``transfer`` (``"filter"``, ``"stain"``, ``"smoke"``, ``"over"``, ``"gain"``, ``"none"``, ``"opaque"``,
    ``"cutout"``, ``"dither"``), ``tint`` (linear rgba, 0 to 1), ``shape`` (``"disc"``, ``"quad"``, ``"puff"``), ``profile``
    (``"soft"``, ``"flat"``), ``texture`` (a file, or an array of (H, W, 3) or (H, W, 4) bytes), ``reflectivity``,
    ``attenuation_color`` and ``attenuation_distance`` [m]. A plain dictionary is as good.
    """

    def __init__(self, **keys: Any) -> None:
        super().__init__(**keys)


class Gaussians:
    """Gaussians of a scene, as ``add_gaussians`` returns them: for ``relight``.

    Attributes:
        rows: rows that were given.
        count: those that the scene has.
        skipped: rows that were left out, by reason.
    """

    def __init__(
        self, scene: "Scene", found: Tuple[int, int], rows: int, skipped: Dict[str, int], left_out: np.ndarray, colors: np.ndarray
    ) -> None:
        self._scene = scene
        self._start, self._end = found
        self._left_out = left_out
        self._colors_left_out = colors[left_out].copy()
        self.rows = rows
        self.count = self._end - self._start
        self.skipped = skipped

    def __len__(self) -> int:
        return self.rows

    def __repr__(self) -> str:
        return f"<Gaussians: {self.count} of {self.rows} rows>"


class Scene:
    """Casters and lights.

    World space is right-handed with y up, in metres; colours are linear. Rows that cannot be used (numbers that are not
    finite, positions beyond 1e7 m, radii that are not positive, colours or opacities out of range) are left out, counted in
    ``skipped`` and told of by a ``GoboWarning``; they change nothing else.

    Scenes are independent of each other. Long calls release the interpreter's lock, so that threads work with several scenes at
    once; calls of one scene wait for each other. Nothing here has gradients.

    Args:
        origin: world position [m] that is subtracted from all positions before they are rounded to 32 bits: near the
            scene, for one that is far from (0, 0, 0). Results are in world space all the same.
        tables: ``shadow``, ``environment``, ``air``, ``mask`` and ``clusters``, each a dictionary with the keys of docs/scene.md:
            ``Scene(shadow={"size": 2048, "receiver": "curve"})``. The default is that of a scene file without the table.
    """

    _native: _native.Scene

    def __init__(self, *, origin: Sequence[float] = (0.0, 0.0, 0.0), **tables: Optional[Mapping[str, Any]]) -> None:
        self._native = _native.Scene(_tables(tables), as_vector(origin, "origin"))

    @classmethod
    def load(
        cls, path: Union[str, "os.PathLike[str]"], *, set: Optional[Mapping[str, Any]] = None, ground: bool = True
    ) -> "Scene":
        """Reads a file: a scene (.toml), a model (.glb, .gltf), particles (.ply, .csv), splats (.ply, .splat, .spz, .sog) or
        a volume (.vdb).

        Args:
            path: the file.
            set: values that replace those of the file: ``{"shadow.size": 512, "light.sun.intensity": 2}``.
            ground: whether a model, particles, splats or a volume alone get a floor to cast their shadow on.

        What of the file is not read is listed in ``notes``. A file without lights has a sun; ``remove_lights`` removes it.
        """
        scene = cls.__new__(cls)
        values = [(str(key), _toml(value)) for key, value in (set or {}).items()]
        scene._native = _native.Scene.load(os.fspath(path), values, ground)
        skipped = scene._native.skipped
        if skipped:
            _warn(skipped, "the file's")
        return scene

    def configure(self, **tables: Optional[Mapping[str, Any]]) -> None:
        """Sets whole tables anew: ``shadow``, ``environment``, ``air``, ``mask``, ``clusters``. Keys that a table leaves out
        take their defaults."""
        self._native.configure(_tables(tables))

    def add_particles(
        self,
        positions: Any,
        radius: Any = None,
        color: Any = (1.0, 1.0, 1.0),
        opacity: Any = None,
        *,
        material: MaterialLike = None,
        rotation: Any = 0.0,
        **keys: Any,
    ) -> int:
        """Adds discs, quads or puffs.

        Args:
            positions: (N, 3) centres, world space [m].
            radius: one or (N,), above 0 [m]: of the disc or puff, half the side of a quad. Default: the material's.
            color: linear rgb or rgba, 0 to 1 (16 with the transfer ``"gain"``): (3,), (4,), (N, 3) or (N, 4). It multiplies
                the material's tint.
            opacity: one or (N,), 0 to 1; of a colour without alpha. Default 1.
            material: name of a material of the scene, or a dictionary.
            rotation: one or (N,), of quads about the ray from the light [radians].
            keys: of a material: ``transfer="stain", profile="flat"``.

        Returns:
            Number of particles that were added.
        """
        made, texture = self._material(material, keys)
        if radius is None:
            radius = made.pop("radius", None) if isinstance(made, dict) else None
            if radius is None:
                raise InputError("the particles have no radius", "give radius, in metres")
        centers = as_rows(positions, "positions", 3, origin=self._native.origin)
        rows = len(centers)
        radii, turns = as_column(radius, "radius", rows), as_column(rotation, "rotation", rows)
        colors = as_colors(color, opacity, rows)
        count, skipped = self._native.add_particles(centers, radii, colors, turns, _pair(made, texture))
        _warn(skipped, "particles:")
        return count

    def add_gaussians(
        self,
        means: Any,
        quats: Any,
        scales: Any,
        opacities: Any,
        colors: Any,
        *,
        cast: str = "neutral",
        density: Optional[float] = None,
        material: MaterialLike = None,
        **keys: Any,
    ) -> Gaussians:
        """Adds anisotropic 3D Gaussians, in gsplat's layout, after its activations.

        Args:
            means: (N, 3) centres, world space [m].
            quats: (N, 4) rotations from the Gaussian's space to the world, **w, x, y, z**; any length but 0.
            scales: (N, 3) standard deviations, linear (``exp`` of what is trained), at least 0 [m].
            opacities: (N,) or (N, 1), 0 to 1 (``sigmoid`` of what is trained).
            colors: (N, 3) linear rgb, 0 to 1; of spherical harmonics ``0.5 + 0.2820948 * sh[:, 0]``. What is outside is
                clamped, as it is where a file is read.
            cast: ``"neutral"``: they filter light as if they were black; ``"own"``: in their own colours; ``"none"``: they
                cast no shadow.
            density: extinction [1/m] of opacity 1, for a medium instead of splats (docs/gaussians.md).
            material: name or dictionary; ``keys``: of a material. Its tint multiplies colours and opacities.

        Returns:
            What ``relight`` takes.
        """
        if cast not in ("neutral", "own", "none"):
            raise InputError(f"cast is {cast!r}", 'use "neutral", "own" or "none"')
        if density is not None and not 0 < density <= 1e6:
            raise InputError(f"density is {density!r}", "give an extinction above 0, up to 1e6 per metre")
        made, texture = self._material(material, keys)
        centers = as_rows(means, "means", 3, origin=self._native.origin)
        rows = len(centers)
        rgb = as_rows(colors, "colors", 3)
        alphas = as_array(opacities, "opacities")
        if rows != 1 and alphas.size == 1:
            raise InputError(f"opacities has 1 value for {rows} rows", "give one for each splat")
        found, skipped, left_out = self._native.add_gaussians(
            centers,
            as_rows(quats, "quats", 4),
            as_rows(scales, "scales", 3),
            as_column(alphas, "opacities", rows),
            rgb,
            _pair(made, texture),
            cast == "neutral",
            cast != "none",
            density,
        )
        _warn(skipped, "Gaussians:")
        return Gaussians(self, found, rows, skipped, left_out, rgb)

    def add_mesh(
        self,
        vertices: Any,
        faces: Any,
        material: MaterialLike = None,
        *,
        normals: Any = None,
        uvs: Any = None,
        colors: Any = None,
        **keys: Any,
    ) -> int:
        """Adds triangles.

        Args:
            vertices: (V, 3) positions, world space [m].
            faces: (F, 3) indices of vertices, from 0, counterclockwise from the front.
            material: name of a material of the scene, or a dictionary. ``transfer="opaque"`` is solid; with
                ``attenuation_distance`` a closed mesh is coloured glass.
            normals: (V, 3) of any length. Default: flat.
            uvs: (V, 2) texture coordinates; row 0 of the texture is at v = 0.
            colors: (V, 3) or (V, 4) linear rgb(a), 0 to 1, which multiply the tint.
            keys: of a material.

        Returns:
            Number of triangles that were added.
        """
        made, texture = self._material(material, keys)
        corners = as_rows(vertices, "vertices", 3, origin=self._native.origin)
        rgba = np.empty((0, 4), np.float32) if colors is None else as_colors(colors, None, len(corners))
        if len(rgba) == 1 and len(corners) != 1:
            rgba = np.ascontiguousarray(np.broadcast_to(rgba, (len(corners), 4)))
        count, skipped = self._native.add_mesh(
            corners,
            as_rows(faces, "faces", 3, np.int64),
            np.empty((0, 3), np.float32) if normals is None else as_rows(normals, "normals", 3),
            np.empty((0, 2), np.float32) if uvs is None else as_rows(uvs, "uvs", 2),
            rgba,
            _pair(made, texture),
        )
        _warn(skipped, "triangles:")
        return count

    def add_shape(
        self,
        kind: str,
        material: MaterialLike = None,
        *,
        translation: Sequence[float] = (0.0, 0.0, 0.0),
        rotation: Sequence[float] = (0.0, 0.0, 0.0),
        scale: Union[float, Sequence[float]] = 1.0,
        level: Optional[int] = None,
        **keys: Any,
    ) -> int:
        """Adds a ``"plane"``, ``"box"``, ``"sphere"`` or ``"pane"`` of unit size.

        Args:
            kind: a plane lies and faces up, a pane stands and faces z.
            material: name of a material of the scene, or a dictionary.
            translation: [m]. rotation: Euler xyz [degrees]. scale: one or three.
            level: subdivisions of a sphere.
            keys: of a material.

        Returns:
            Number of triangles that were added.
        """
        made, texture = self._material(material, keys)
        place = np.subtract(as_vector(translation, "translation"), self._native.origin).tolist()
        size = np.broadcast_to(as_numbers(scale, "scale", np.float64), (3,)).tolist()
        shape = {"kind": kind, "translation": place, "rotation": rotation, "scale": size, "level": level}
        return self._native.add_shape(shape, _pair(made, texture))

    def add_volume(
        self,
        density: Any,
        spacing: Union[float, Sequence[float]] = 1.0,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        *,
        matrix: Any = None,
        factor: float = 1.0,
        color: Sequence[float] = (1.0, 1.0, 1.0),
        albedo: Sequence[float] = (1.0, 1.0, 1.0),
        anisotropy: float = 0.0,
        casts: bool = True,
        visible: bool = True,
    ) -> int:
        """Adds a grid of voxels.

        Args:
            density: (X, Y, Z), indexed ``density[x, y, z]``, at least 0: values at the centres of voxels, trilinear between them, 0
                outside. (An array of images, ``[z, y, x]``, is ``array.transpose(2, 1, 0)``.)
            spacing: distance of neighbours, one or along x, y and z [m].
            origin: world position of the centre of voxel [0, 0, 0] [m].
            matrix: (4, 4), world space [m] from indices, instead of the two.
            factor: optical depth of a metre of density 1 [1/m]: light falls by ``exp(-factor * integral of density * color)``.
            color: extinction by channel, 0 to 1. albedo: linear rgb, 0 to 1: what the picture shows of it.
            anisotropy: of the scattered light, -0.95 to 0.95.
            casts: whether it casts a shadow. visible: whether the picture shows it.

        Returns:
            Number of bricks of 8 x 8 x 8 voxels that are not empty.
        """
        values = as_numbers(density, "density")
        if values.ndim != 3:
            raise InputError(f"the shape of density is {values.shape}", "give it the shape (X, Y, Z)")
        if max(values.shape) > 1 << 20:
            raise InputError(f"the shape of density is {values.shape}", "split it: at most 1048576 along an edge")
        if matrix is None:
            world = np.eye(4)
            edges = np.broadcast_to(as_numbers(spacing, "spacing", np.float64), (3,))
            world[:3, :3] = np.diag(edges)
            world[:3, 3] = as_vector(origin, "origin")
        else:
            world = as_numbers(matrix, "matrix", np.float64).copy()
            if world.shape != (4, 4):
                raise InputError(f"the shape of matrix is {world.shape}", "give it the shape (4, 4)")
        world[:3, 3] -= self._native.origin
        _in_range("factor", factor, 0, 1e6)
        _in_range("anisotropy", anisotropy, -0.95, 0.95)
        for name, rgb in (("color", color), ("albedo", albedo)):
            for value in as_vector(rgb, name):
                _in_range(name, value, 0, 1)
        count, skipped = self._native.add_volume(
            values, world.tolist(), factor, as_vector(color, "color"), as_vector(albedo, "albedo"), anisotropy, casts, visible
        )
        _warn(skipped, "volume:")
        return count

    def add_light(self, kind: str = "directional", **keys: Any) -> int:
        """Adds a light: the keys of a ``[[light]]`` table of docs/scene.md.

        Args:
            kind: ``"directional"`` with ``direction`` (in which light travels), ``"spot"`` with ``position`` [m],
                ``direction`` and ``angle`` (of the whole cone [degrees]), or ``"point"`` with ``position``.
            keys: also ``name``, ``color`` (linear rgb), ``intensity`` (default 3), ``near`` and ``far`` [m], ``size`` of its
                maps [texels], ``casts``, ``cascades``, and ``source``: the surface of an area light, such as
                ``{"kind": "sphere", "radius": 0.1}`` or, of a directional light, ``{"kind": "sun", "angle": 0.53}``.

        Returns:
            Number of the light.
        """
        light = {"kind": kind, **keys}
        return self._native.add_light(_moved(light, self._native.origin))

    def remove_lights(self) -> None:
        """Removes all lights, such as the sun of a file that has none."""
        self._native.remove_lights()

    def set_time(self, seconds: float) -> None:
        """Sets what moves in a file to a time [s]."""
        if not 0 <= seconds < 1e9:
            raise InputError(f"the time is {seconds!r}", "give seconds from the start")
        self._native.set_time(seconds)

    def render(self, camera: CameraLike = None, *, size: Optional[Sequence[int]] = None, **keys: Any) -> Image:
        """The lit picture.

        Args:
            camera: default: the scene's own, or one that sees everything.
            size: width and height [pixels], instead of the camera's.
            keys: of a ``[camera]`` table of docs/scene.md: ``samples`` per pixel (default 4), ``exposure`` [stops], ``tone``,
                ``occlusion``, ``bloom``, ``lens`` [m], ``focus`` [m].

        Returns:
            (H, W, 3) float32: linear light, before exposure and tone curve; ``srgb`` of it is the picture as it is shown.
        """
        light, srgb = self._native.render(self._look(camera, size, keys))
        if camera is not None and camera.crop is not None and size is None:
            x, y, width, height = camera.crop
            part = np.s_[y : y + height, x : x + width]
            light, srgb = light[part].copy(), srgb[part].copy()
        return Image(light, srgb)

    def maps(
        self,
        light: LightLike = 0,
        view: Union[str, int, None] = None,
        *,
        curve: Union[bool, int, None] = None,
        camera: CameraLike = None,
    ) -> Dict[str, Any]:
        """The shadow maps of one view of a light.

        Args:
            light: name or number.
            view: its name or number, of a light with several: the six faces of a point light's cube (``"px"``, ``"nx"``, ...),
                the cascades of a sun.
            curve: nodes of curves (4, 8 or 16), ``True`` for 8 and ``False`` for none. Default: as the scene's ``shadow`` has it.
            camera: which cascades follow, and which may halve maps of lights that are small in the picture
                (``size`` of the light says otherwise).

        Returns:
            A dictionary. Rows are from the top; light depth is 0 at the near and 1 at the far plane, linear along the view axis.

            - ``filter``: (H, W, 3) float32, product of the filters in front of the opaque surface.
            - ``nearest``: (H, W), light depth of the nearest translucent hit, 1 where there is none.
            - ``opaque``: (H, W), light depth of the nearest opaque surface, 1 where there is none.
            - ``curve``: (H, W, K, 5), where there are curves: start and end of each ramp [light depth] and the light behind it,
              linear rgb; unused nodes start at 2.
            - ``colored``: (H, W, 3), ``opaque`` by channel, with coloured dithering.
            - ``clip_from_world``, ``view_from_world``: (4, 4) float64, for ``matrix @ [x, y, z, 1]``.
            - ``near``, ``far`` [m]; ``kind``; ``position`` [m] or ``direction`` of the light; ``view``: its name.

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
        self, light: LightLike = 0, *, curve: Union[bool, int, None] = None, camera: CameraLike = None
    ) -> Dict[str, Dict[str, Any]]:
        """The maps of all views of a light, by their names: see ``maps``."""
        nodes: Optional[int] = None
        if curve is not None:
            nodes = 8 if curve is True else int(curve)
            if nodes not in (0, 4, 8, 16):
                raise InputError(f"curve is {curve!r}", "a curve has 4, 8 or 16 nodes")
        if isinstance(light, (bool, float)) or not isinstance(light, (str, int, np.integer)):
            raise InputError(f"there is no light {light!r}", "give its name or its number")
        named = light if isinstance(light, str) else int(light)
        return dict(self._native.maps(named, self._look(camera, None, {}), nodes))

    def light(self, points: Any, normals: Any = None) -> np.ndarray:
        """Share of each light that reaches points.

        Args:
            points: (N, 3) world positions [m].
            normals: (N, 3), of any length; points without take no normal offset.

        Returns:
            (N, lights, 3) float32, linear rgb in the order of ``lights``: 1 where nothing is between, without falloff and cosine.
        """
        places = as_rows(points, "points", 3, origin=self._native.origin)
        return self._native.light(places, None if normals is None else as_rows(normals, "normals", 3))

    def relight(self, gaussians: Optional[Gaussians] = None, *, factors: bool = False) -> np.ndarray:
        """Colours of Gaussians in the light of the scene, ambient light included, as ``gobo relight`` computes them.

        Args:
            gaussians: what ``add_gaussians`` returned. Default: all of the scene, in its order.
            factors: whether to return the factors alone, for colours of other kinds: multiply every coefficient of spherical
                harmonics by them.

        Returns:
            (N, 3) float32, a row for each that was given: its colour, in 0 to 1, times the light that reaches it. Rows that were left
            out keep their colours (or have the factor 1).
        """
        if gaussians is None:
            start, end = 0, self._native.counts["gaussians"]
        elif not isinstance(gaussians, Gaussians) or gaussians._scene is not self:
            raise InputError("these are no Gaussians of this scene", "give what its add_gaussians returned")
        else:
            start, end = gaussians._start, gaussians._end
        result = self._native.relight(start, end)
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
    def camera(self) -> Optional[Camera]:
        """The scene's own camera, or ``None``: calls without one then see everything. Set it to place it."""
        found = self._native.camera
        if found is None:
            return None
        eye, target, up, fov, size = found
        return Camera(eye, target, up, fov, size)

    @camera.setter
    def camera(self, camera: Camera) -> None:
        if not isinstance(camera, Camera) or camera.crop is not None:
            raise InputError("this is no camera that a scene can keep", "give a Camera; one that is off the middle to render()")
        self._native.place_camera(camera._table(self._native.origin))

    @property
    def lights(self) -> List[str]:
        """Names of the lights, in their order."""
        return self._native.lights

    @property
    def counts(self) -> Dict[str, int]:
        """What the scene has: ``particles``, ``gaussians``, ``triangles``, ``bricks``, ``strands``, ``lights``, ..."""
        return self._native.counts

    @property
    def skipped(self) -> Dict[str, int]:
        """What was left out, by reason."""
        return self._native.skipped

    @property
    def notes(self) -> List[str]:
        """What of its file is not read, a sentence each."""
        return self._native.notes

    @property
    def bounds(self) -> Optional[np.ndarray]:
        """(2, 3): lowest and highest corner of all casters and receivers, world space [m]. ``None`` of an empty scene."""
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

    def _material(self, material: MaterialLike, keys: Dict[str, Any]) -> Tuple[Union[str, Dict[str, Any]], Optional[int]]:
        """Name or keys of a material, and the index of its image, if that is an array."""
        if isinstance(material, str):
            if keys:
                raise InputError(f"keys beside the name of a material: {', '.join(keys)}", "give a dictionary with all keys")
            return material, None
        if material is not None and not isinstance(material, Mapping):
            raise InputError(f"material is a {type(material).__name__}", "give a name or a dictionary")
        made = {**(material or {}), **keys}
        texture = made.get("texture")
        if texture is None or isinstance(texture, (str, os.PathLike, Mapping)):
            return made, None
        del made["texture"]
        return made, self._native.add_texture(as_texture(texture))

    def _look(self, camera: CameraLike, size: Optional[Sequence[int]], keys: Dict[str, Any]) -> Dict[str, Any]:
        if camera is not None and not isinstance(camera, Camera):
            raise InputError(f"camera is a {type(camera).__name__}", "give a Camera")
        placed = {} if camera is None else camera._table(self._native.origin)
        for key in ("eye", "target", "up", "fov_y"):
            if key in keys:
                raise InputError(f"{key} is not of a picture", "give a Camera")
        return {**placed, **({} if size is None else {"size": list(size)}), **keys}


def _pair(made: Union[str, Dict[str, Any]], texture: Optional[int]) -> Union[str, Tuple[Dict[str, Any], Optional[int]]]:
    return made if isinstance(made, str) else (made, texture)


def _tables(tables: Mapping[str, Optional[Mapping[str, Any]]]) -> Dict[str, Any]:
    for name, table in tables.items():
        if table is not None and not isinstance(table, Mapping):
            raise InputError(f"{name} is a {type(table).__name__}", "give a dictionary with the keys of docs/scene.md")
    return {name: dict(table) for name, table in tables.items() if table is not None}


def _moved(table: Mapping[str, Any], origin: Sequence[float]) -> Dict[str, Any]:
    """A light's table with its positions less an origin."""
    moved = dict(table)
    if moved.get("position") is not None and any(origin):
        moved["position"] = np.subtract(as_vector(moved["position"], "position"), origin).tolist()
    if isinstance(moved.get("shadow"), (list, tuple)):
        moved["shadow"] = [_moved(s, origin) if isinstance(s, Mapping) else s for s in moved["shadow"]]
    return moved


def _in_range(name: str, value: float, least: float, most: float) -> None:
    if not least <= value <= most:
        raise InputError(f"{name} is {value!r}", f"give a number from {least:g} to {most:g}")


def _toml(value: Any) -> str:
    """A value as the command line's --set has it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return str(value)


def _warn(skipped: Mapping[str, int], what: str) -> None:
    if skipped:
        reasons = ", ".join(f"{count} {reason}" for reason, count in skipped.items())
        warnings.warn(f"{what} left out: {reasons}", GoboWarning, stacklevel=3)
