"""Masks: what a mask hides isn't there, as in a scene without it."""

import copy
import pickle

import numpy as np
import pytest
from conftest import soup, sphere

import umbrage

ALL = 0xFFFFFFFF
GEOMETRY_MASKS = [ALL, 0b01, 0b10, 0b110, 0]


def meshes(random, frame):
    """A housing around the sensor, and others around that."""
    return [sphere(4, 6)] + [soup(random, 60 + 10 * number + frame, 0.5) for number in range(len(GEOMETRY_MASKS) - 1)]


@pytest.fixture(params=["new", "moved", "copied", "pickled", "removed"])
def scenes(request, random):
    """A scene with masks, and the same for a mask without what it hides, where hidden geometries have no triangles."""
    parts = meshes(random, 0)
    # The housing has a mask of its own.
    masks = [0b10, *GEOMETRY_MASKS[:-1]]
    scene = umbrage.RaycastingScene()
    for number, ((vertices, triangles), mask) in enumerate(zip(parts, masks)):
        scene.add_triangles(vertices * (0.1 if number == 0 else 1), triangles, mask=mask)
    if request.param == "moved":
        scene.cast_rays([[0, 0, 0, 1, 0, 0]])
        for number, (vertices, _) in enumerate(parts):
            vertices *= np.float32(0.9)
            scene.update_vertices(number, vertices * (0.1 if number == 0 else 1))
    elif request.param == "copied":
        scene = copy.copy(scene)
    elif request.param == "pickled":
        scene = pickle.loads(pickle.dumps(scene))
    elif request.param == "removed":
        scene.remove(1)
        parts[1] = parts[1][0], np.empty((0, 3), np.uint32)

    def left(mask):
        other = umbrage.RaycastingScene()
        for number, ((vertices, triangles), of_mesh) in enumerate(zip(parts, masks)):
            is_seen = mask & of_mesh
            other.add_triangles(vertices * (0.1 if number == 0 else 1), triangles if is_seen else triangles[:0])
        return other

    return scene, left


def rays_of(random, count):
    return np.float32(np.hstack((random.uniform(-1.5, 1.5, (count, 3)), random.normal(size=(count, 3)))))


QUESTIONS = {
    "cast_rays": lambda scene, rays, **named: scene.cast_rays(rays, **named),
    "test_occlusions": lambda scene, rays, **named: {"": scene.test_occlusions(rays, 0.1, 2, **named)},
    "count_intersections": lambda scene, rays, **named: {"": scene.count_intersections(rays, **named)},
}


@pytest.mark.parametrize("ask", QUESTIONS.values(), ids=QUESTIONS)
@pytest.mark.parametrize("together", [False, True], ids=["apart", "together"])
def test_rays_pass_what_their_masks_hide(scenes, random, ask, together):
    scene, left = scenes
    rays = rays_of(random, 3000)
    if together:
        rays[:, :3] = 0
    masks = np.array(GEOMETRY_MASKS)[np.sort(random.integers(0, len(GEOMETRY_MASKS), len(rays)))]
    answer, plain = ask(scene, rays, mask=masks), ask(scene, rays)
    assert any((answer[key] != plain[key]).any() for key in answer), "masks hide something"
    for mask in GEOMETRY_MASKS:
        these, expected = masks == mask, ask(left(mask), rays[masks == mask])
        one = ask(scene, rays[these], mask=mask)
        for key in expected:
            np.testing.assert_array_equal(answer[key][these], expected[key])
            np.testing.assert_array_equal(one[key], expected[key])


def test_lists_leave_out_what_masks_hide(scenes, random):
    scene, left = scenes
    rays = rays_of(random, 300)
    for mask in GEOMETRY_MASKS:
        found, expected = scene.list_intersections(rays, mask=mask), left(mask).list_intersections(rays)
        for key in expected:
            np.testing.assert_array_equal(found[key], expected[key])


