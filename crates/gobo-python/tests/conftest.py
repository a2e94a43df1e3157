"""What several tests share. Each test has a scene of its own, small enough for a software adapter."""

import warnings

import gobo_shadows as gobo
import numpy as np
import pytest


@pytest.fixture(autouse=True)
def warnings_are_errors():
    with warnings.catch_warnings():
        warnings.simplefilter("error", gobo.GoboWarning)
        yield


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def down():
    """An empty scene under parallel light from above, read by curves."""
    scene = gobo.Scene(shadow={"size": 64, "receiver": "curve", "nodes": 16, "filter": {"kind": "none"}})
    scene.add_light("directional", name="sun", direction=(0, -1, 0))
    return scene


def heights(*ys):
    """Points on the y axis."""
    return np.array([[0.0, y, 0.0] for y in ys], np.float32)


def pane(y, half=1.0):
    """Vertices and faces of a horizontal square."""
    vertices = np.array([[-half, y, -half], [half, y, -half], [half, y, half], [-half, y, half]], np.float32)
    return vertices, np.array([[0, 2, 1], [0, 3, 2]])
