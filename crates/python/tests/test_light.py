"""Which points and how much of faces lights reach."""

import numpy as np
import pytest
from conftest import oracle, scene_of, soup, sphere

import umbrage

INVALID = umbrage.RaycastingScene.INVALID_ID


def test_points_are_lit_where_nothing_stands_before_the_light(random):
    vertices, triangles = soup(random, 200)
    scene = scene_of(vertices, triangles)
    points = random.uniform(-1.2, 1.2, (500, 3)).astype(np.float32)
    suns = random.normal(size=(3, 3)).astype(np.float32)
    bulb = np.float32([0.1, 3, 0.2])
    lit = scene.lit([*umbrage.Light.suns(suns), umbrage.Light.point(bulb)], points=points)
    assert lit.shape == (4, 500) and lit.dtype == bool
    assert 0.05 < lit.mean() < 0.95
    for light in range(4):
        directions = np.broadcast_to(-suns[light], points.shape) if light < 3 else bulb.astype(np.float64) - points
        t, _, margin = oracle(vertices, triangles, points, directions)
        clear = margin > 1e-5
        assert clear.mean() > 0.95
        np.testing.assert_array_equal(lit[light, clear], ~(t < (np.inf if light < 3 else 1))[clear])


def test_a_spot_lights_its_cone_only():
    scene = umbrage.RaycastingScene()
    points = np.float32([[np.tan(np.radians(angle)), 0, 0] for angle in (0, 9, 11, 40)])
    lit = scene.lit(umbrage.Light.spot([0, 1, 0], [0, 0, 0], 20), points=points)
    assert lit.tolist() == [[True, True, False, False]]


def test_faces_are_their_own_triangles_centroids():
    vertices, triangles = sphere()
    scene = scene_of(vertices, triangles)
    light = umbrage.Light.sun([0.3, -1, 0.2])
    lit = scene.lit(light, faces=True)
    corners = vertices.astype(np.float64)[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    towards = normals @ [-0.3, 1, -0.2] / np.linalg.norm(normals, axis=1)
    # A ball shades its far side.
    assert lit.shape == (1, len(triangles))
    np.testing.assert_array_equal(lit[0][np.abs(towards) > 1e-6], (towards > 0)[np.abs(towards) > 1e-6])
    centroids = corners.mean(axis=1)
    ids = np.arange(len(triangles), dtype=np.uint32)
    as_points = scene.lit(light, points=centroids, geometry_ids=np.zeros_like(ids), primitive_ids=ids)
    np.testing.assert_array_equal(as_points, lit)
    # Without their own triangles, points that rounding put below the surface are dark.
    nowhere = scene.lit(light, points=centroids, geometry_ids=ids * 0 + INVALID, primitive_ids=ids * 0 + INVALID)
    np.testing.assert_array_equal(nowhere, scene.lit(light, points=centroids))
    assert (nowhere <= as_points).all() and (nowhere != as_points).any()


def test_more_lights_than_one_piece_are_in_order(random):
    scene = scene_of(*soup(random, 50))
    points = random.uniform(-1, 1, (100, 3)).astype(np.float32)
    suns = umbrage.Light.suns(random.normal(size=(130, 3)))
    lit = scene.lit(suns, points=points)
    for index in (0, 63, 64, 129):
        np.testing.assert_array_equal(lit[index], scene.lit(suns[index], points=points)[0])


def test_areas_are_shaded_by_as_much_as_is_above():
    # A square whose half is below another one.
    square = np.float32([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]])
    scene = scene_of(square, [[0, 1, 2], [0, 2, 3]])
    scene.add_triangles(square * np.float32([0.5, 1, 1]) + np.float32([0, 1, 0]), [[0, 1, 2], [0, 2, 3]])
    areas = scene.lit_areas([umbrage.Light.sun([0, -1, 0]), umbrage.Light.sun([0, 1, 0])], samples=1024)
    share, error = areas["share"], areas["standard_error"]
    assert share.shape == error.shape == (2, 4)
    # The first triangle has three quarters of its area at x > 1/2, the second one a quarter.
    np.testing.assert_allclose(share[0, :2], [0.75, 0.25], atol=0.01)
    assert (share[0, 2:] == 1).all() and (error[0, 2:] < 0.001).all(), "none of so many samples is no proof of none"
    assert (np.abs(share[0, :2] - [0.75, 0.25]) < 3 * error[0, :2]).all()
    assert (error[0, :2] < 0.02).all()
    # From below: the lower one is lit on its other side, and shades all of the upper one.
    np.testing.assert_array_equal(share[1], [1, 1, 0, 0])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_points_that_are_nowhere_are_dark(bad):
    assert not umbrage.RaycastingScene().lit(umbrage.Light.sun([0, -1, 0]), points=[[bad, 0, 0]]).any()


