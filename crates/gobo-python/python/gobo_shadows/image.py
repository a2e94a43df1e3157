"""Pictures as arrays that notebooks show."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from . import _native
from .errors import InputError


class Image(np.ndarray):
    """Linear light of a picture: an array of shape (H, W, 3), float32, rows from the top.

    ``srgb`` holds the displayed picture, (H, W, 3) bytes: after exposure and tone curve, in sRGB. A notebook
    shows it; ``save`` writes it. Results of computations with an image are plain arrays of light, without
    ``srgb``.
    """

    srgb: np.ndarray | None

    def __new__(cls, light: np.ndarray, srgb: np.ndarray) -> Image:
        image = np.asarray(light).view(cls)
        image.srgb = srgb
        return image

    def __array_finalize__(self, source: Any) -> None:
        self.srgb = None

    def __array_wrap__(self, array: np.ndarray, context: Any = None, return_scalar: bool = False) -> Any:
        plain = np.asarray(array)
        return plain[()] if return_scalar else plain

    def png(self) -> bytes:
        """The picture as a PNG file."""
        if self.srgb is None:
            raise InputError("this is a part of an image, or computed from one", "call png() of the image itself")
        return _native.encode_png(self.srgb)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a PNG file."""
        data = self.png()
        with open(path, "wb") as file:
            file.write(data)

    def _repr_png_(self) -> bytes | None:
        return None if self.srgb is None else self.png()
