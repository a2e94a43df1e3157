"""Arrays of callers, checked and converted to the types of the compiled part."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from .errors import GoboWarning, InputError

# Device types of DLPack whose memory this process can read: the CPU, and pinned memory of CUDA and ROCm.
_READABLE = (1, 3, 11)


def as_array(value: Any, name: str) -> np.ndarray:
    """Any array as a numpy array, without a copy if it is one already."""
    if isinstance(value, np.ma.MaskedArray):
        raise InputError(f"{name} is masked", "pass filled() of it")
    if isinstance(value, np.ndarray):
        return value
    if getattr(value, "requires_grad", False):
        raise InputError(f"{name} has gradients, and shadows have none here", "pass detach() of it")
    device = getattr(value, "__dlpack_device__", None)
    if device is not None:
        try:
            kind = int(device()[0])
        except Exception as error:  # torch's tensors without memory
            raise InputError(f"{name} has no memory to read: {error}", "copy it to the CPU first: tensor.cpu()") from error
        if kind not in _READABLE:
            where = getattr(value, "device", f"a device of DLPack's kind {kind}")
            # torch's tensors, and cupy's arrays.
            copied = getattr(value, "cpu", None) or getattr(value, "get", None)
            if not callable(copied):
                raise InputError(f"{name} is on {where}", "copy it to the CPU first")
            warnings.warn(f"{name} is on {where}, and is copied to the CPU", GoboWarning, stacklevel=2)
            value = copied()
        if not hasattr(value, "__array__"):
            return np.from_dlpack(value)
    try:
        return np.asarray(value)
    except Exception as error:  # of any library's array
        raise InputError(f"{name} is no array: {error}", "pass a numpy array") from error


def as_numbers(value: Any, name: str, dtype: Any = np.float32) -> np.ndarray:
    """A contiguous array of `dtype`: the caller's own if it is one."""
    array = as_array(value, name)
    if array.dtype.kind not in "fiu":
        if array.size or array.dtype.kind != "O":
            raise InputError(f"{name} has the type {array.dtype}", "pass real numbers, such as float32")
    if np.dtype(dtype).kind in "iu" and array.dtype.kind == "f" and array.size:
        raise InputError(f"{name} has the type {array.dtype}", "pass whole numbers, such as int64")
    with np.errstate(over="ignore", invalid="ignore"):
        return np.ascontiguousarray(array, dtype=dtype).reshape(array.shape)


def as_rows(value: Any, name: str, columns: int, dtype: Any = np.float32, origin: Sequence[float] | None = None) -> np.ndarray:
    """An array of shape (N, `columns`), less an origin. An empty list is (0, `columns`)."""
    array = as_array(value, name)
    if array.ndim == 1 and array.size == 0:
        array = array.reshape(0, columns)
    if array.ndim != 2 or array.shape[1] != columns:
        raise InputError(f"the shape of {name} is {array.shape}", f"give it the shape (N, {columns})")
    if origin is not None and any(origin):
        array = as_numbers(array, name, np.float64) - np.asarray(origin, np.float64)
    return as_numbers(array, name, dtype)


def as_column(value: Any, name: str, rows: int) -> np.ndarray:
    """An array of shape (1,) or (N,)."""
    array = as_numbers(value, name)
    if array.ndim == 2 and array.shape[1] == 1:
        array = array[:, 0]
    if array.ndim == 0 or array.shape == (1,):
        return np.ascontiguousarray(array.reshape(1))
    if array.shape != (rows,):
        raise InputError(f"the shape of {name} is {array.shape}", f"give it one number, or the shape ({rows},)")
    return np.ascontiguousarray(array)


def as_colors(color: Any, opacity: Any, rows: int) -> np.ndarray:
    """Linear rgba of shape (1, 4) or (N, 4), from rgb or rgba and opacities."""
    array = as_numbers(color, "color")
    if array.ndim == 1 and array.shape in ((3,), (4,)):
        array = array.reshape(1, -1)
    if array.ndim != 2 or array.shape[0] not in (1, rows) or array.shape[1] not in (3, 4):
        remedy = f"give it the shape (3,), (4,), ({rows}, 3) or ({rows}, 4)"
        raise InputError(f"the shape of color is {array.shape}", remedy)
    if opacity is None:
        if array.shape[1] == 4:
            return np.ascontiguousarray(array)
        opacity = 1.0
    elif array.shape[1] == 4:
        raise InputError("color has an alpha, and there is an opacity as well", "give one of the two")
    alpha = as_column(opacity, "opacity", rows)
    count = max(array.shape[0], alpha.shape[0])
    rgba = np.empty((count, 4), np.float32)
    rgba[:, :3], rgba[:, 3] = array, alpha
    return rgba


def as_vector(value: Any, name: str) -> tuple[float, float, float]:
    """Three finite numbers."""
    array = as_numbers(value, name, np.float64)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise InputError(f"{name} is {value!r}", "give it three finite numbers")
    return (float(array[0]), float(array[1]), float(array[2]))


def as_texture(value: Any) -> np.ndarray:
    """An image of shape (H, W, 4) of bytes, from rgb or rgba."""
    array = as_array(value, "texture")
    if array.dtype != np.uint8 or array.ndim != 3 or array.shape[2] not in (3, 4) or array.size == 0:
        remedy = "give it (H, W, 3) or (H, W, 4) bytes: sRGB, and a linear alpha"
        raise InputError(f"the texture has the shape {array.shape} and the type {array.dtype}", remedy)
    if array.shape[2] == 3:
        opaque = np.full(array.shape[:2] + (1,), 255, np.uint8)
        array = np.concatenate([array, opaque], axis=2)
    return np.ascontiguousarray(array)


def as_few(value: Any, name: str, count: int) -> list[float]:
    """`count` numbers, or one for all."""
    array = as_numbers(value, name, np.float64)
    if array.shape not in ((), (1,), (count,)):
        raise InputError(f"{name} is {value!r}", f"give it one number, or {count}")
    return [float(number) for number in np.broadcast_to(array, (count,))]