def test_lights_are_said_in_the_words_of_the_command(random):
    scene = scene_of(*soup(random, 100))
    points = random.uniform(-1, 1, (200, 3)).astype(np.float32)
    said = ["sun:-1,-2,-1", "point:0,3,0:5:1,0.5,0", "spot:0,3,0:0,0,0:60"]
    lights = [umbrage.Light.sun([-1, -2, -1]), umbrage.Light.point([0, 3, 0]), umbrage.Light.spot([0, 3, 0], [0, 0, 0], 60)]
    lit = scene.lit(said, points=points)
    np.testing.assert_array_equal(lit, scene.lit(lights, points=points))
    np.testing.assert_array_equal(lit[:1], scene.lit(said[0], points=points))
    assert 0.05 < lit.mean() < 0.95
    np.testing.assert_array_equal(scene.lit_areas(said[0])["share"], scene.lit_areas(lights[0])["share"])


def test_light_from_behind_counts_unless_only_the_front_does(random):
    vertices, triangles = soup(random, 100)
    scene = scene_of(vertices, triangles)
    lights = ["sun:0.3,-1,0.2", "point:0.2,3,0.1", *umbrage.Light.suns(random.normal(size=(70, 3)))]
    lit, facing = scene.lit(lights, faces=True), scene.lit(lights, faces=True, facing=True)
    cosines = scene.incidence(lights, faces=True)
    assert cosines.shape == (72, 100) and cosines.dtype == np.float32
    clear = np.abs(cosines) > 1e-6
    np.testing.assert_array_equal(facing[clear], (lit & (cosines > 0))[clear])
    assert (facing != lit).any() and facing.any()
    # Points on the triangles say the same, and a point on none has no side.
    corners = vertices.astype(np.float64)[triangles]
    ids = {"geometry_ids": np.zeros(100, np.uint32), "primitive_ids": np.arange(100, dtype=np.uint32)}
    np.testing.assert_array_equal(scene.lit(lights, points=corners.mean(axis=1), facing=True, **ids), facing)
    nowhere = {"geometry_ids": [INVALID], "primitive_ids": [INVALID]}
    assert scene.lit("sun:0,-1,0", points=[[0, 9, 0]], facing=True, **nowhere).all()
    assert np.isnan(scene.incidence("sun:0,-1,0", points=[[0, 9, 0]], **nowhere)).all()


def test_incidence_is_the_cosine_to_the_normal(random):
    vertices, triangles = sphere()
    scene = scene_of(vertices, triangles)
    corners = vertices.astype(np.float64)[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    to_bulb = [0.5, 3, 1] - corners.mean(axis=1)
    expected = [normals @ [0, 1, 0], (normals * to_bulb).sum(axis=1) / np.linalg.norm(to_bulb, axis=1)]
    np.testing.assert_allclose(scene.incidence(["sun:0,-2,0", "point:0.5,3,1"], faces=True), expected, atol=1e-6)
    # At a corner of its triangle, a point has another direction to the bulb.
    ids = {"geometry_ids": np.zeros(len(triangles), np.uint32), "primitive_ids": np.arange(len(triangles), dtype=np.uint32)}
    to_bulb = [0.5, 3, 1] - corners[:, 0]
    expected = (normals * to_bulb).sum(axis=1) / np.linalg.norm(to_bulb, axis=1)
    np.testing.assert_allclose(scene.incidence("point:0.5,3,1", points=corners[:, 0], **ids)[0], expected, atol=1e-6)
