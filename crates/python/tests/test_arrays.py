"""Arrays in and out, and the threads that compute."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import scene_of, soup

import umbrage


class OnlyDlpack:
    """What PyTorch's tensors are to others."""

    def __init__(self, array):
        self._array = array

    def __dlpack__(self, **keywords):
        return self._array.__dlpack__(**keywords)

    def __dlpack_device__(self):
        return self._array.__dlpack_device__()


@pytest.mark.parametrize(
    "given",
    [
        np.asfortranarray,
        lambda array: np.repeat(array, 2, axis=0)[::2],
        lambda array: array.astype(array.dtype.newbyteorder()),
        lambda array: array.astype(np.int64 if array.dtype.kind in "iu" else np.float64),
        lambda array: array.tolist(),
        OnlyDlpack,
        lambda array: np.frombuffer(b"x" + array.tobytes(), array.dtype, offset=1).reshape(array.shape),
    ],
    ids=["fortran", "strided", "swapped", "wider", "list", "dlpack", "unaligned"],
)
def test_arrays_of_any_layout_say_the_same(random, given):
    vertices, triangles = soup(random, 100)
    directions = random.normal(size=(200, 3)).astype(np.float32)
    expected = scene_of(vertices, triangles).scan([0, 0, 0], directions)
    answer = scene_of(given(vertices), given(triangles)).scan([0, 0, 0], given(directions))
    assert np.isfinite(expected["t_hit"]).any()
    for key in expected:
        np.testing.assert_array_equal(answer[key], expected[key])


def test_answers_are_numpys_own_and_writable(random):
    scene = scene_of(*soup(random, 10))
    answer = scene.cast_rays(np.float32([[0, 0, 2, 0, 0, -1]]))
    for array in (*answer.values(), scene.lit(umbrage.Light.sun([0, -1, 0]), faces=True)):
        array[:] = 0
        assert np.from_dlpack(array).shape == array.shape


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_answers_are_the_same_on_any_number_of_threads(random, threads):
    vertices, triangles = soup(random, 2000, 0.1)
    rays = np.hstack((random.uniform(-1, 1, (5000, 3)), random.normal(size=(5000, 3))))
    suns = umbrage.Light.suns(random.normal(size=(5, 3)))
    scene, usual = scene_of(vertices, triangles, nthreads=threads), scene_of(vertices, triangles)
    for ask in (
        lambda scene: scene.cast_rays(rays),
        lambda scene: scene.list_intersections(rays),
        lambda scene: scene.scan([0, 0, 0], rays[:, 3:]),
        lambda scene: {"lit": scene.lit(suns, faces=True)},
        lambda scene: scene.lit_areas(suns, samples=16),
        lambda scene: {"picture": scene.render(width=40, height=30, lights=suns)},
    ):
        one, other = ask(scene), ask(usual)
        for key in one:
            np.testing.assert_array_equal(one[key], other[key])


def test_threads_are_as_many_as_were_said():
    first = umbrage.get_threads()
    assert first >= 1
    try:
        umbrage.set_threads(3)
        assert umbrage.get_threads() == 3
        with pytest.raises(ValueError, match="n: expected 0 to 1024 threads, found 1025"):
            umbrage.set_threads(1025)
    finally:
        umbrage.set_threads(0)
    assert umbrage.get_threads() == first


def test_other_python_threads_go_on_meanwhile(random):
    """One call that takes long, on one thread; whoever wants Python's lock gets it."""
    scene = scene_of(*soup(random, 20000, 0.05), nthreads=1)
    directions = random.normal(size=(2_000_000, 3)).astype(np.float32)
    asked = threading.Thread(target=lambda: scene.scan([0, 0, 0], directions))
    asked.start()
    counted = 0
    while asked.is_alive():
        time.sleep(0.001)
        counted += 1
    assert counted > 10


def test_two_threads_may_ask_the_same_scene(random):
    vertices, triangles = soup(random, 500)
    scene, directions = scene_of(vertices, triangles), random.normal(size=(20000, 3)).astype(np.float32)
    expected, answers = scene.scan([0, 0, 0], directions)["t_hit"], []
    threads = [threading.Thread(target=lambda: answers.append(scene.scan([0, 0, 0], directions)["t_hit"])) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(answers) == 4
    for answer in answers:
        np.testing.assert_array_equal(answer, expected)


LONG = """
import signal
import numpy as np, umbrage
# Shells start programs in the background without it.
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = umbrage.RaycastingScene(nthreads=1)
scene.add_triangles(np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), [[0, 1, 2]])
suns = umbrage.Light.suns(np.random.default_rng(1).normal(size=(20_000, 3)))
points = np.random.default_rng(2).normal(size=(200_000, 3)).astype(np.float32)
animation = umbrage.open("demo:cloth?triangles=100000")
print("begun", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", flush=True)
else:
    print("ended", flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of this kind are POSIX's")
@pytest.mark.parametrize("call", ["scene.lit(suns, points=points)", "animation.render(0.5, 1024, 1024, samples=4096)"])
def test_long_calls_can_be_interrupted(call):
    program = subprocess.Popen([sys.executable, "-c", LONG.format(call=call)], stdout=subprocess.PIPE, text=True)
    try:
        assert program.stdout.readline() == "begun\n"
        time.sleep(0.5)
        program.send_signal(signal.SIGINT)
        assert program.stdout.readline() == "interrupted\n"
        assert program.wait(60) == 0
    finally:
        program.kill()


def test_a_forked_process_has_threads_of_its_own(random):
    if not hasattr(os, "fork"):
        pytest.skip("there is no fork")
    program = """
import os, numpy as np, umbrage
scene = umbrage.RaycastingScene()
scene.add_triangles(np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), [[0, 1, 2]])
ray = [[0.2, 0.2, 1, 0, 0, -1]]
assert scene.cast_rays(ray)["t_hit"][0] == 1
child = os.fork()
if child == 0:
    os._exit(0 if scene.cast_rays(ray)["t_hit"][0] == 1 else 1)
raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    assert subprocess.run([sys.executable, "-c", program], timeout=60).returncode == 0
