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


def full_winding_number(point, corners):
    """The sum of all solid angles by the formula of Van Oosterom and Strackee, in whole spheres."""
    a, b, c = (corners[:, number] - point for number in range(3))
    of_a, of_b, of_c = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
    determinant = np.einsum("ij,ij->i", a, np.cross(b, c))
    dot = lambda u, v: np.einsum("ij,ij->i", u, v)
    pairs = ((a, b, of_c), (b, c, of_a), (c, a, of_b))
    real = of_a * of_b * of_c + sum(np.einsum("ij,ij->i", u, v) * size for u, v, size in pairs)
    return np.arctan2(determinant, real).sum() / (2 * np.pi)


def test_winding_numbers_are_near_the_full_sum(random):
    vertices, triangles = sphere()
    points = random.uniform(-1.5, 1.5, (3, 40, 3)).astype(np.float32)
    signs = set()
    # A ball turned either way, one with a hole, and loose triangles.
    for mesh in [(vertices, triangles), (vertices, triangles[:, ::-1]), (vertices, triangles[8:]), soup(random, 200)]:
        scene = scene_of(mesh[0], np.ascontiguousarray(mesh[1]))
        numbers = scene.compute_winding_numbers(points)
        assert numbers.shape == (3, 40) and numbers.dtype == np.float64
        corners = mesh[0].astype(np.float64)[mesh[1]]
        expected = [full_winding_number(point.astype(np.float64), corners) for point in points.reshape(-1, 3)]
        np.testing.assert_allclose(numbers.reshape(-1), expected, atol=1e-2)
        np.testing.assert_array_equal(numbers, scene.compute_winding_numbers(points, nthreads=1))
        signs.add(round(float(scene.compute_winding_numbers([0, 0, 0]))))
    assert {1, -1} <= signs
    assert np.isnan(scene.compute_winding_numbers([np.nan, 0, 0]))
    assert umbrage.RaycastingScene().compute_winding_numbers([[1, 2, 3]]) == 0


def test_overlapping_triangles_touch_boxes():
    vertices, triangles = sphere()
    scene = scene_of(vertices, triangles)
    other = scene.add_triangles(vertices + np.float32([10, 0, 0]), triangles)
    boxes = np.float32([[[-2, -2, -2], [2, 2, 2]], [[-0.1, -0.1, -0.1], [0.1, 0.1, 0.1]], [[9.9, 1, -0.1], [10.1, 2, 0.1]], [[1, 1, 1], [0, 0, 0]]])
    found = scene.list_overlapping(boxes)
    all_of, around = len(triangles), (triangles == 0).any(axis=1).nonzero()[0]
    # Everything; nothing in the middle; the triangles that only touch the box on the other ball's pole; nothing in no box.
    np.testing.assert_array_equal(found["box_splits"], [0, all_of, all_of, all_of + len(around), all_of + len(around)])
    np.testing.assert_array_equal(found["primitive_ids"], np.concatenate((np.arange(all_of), around)))
    np.testing.assert_array_equal(found["geometry_ids"], np.repeat([0, other], [all_of, len(around)]))
    np.testing.assert_array_equal(found["box_ids"], np.repeat([0, 2], [all_of, len(around)]))
    with pytest.raises(ValueError, match=r"boxes: expected shape \(\.\.\., 2, 3\)"):
        scene.list_overlapping([[1, 2, 3]])


def test_thickness_is_the_distance_to_the_next_surface_behind():
    # A slab from z = 0 to 0.25, whose faces are counterclockwise from outside, and a sheet 1e-6 below its top.
    square = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    faces = np.uint32([[0, 1, 2], [0, 2, 3]])
    scene = umbrage.RaycastingScene()
    bottom = scene.add_triangles(square, faces[:, ::-1].copy())
    top = scene.add_triangles(square + np.float32([0, 0, 0.25]), faces)
    on_top, below = [[0.25, 0.5, 0.25], [0.75, 0.25, 0.25]], [[0.5, 0.25, 0.0]]
    np.testing.assert_array_equal(scene.compute_thickness(on_top, [top, top], [1, 0]), [0.25, 0.25])
    np.testing.assert_array_equal(scene.compute_thickness(below, [bottom], [0]), [0.25])
    sheet = scene.add_triangles(square + np.float32([0, 0, 0.249999]), faces)
    thin = scene.compute_thickness(on_top, [top, top], [1, 0])
    np.testing.assert_array_equal(thin, 0.25 - np.float64(np.float32(0.249999)))
    # Nothing is behind the bottom's triangles, seen as if they were the top's.
    scene.remove(sheet)
    scene.remove(top)
    none = scene.compute_thickness(below + [[np.nan, 0, 0], [0, 0, 0]], [bottom, bottom, INVALID], [0, 0, INVALID])
    assert none.shape == (3,) and (none == np.inf).all()
    with pytest.raises(ValueError, match="primitive_ids"):
        scene.compute_thickness(below, [bottom], [99])


def test_balls_are_as_thick_as_they_are(random):
    vertices, triangles = sphere(60, 90)
    scene = scene_of(vertices, triangles)
    found = scene.compute_closest_points(random.uniform(-1, 1, (500, 3)))
    thickness = scene.compute_thickness(found["points"], found["geometry_ids"], found["primitive_ids"])
    outwards = (found["primitive_normals"] * found["points"]).sum(axis=1)[0] > 0
    assert (np.abs(thickness - 2) < 0.01).all() if outwards else (thickness == np.inf).all()
