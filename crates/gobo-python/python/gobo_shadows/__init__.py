"""Coloured translucent shadows of particles, splats, meshes and volumes, from numpy arrays.

>>> import gobo_shadows as gobo, numpy as np
>>> scene = gobo.Scene()
>>> scene.add_particles(np.random.rand(1000, 3), radius=0.05, color=(0.2, 0.5, 0.9), opacity=0.3)
>>> scene.add_light("directional", direction=(-0.4, -1, -0.3))
>>> scene.light([[0.5, -0.1, 0.5]])   # the share of each light that reaches a point

It runs on any adapter that wgpu finds (Vulkan, Metal, Direct3D 12), including software adapters such as
Mesa's lavapipe, and otherwise on the CPU by a slow reference: ``adapter()`` tells which. Nothing here has
gradients.
"""

from __future__ import annotations

import atexit
import os
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from . import _native
from ._adding import Gaussians, Material
from .camera import Camera
from .errors import AdapterError, DeviceError, GoboError, GoboWarning, InputError, OutOfMemoryError, SceneError
from .image import Image
from .scene import Scene

__version__: str = _native.version

__all__ = [
    "AdapterError",
    "Camera",
    "DeviceError",
    "Gaussians",
    "GoboError",
    "GoboWarning",
    "Image",
    "InputError",
    "Material",
    "OutOfMemoryError",
    "Scene",
    "SceneError",
    "adapter",
    "load",
    "main",
    "use_adapter",
]

# Drivers and interrupted calls end before the interpreter does.
atexit.register(_native.finish)
# A forked process has neither: calls say so instead of waiting for them.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_native.forked)


def adapter() -> str:
    """The adapter's name, its interface and its tier, or ``the CPU reference``."""
    return _native.adapter_name()


def use_adapter(backend: str = "auto", name: str | None = None) -> None:
    """Chooses the adapter of later calls, in the whole process.

    Args:
        backend: ``"auto"``, ``"vulkan"``, ``"metal"``, ``"dx12"``, ``"gl"``, or ``"cpu"`` for the reference.
            ``"auto"`` takes the reference if there is no adapter.
        name: part of the adapter's name; case does not matter.
    """
    _native.use_adapter(backend, name)


def load(path: str | os.PathLike[str], *, set: Mapping[str, Any] | None = None, ground: bool = True) -> Scene:
    """Reads a file: see ``Scene.load``."""
    return Scene.load(path, set=set, ground=ground)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the program ``gobo``, once in a process, like ``python -m gobo_shadows``.

    Args:
        arguments: without the program's name. Default: those of this process.

    Returns:
        Its exit status. The program listens for signals itself: an interruption ends the process.
    """
    # Without it drivers complain on Linux.
    os.environ.setdefault("XDG_RUNTIME_DIR", "/nonexistent")
    given: list[str] = list(sys.argv[1:] if arguments is None else arguments)
    return _native.program(["gobo", *given])
