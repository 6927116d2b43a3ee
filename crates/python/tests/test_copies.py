"""Copies and pickles, also in other processes."""

import copy
import pathlib
import pickle
import subprocess
import sys

import numpy as np
import pytest
from conftest import gltf_of_two_balls, scene_of, soup, sphere

import umbrage

AGAIN = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda of: pickle.loads(pickle.dumps(of)),
    "old pickle": lambda of: pickle.loads(pickle.dumps(of, protocol=2)),
}


@pytest.fixture(params=AGAIN)
def again(request):
    return AGAIN[request.param]


@pytest.mark.parametrize(
    "camera",
    [
        umbrage.Camera([1, 2, 3], [0.1, 0.2, 0.3], [0.3, 1, 0], fov_degrees=33),
        umbrage.Camera([1, 2, 3], [0, 0, 0], half_height=1.7),
        umbrage.Camera.from_intrinsics([[90, 0, 31.3], [0, 80, 22], [0, 0, 1]], width=48, height=32),
    ],
    ids=["perspective", "parallel", "intrinsics"],
)
def test_cameras_are_the_same(again, camera):
    same = again(camera)
    assert isinstance(same, umbrage.Camera) and same.size == camera.size and repr(same) == repr(camera)
    np.testing.assert_array_equal(same.rays(48, 32), camera.rays(48, 32))


def test_lights_are_the_same(again, random):
    scene = scene_of(*soup(random, 100))
    points = random.uniform(-1, 1, (500, 3)).astype(np.float32)
    lights = [umbrage.Light.sun([0.3, -1, 0.1]), umbrage.Light.point([0.1, 3, 0]), umbrage.Light.spot([0, 3, 0], [0.1, 0, 0], 33)]
    same = again(lights)
    assert list(map(repr, same)) == list(map(repr, lights))
    np.testing.assert_array_equal(scene.lit(same, points=points), scene.lit(lights, points=points))


def test_meshes_are_the_same_and_move_apart(again, random):
    vertices, triangles = sphere()
    scene = umbrage.RaycastingScene(nthreads=2)
    for id in range(3):
        scene.add_triangles(vertices + np.float32([0, 0, 3 * id]), triangles)
    scene.set_transform(2, np.hstack((np.linalg.qr(random.normal(size=(3, 3)))[0], [[0.1], [1], [0.3]])))
    scene.remove(1)
    rays = np.hstack((random.uniform(-6, 6, (2000, 3)), random.normal(size=(2000, 3))))
    expected = scene.cast_rays(rays)
    assert set(expected["geometry_ids"]) == {0, 2, scene.INVALID_ID}
    other = again(scene)
    found = other.cast_rays(rays)
    for key in expected:
        np.testing.assert_array_equal(found[key], expected[key])
    with pytest.raises(IndexError, match="removed"):
        other.remove(1)
    other.update_vertices(2, vertices)
    assert (other.cast_rays(rays)["t_hit"] != expected["t_hit"]).any()
    np.testing.assert_array_equal(scene.cast_rays(rays)["t_hit"], expected["t_hit"])
    assert other.add_triangles(vertices, triangles) == 3


def test_files_are_opened_again_with_their_options(again, tmp_path, monkeypatch):
    (tmp_path / "balls.gltf").write_text(gltf_of_two_balls())
    monkeypatch.chdir(tmp_path)
    file = umbrage.open("balls.gltf", hide=["stays"])
    monkeypatch.chdir(pathlib.Path(__file__).parent)
    other = again(file)
    np.testing.assert_array_equal(other.at(0.5).vertices, file.at(0.5).vertices)
    assert [part.name for part in other.instances(0)] == ["rises"]


def test_a_pickle_of_a_file_that_went_says_so(tmp_path):
    path = tmp_path / "balls.gltf"
    path.write_text(gltf_of_two_balls())
    pickled = pickle.dumps(umbrage.open(path))
    path.unlink()
    with pytest.raises(FileNotFoundError, match="balls.gltf"):
        pickle.loads(pickled)


def test_frames_and_instances_are_the_same(again):
    cloth = umbrage.open("demo:cloth?triangles=2000")
    frame, part = cloth.at(0.5), cloth.instances(0.5)[1]
    same, other = again(frame), again(part)
    assert same.seconds == frame.seconds and other.name == part.name
    assert repr(same.cameras) == repr(frame.cameras) and repr(same.lights) == repr(frame.lights)
    for name in ("vertices", "triangles"):
        np.testing.assert_array_equal(getattr(same, name), getattr(frame, name))
        np.testing.assert_array_equal(getattr(other, name), getattr(part, name))
    np.testing.assert_array_equal(other.world_from_object, part.world_from_object)


def test_other_processes_answer_as_the_guide_says(tmp_path):
    guide = (pathlib.Path(__file__).parents[3] / "docs/python.md").read_text(encoding="utf-8")
    (example,) = [block.split("```")[0] for block in guide.split("```python\n")[1:] if "ProcessPoolExecutor" in block]
    script = tmp_path / "several.py"
    script.write_text(example)
    said = subprocess.run([sys.executable, script], check=True, capture_output=True, text=True).stdout
    assert said.splitlines() == ["[(90, 160, 3), (90, 160, 3)]", "True"]
