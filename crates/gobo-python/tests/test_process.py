"""Threads, interruptions and memory of a whole process."""

import os
import subprocess
import sys
import threading
import time

import gobo_shadows as gobo
import numpy as np


def scene_of(seed):
    rng = np.random.default_rng(seed)
    scene = gobo.Scene(shadow={"size": 64, "receiver": "curve"})
    scene.add_light("directional", direction=(-0.4, -1, -0.3))
    scene.add_light("point", position=(0, 3, 0))
    scene.add_particles(rng.uniform(-1, 1, (500, 3)), 0.2, rng.uniform(0, 1, (500, 3)), 0.3)
    return scene, rng.uniform(-2, 2, (200, 3))


def light_of(seed):
    scene, points = scene_of(seed)
    return scene.light(points)


def test_scenes_in_threads_are_those_one_after_the_other():
    expected = [light_of(seed) for seed in range(4)]
    found = [None] * 8

    def work(i):
        found[i] = light_of(i % 4)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for i, light in enumerate(found):
        np.testing.assert_array_equal(light, expected[i % 4])


def test_one_scene_in_threads():
    scene, points = scene_of(1)
    expected = scene.light(points)
    found = []
    threads = [threading.Thread(target=lambda: found.append(scene.light(points))) for _ in range(4)]
    threads += [threading.Thread(target=lambda: scene.render(size=(16, 9), samples=1)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    for light in found:
        np.testing.assert_array_equal(light, expected)


def test_other_threads_run_meanwhile():
    scene, points = scene_of(2)
    many = np.repeat(points, 5000, axis=0)
    scene.light(points)
    done, beats = threading.Event(), []

    def beat():
        while not done.is_set():
            beats.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=beat)
    thread.start()
    began = time.perf_counter()
    scene.light(many)
    took = time.perf_counter() - began
    done.set()
    thread.join()
    longest = np.diff(beats).max()
    assert took > 0.1 and longest < max(0.1, took / 2), (took, longest)


INTERRUPTED = """
import os, signal, sys, threading, time
import numpy as np
import gobo_shadows as gobo

# A shell makes programs in the background ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)
gobo.use_adapter("cpu")
rng = np.random.default_rng(1)
scene = gobo.Scene(shadow={"size": 256, "receiver": "curve", "nodes": 16})
scene.add_light("point", position=(0, 3, 0))
scene.add_particles(rng.uniform(-1, 1, (20000, 3)), 0.2, (0.5, 0.5, 0.5), 0.1)
points = rng.uniform(-2, 2, (8_000_000, 3))
threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
began = time.perf_counter()
try:
    scene.light(points)
    print("not interrupted")
except KeyboardInterrupt:
    took = time.perf_counter() - began
    print("interrupted" if took < 4 else f"after {took} s")
    # Other scenes go on.
    print(gobo.Scene().light([[0, 0, 0]]).shape)
"""


def test_an_interruption_is_raised_at_once():
    run = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, timeout=240)
    assert run.stdout.split("\n")[:2] == ["interrupted", "(1, 0, 3)"], run.stdout + run.stderr
    assert run.returncode == 0, run.stderr


def test_progress_is_told_of_and_ends_the_work():
    scene, _ = scene_of(3)
    told = []
    image = scene.render(size=(16, 9), samples=3, progress=told.append)
    assert told[-1] == 1 and told == sorted(told) and len(told) in (2, 4), told

    class Enough(Exception):
        pass

    def enough(share):
        raise Enough(share)

    with np.testing.assert_raises(Enough):
        scene.render(size=(16, 9), samples=3, progress=enough)
    np.testing.assert_array_equal(scene.render(size=(16, 9), samples=3), image)


FORKED = """
import os, sys
import gobo_shadows as gobo

scene = gobo.Scene()
scene.light([[0, 0, 0]])
if os.fork() == 0:
    try:
        scene.light([[0, 0, 0]])
    except gobo.GoboError as error:
        sys.exit(42 if "spawn" in str(error) else 1)
    sys.exit(2)
_, status = os.wait()
print(os.WEXITSTATUS(status), scene.light([[0, 0, 0]]).shape)
"""


def test_a_forked_process_is_told_so():
    if not hasattr(os, "fork"):
        return
    run = subprocess.run([sys.executable, "-c", FORKED], capture_output=True, text=True, timeout=60)
    assert run.stdout == "42 (1, 0, 3)\n", run.stdout + run.stderr


MANY = """
import gc
import numpy as np
import gobo_shadows as gobo

def resident():
    gc.collect()
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096

rng = np.random.default_rng(1)
points, positions = rng.uniform(-1, 1, (100, 3)), rng.uniform(-1, 1, (2000, 3))
sizes = []
for i in range(300):
    scene = gobo.Scene(shadow={"size": 64})
    scene.add_light("directional", direction=(0, -1, 0))
    scene.add_particles(positions, 0.1, (0.5, 0.5, 0.5), 0.1)
    scene.add_volume(np.ones((8, 8, 8)), 0.1)
    scene.light(points)
    scene.maps()
    try:
        scene.light([[np.nan, 0, 0]])
    except gobo.InputError:
        pass
    if i in (99, 299):
        sizes.append(resident())
print(sizes[1] - sizes[0])
"""


def test_memory_does_not_grow_with_scenes():
    if not sys.platform.startswith("linux"):
        return
    run = subprocess.run([sys.executable, "-c", MANY], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    # A scene's own arrays are a tenth of a MiB: two hundred of them, 20 MiB.
    assert int(run.stdout) < 6 << 20, f"{int(run.stdout) / 2**20:.1f} MiB"


def test_adapters():
    assert gobo.adapter()
    for name in ("opencl", "", "CPU"):
        try:
            gobo.use_adapter(name)
            raise AssertionError(name)
        except gobo.InputError as error:
            assert error.remedy
    try:
        gobo.use_adapter("auto", "no such adapter")
        try:
            gobo.Scene().light([[0, 0, 0]])
            raise AssertionError("rendered")
        except gobo.AdapterError as error:
            assert "no such adapter" in str(error)
    finally:
        gobo.use_adapter()
    assert gobo.Scene().light([[0, 0, 0]]).shape == (1, 0, 3)
