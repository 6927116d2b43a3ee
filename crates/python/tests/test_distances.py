"""Distances: nearest points beside brute force, and insides of closed meshes."""

import numpy as np
import pytest
from conftest import scene_of, soup, sphere

import umbrage

INVALID = umbrage.RaycastingScene.INVALID_ID


def nearest_on_triangle(point, a, b, c):
    """The nearest point of a triangle, by trying its inside, its sides and its corners."""
    normal = np.cross(b - a, c - a)
    on_plane = point - normal * (normal @ (point - a)) / (normal @ normal)
    ways = [(a, b), (b, c), (c, a)]
    if all(np.cross(end - start, on_plane - start) @ normal >= 0 for start, end in ways):
        return on_plane
    on_sides = [start + (end - start) * np.clip((point - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1) for start, end in ways]
    return min(on_sides, key=lambda at: np.linalg.norm(at - point))


def test_nearest_points_are_those_of_brute_force(random):
    vertices, triangles = soup(random, 60)
    scene = scene_of(vertices, triangles)
    points = random.uniform(-2, 2, (4, 30, 3)).astype(np.float32)
    found = scene.compute_closest_points(points)
    assert {name: of.shape for name, of in found.items()} == {
        "geometry_ids": (4, 30),
        "primitive_ids": (4, 30),
        "primitive_uvs": (4, 30, 2),
        "primitive_normals": (4, 30, 3),
        "points": (4, 30, 3),
    }
    corners = vertices.astype(np.float64)[triangles]
    for index in np.ndindex(4, 30):
        point = points[index].astype(np.float64)
        nearest = min((nearest_on_triangle(point, *of) for of in corners), key=lambda at: np.linalg.norm(at - point))
        np.testing.assert_allclose(found["points"][index], nearest, atol=1e-9)
        own, (u, v) = corners[found["primitive_ids"][index]], found["primitive_uvs"][index].astype(np.float64)
        np.testing.assert_allclose(own[0] * (1 - u - v) + own[1] * u + own[2] * v, nearest, atol=1e-5)
    distance = scene.compute_distance(points)
    np.testing.assert_allclose(distance, np.linalg.norm(found["points"] - points, axis=-1), rtol=1e-9)
    np.testing.assert_array_equal(distance, scene.compute_distance(points, nthreads=1))


def test_insides_of_closed_meshes_have_distances_below_zero(random):
    vertices, triangles = sphere()
    scene = scene_of(vertices, triangles)
    points = random.uniform(-1.5, 1.5, (2000, 3)).astype(np.float32)
    signed, radius = scene.compute_signed_distance(points), np.linalg.norm(points, axis=1)
    np.testing.assert_array_equal(np.abs(signed), scene.compute_distance(points))
    assert (signed[radius > 1.001] > 0).all() and (signed[radius < 0.9] < 0).all()
    occupancy = scene.compute_occupancy(points)
    assert occupancy.dtype == np.float32
    np.testing.assert_array_equal(occupancy, signed < 0)


def test_distances_follow_meshes_that_move_and_name_their_geometry():
    vertices, triangles = sphere()
    scene = scene_of(vertices, triangles)
    other = scene.add_triangles(vertices + np.float32([10, 0, 0]), triangles)
    found = scene.compute_closest_points([[9, 0.2, 0.1], [0.9, 0.2, 0.1]])
    np.testing.assert_array_equal(found["geometry_ids"], [other, 0])
    before = scene.compute_distance([0, 0, 5])
    scene.update_vertices(0, vertices + np.float32([0, 0, 1]))
    assert before.shape == () and abs(before - scene.compute_distance([0, 0, 5]) - 1) < 1e-6


def test_points_without_an_answer():
    empty = umbrage.RaycastingScene()
    assert empty.compute_distance([[1, 2, 3]]) == np.inf and empty.compute_occupancy([[1, 2, 3]]) == 0
    scene = scene_of(*sphere())
    found = scene.compute_closest_points([[np.nan, 0, 0], [np.inf, 0, 0]])
    assert (found["primitive_ids"] == INVALID).all() and (found["geometry_ids"] == INVALID).all()
    assert np.isnan(found["points"]).all() and (found["primitive_uvs"] == 0).all()
    assert (scene.compute_signed_distance([[np.nan, 0, 0]]) == np.inf).all()
    assert scene.compute_closest_points(np.empty((0, 3)))["points"].shape == (0, 3)
    with pytest.raises(ValueError, match=r"query_points: expected shape \(\.\.\., 3\)"):
        scene.compute_distance([[1, 2]])


def test_far_from_the_origin_points_are_as_exact_as_near_it(random):
    vertices, triangles = sphere()
    origin = np.array([4e6, -2e6, 1e6])
    scene = umbrage.RaycastingScene(origin=origin)
    scene.add_triangles(vertices, triangles)
    near = scene_of(vertices, triangles)
    points = random.uniform(-2, 2, (200, 3)).astype(np.float32).astype(np.float64)
    # The points are rounded to the grid of numbers around the origin before both are asked.
    points = (points + origin) - origin
    np.testing.assert_array_equal(scene.compute_distance(points + origin), near.compute_distance(points.astype(np.float32)))
    found = scene.compute_closest_points(points + origin)["points"] - origin
    np.testing.assert_allclose(found, near.compute_closest_points(points.astype(np.float32))["points"], atol=1e-9)
