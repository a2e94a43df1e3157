"""Contents of scenes: casters and lights from arrays and dictionaries."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np

from . import _native
from ._arrays import as_array, as_colors, as_column, as_few, as_numbers, as_rows, as_texture, as_vector
from .errors import GoboWarning, InputError

#: A material: the name of one that the scene has, or the keys of a ``[[material]]`` of docs/scene.md.
MaterialLike = Union[str, Mapping[str, Any], None]


class Material(dict[str, Any]):
    """A material: the keys of a ``[[material]]`` table of docs/scene.md.

    The most used: ``transfer`` (``"filter"``, ``"stain"``, ``"smoke"``, ``"over"``, ``"gain"``, ``"none"``,
    ``"opaque"``, ``"cutout"``, ``"dither"``), ``tint`` (linear rgba, 0 to 1), ``shape`` (``"disc"``,
    ``"quad"``, ``"puff"``), ``profile`` (``"soft"``, ``"flat"``), ``texture`` (a file, or an array of (H, W,
    3) or (H, W, 4) bytes), ``reflectivity``, ``attenuation_color`` and ``attenuation_distance`` [m]. A plain
    dictionary works, too.
    """

    def __init__(self, **keys: Any) -> None:
        super().__init__(**keys)


class Gaussians:
    """Gaussians of a scene, as ``add_gaussians`` returns them: for ``relight``.

    Attributes:
        rows: number of given rows.
        count: number of Gaussians in the scene.
        skipped: rows that were left out, by reason.
    """

    def __init__(
        self,
        scene: Contents,
        found: tuple[int, int],
        rows: int,
        skipped: dict[str, int],
        left_out: np.ndarray,
        colors: np.ndarray,
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


class Contents:
    """The part of a scene that adds contents."""

    _native: _native.Scene

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
            radius: one or (N,), above 0 [m]: of the disc or puff, half the side of a quad. Default: the
                material's.
            color: linear rgb or rgba, 0 to 1 (16 with the transfer ``"gain"``): (3,), (4,), (N, 3) or (N, 4).
                It multiplies the material's tint.
            opacity: one or (N,), 0 to 1, for a colour without alpha. Default 1.
            material: name of a material of the scene, or a dictionary.
            rotation: one or (N,), of quads about the ray from the light [radians].
            keys: of a material: ``transfer="stain", profile="flat"``.

        Returns:
            Number of added particles.
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
        warn_of(skipped, "particles:")
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
        density: float | None = None,
        material: MaterialLike = None,
        **keys: Any,
    ) -> Gaussians:
        """Adds anisotropic 3D Gaussians, in gsplat's layout, after its activations.

        Args:
            means: (N, 3) centres, world space [m].
            quats: (N, 4) rotations from the Gaussian's space to the world, **w, x, y, z**; any length but 0.
            scales: (N, 3) standard deviations, linear (``exp`` of trained values), at least 0 [m].
            opacities: (N,) or (N, 1), 0 to 1 (``sigmoid`` of trained values).
            colors: (N, 3) linear rgb, 0 to 1; for spherical harmonics ``0.5 + 0.2820948 * sh[:, 0]``. Values
                outside are clamped, as in files.
            cast: ``"neutral"``: they filter light as if they were black; ``"own"``: in their own colours;
                ``"none"``: they cast no shadow.
            density: extinction [1/m] of opacity 1, for a medium instead of splats (docs/gaussians.md).
            material: name or dictionary; ``keys``: of a material. Its tint multiplies colours and opacities.

        Returns:
            An argument for ``relight``.
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
        warn_of(skipped, "Gaussians:")
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
            Number of added triangles.
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
        warn_of(skipped, "triangles:")
        return count

    def add_shape(
        self,
        kind: str,
        material: MaterialLike = None,
        *,
        translation: Sequence[float] = (0.0, 0.0, 0.0),
        rotation: Sequence[float] = (0.0, 0.0, 0.0),
        scale: float | Sequence[float] = 1.0,
        level: int | None = None,
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
            Number of added triangles.
        """
        made, texture = self._material(material, keys)
        place = np.subtract(as_vector(translation, "translation"), self._native.origin).tolist()
        size = as_few(scale, "scale", 3)
        shape = {"kind": kind, "translation": place, "rotation": rotation, "scale": size, "level": level}
        return self._native.add_shape(shape, _pair(made, texture))

    def add_volume(
        self,
        density: Any,
        spacing: float | Sequence[float] = 1.0,
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
            density: (X, Y, Z), indexed ``density[x, y, z]``, at least 0: values at the centres of voxels,
                trilinear between them, 0 outside. (An array of images, ``[z, y, x]``, is ``array.transpose(2,
                1, 0)``.) (X, Y, Z, 3): densities that absorb red, green and blue.
            spacing: distance between neighbours, one or along x, y and z [m].
            origin: world position of the centre of voxel [0, 0, 0] [m].
            matrix: (4, 4), world space [m] from indices, instead of ``spacing`` and ``origin``.
            factor: optical depth of a metre of density 1 [1/m]: light falls by ``exp(-factor * integral of
                density * color)``.
            color: extinction per channel, 0 to 1, times the densities. albedo: linear rgb, 0 to 1, in the
                picture.
            anisotropy: of the scattered light, -0.95 to 0.95.
            casts: whether it casts a shadow. visible: whether the picture shows it.

        Returns:
            Number of bricks of 8 x 8 x 8 voxels that are not empty.
        """
        values = as_numbers(density, "density")
        if values.ndim != 3 and (values.ndim != 4 or values.shape[3] != 3):
            raise InputError(f"the shape of density is {values.shape}", "give it the shape (X, Y, Z) or (X, Y, Z, 3)")
        values = values.reshape(values.shape[:3] + (values.shape[3:] or (1,)))
        if max(values.shape) > 1 << 20:
            raise InputError(f"the shape of density is {values.shape[:3]}", "split it: at most 1048576 along an edge")
        if matrix is None:
            world = np.eye(4)
            world[:3, :3] = np.diag(as_few(spacing, "spacing", 3))
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
        warn_of(skipped, "volume:")
        return count

    def add_light(self, kind: str = "directional", **keys: Any) -> int:
        """Adds a light: the keys of a ``[[light]]`` table of docs/scene.md.

        Args:
            kind: ``"directional"`` with ``direction`` (in which light travels), ``"spot"`` with ``position`` [m],
                ``direction`` and ``angle`` (of the whole cone [degrees]), or ``"point"`` with ``position``.
            keys: also ``name``, ``color`` (linear rgb), ``intensity`` (default 3), ``near`` and ``far`` [m],
                ``size`` of its maps [texels], ``casts``, ``cascades``, and ``source``: the surface of an area
                light, such as ``{"kind": "sphere", "radius": 0.1}`` or, for a directional light, ``{"kind":
                "sun", "angle": 0.53}``.

        Returns:
            Number of the light.
        """
        light = {"kind": kind, **keys}
        return self._native.add_light(_moved(light, self._native.origin))

    def _material(self, material: MaterialLike, keys: dict[str, Any]) -> tuple[str | dict[str, Any], int | None]:
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


def _pair(made: str | dict[str, Any], texture: int | None) -> str | tuple[dict[str, Any], int | None]:
    return made if isinstance(made, str) else (made, texture)


def _moved(table: Mapping[str, Any], origin: Sequence[float]) -> dict[str, Any]:
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


def warn_of(skipped: Mapping[str, int], what: str) -> None:
    if skipped:
        reasons = ", ".join(f"{count} {reason}" for reason, count in skipped.items())
        warnings.warn(f"{what} left out: {reasons}", GoboWarning, stacklevel=3)