@pytest.mark.parametrize("returns", [None, 3])
def test_each_sensor_has_its_mask(scenes, random, returns):
    scene, left = scenes
    directions = np.float32(random.normal(size=(700, 3)))
    origins = np.linspace([0, 0, 0], [0.3, 0.1, 0.4], len(GEOMETRY_MASKS))
    found = scene.scan(origins, directions, returns=returns, mask=GEOMETRY_MASKS)
    met = scene.scan_any(origins, directions, mask=GEOMETRY_MASKS)
    for number, mask in enumerate(GEOMETRY_MASKS):
        expected = left(mask).scan(origins[number], directions, returns=returns)
        one = scene.scan(origins[number], directions, returns=returns, mask=mask)
        for key in expected:
            np.testing.assert_array_equal(found[key][number], expected[key])
            np.testing.assert_array_equal(one[key], expected[key])
        first = expected["t_hit"] if returns is None else expected["t_hit"][:, 0]
        np.testing.assert_array_equal(met[number], np.isfinite(first))


@pytest.mark.parametrize("camera", ["square", "stretched"])
def test_cameras_have_masks(scenes, camera):
    scene, left = scenes
    if camera == "square":
        camera = umbrage.Camera([0, 0, 0], [0.1, -0.2, 1], fov_degrees=80)
    else:
        camera = umbrage.Camera.from_intrinsics([[30, 0, 32], [0, 25, 24], [0, 0, 1]], width=64, height=48)
    for mask in GEOMETRY_MASKS:
        found, expected = scene.see(camera, 64, 48, mask=mask), left(mask).see(camera, 64, 48)
        for key in expected:
            np.testing.assert_array_equal(found[key], expected[key])


def test_lights_have_masks(scenes, random):
    scene, left = scenes
    points = np.float32(random.uniform(-1.5, 1.5, (2000, 3)))
    lights = umbrage.Light.suns(random.normal(size=(len(GEOMETRY_MASKS), 3)))
    # More lights than are asked about at once.
    many, masks = lights * 20, GEOMETRY_MASKS * 20
    found = scene.lit(many, points=points, mask=masks)
    assert (found != scene.lit(many, points=points)).any()
    for number in (0, 1, 2, 3, 4, 70, 96):
        np.testing.assert_array_equal(found[number], left(masks[number]).lit(many[number], points=points)[0])
    np.testing.assert_array_equal(scene.lit(lights, points=points, mask=0b10), left(0b10).lit(lights, points=points))
    shares = scene.lit_areas(lights, samples=8, mask=GEOMETRY_MASKS)["share"]
    for number, mask in enumerate(GEOMETRY_MASKS):
        np.testing.assert_array_equal(shares[number], scene.lit_areas(lights[number], samples=8, mask=mask)["share"][0])
    usable = shares[4] > 0
    assert (shares[4][usable] == 1).all() and (shares[0] < 1).any(), "no triangle stops light of the mask 0"


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda s: s.cast_rays(np.zeros((4, 6)), mask=[1, 2]), ValueError, r"mask: expected shape \(\) or \(4,\) uint32, found shape \(2,\) int64"),
        (lambda s: s.cast_rays(np.zeros(6), mask=[1]), ValueError, r"mask: expected shape \(\) uint32, found shape \(1,\) int64"),
        (lambda s: s.cast_rays(np.zeros((4, 6)), mask=-1), ValueError, "mask: expected numbers from 0 to 4294967295, found -1"),
        (lambda s: s.cast_rays(np.zeros((4, 6)), mask=1 << 32), ValueError, "mask: expected numbers from 0 to 4294967295"),
        (lambda s: s.cast_rays(np.zeros((4, 6)), mask=0.5), TypeError, r"mask: expected shape \(\) or \(4,\) uint32, found shape \(\) float64"),
        (lambda s: s.scan(np.zeros((2, 3)), [[1, 0, 0]], mask=[1]), ValueError, r"mask: expected shape \(\) or \(2,\) uint32"),
        (lambda s: s.lit(["sun:0,-1,0"], faces=True, mask=[1, 1]), ValueError, r"mask: expected shape \(\) or \(1,\) uint32"),
        (lambda s: s.add_triangles(np.zeros((3, 3)), [[0, 1, 2]], mask=-1), OverflowError, "mask"),
    ],
)
def test_bad_masks_are_refused(call, error, words):
    with pytest.raises(error, match=words):
        call(umbrage.RaycastingScene())
