"""trimesh's ray queries, beside trimesh's own."""

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")

import umbrage.trimesh
from umbrage.trimesh import ProximityQuery, RayMeshIntersector


@pytest.fixture(params=["box", "icosphere", "torus"])
def mesh(request):
    return {
        "box": trimesh.creation.box,
        "icosphere": lambda: trimesh.creation.icosphere(2),
        "torus": lambda: trimesh.creation.torus(1.0, 0.3),
    }[request.param]()


def rays(random, count=1000):
    return random.uniform(-1.5, 1.5, (count, 3)), random.normal(size=(count, 3))


def test_answers_are_those_of_trimesh(random, mesh):
    from trimesh.ray.ray_triangle import RayMeshIntersector as Theirs

    # Vertices are rounded to float32: so are those that trimesh is asked about.
    mesh = trimesh.Trimesh(mesh.vertices.astype(np.float32), mesh.faces, process=False)
    ours, theirs = RayMeshIntersector(mesh), Theirs(mesh)
    origins, directions = rays(random)
    for multiple in (True, False):
        ray_of, tri_of = {}, {}
        for name, asked in (("ours", ours), ("theirs", theirs)):
            index_tri, index_ray, locations = asked.intersects_id(origins, directions, multiple_hits=multiple, return_locations=True)
            order = np.lexsort((index_tri, index_ray))
            ray_of[name], tri_of[name] = (index_ray[order], index_tri[order]), locations[order]
        assert len(ray_of["ours"][0]) > 50
        np.testing.assert_array_equal(ray_of["ours"][0], ray_of["theirs"][0])
        np.testing.assert_array_equal(ray_of["ours"][1], ray_of["theirs"][1])
        np.testing.assert_allclose(tri_of["ours"], tri_of["theirs"], atol=1e-9)
    np.testing.assert_array_equal(ours.intersects_any(origins, directions), theirs.intersects_any(origins, directions))
    np.testing.assert_array_equal(ours.intersects_first(origins, directions), theirs.intersects_first(origins, directions))


def test_hits_are_ray_by_ray_and_the_nearest_first(random, mesh):
    ours = RayMeshIntersector(mesh)
    origins, directions = rays(random)
    locations, index_ray, index_tri = ours.intersects_location(origins, directions)
    assert (np.diff(index_ray) >= 0).all()
    away = ((locations - origins[index_ray]) * directions[index_ray]).sum(axis=1)
    again = index_ray[1:] == index_ray[:-1]
    assert (np.diff(away)[again] > 0).all() and again.any()
    _, limited, _ = ours.intersects_location(origins, directions, max_hits=1)
    np.testing.assert_array_equal(limited, np.unique(index_ray))


def test_a_ray_through_an_edge_has_one_location(mesh):
    box = trimesh.creation.box()
    ours = RayMeshIntersector(box)
    # Each face of a box has a diagonal through its middle.
    locations, _, _ = ours.intersects_location([[0, 0, 5]], [[0, 0, -1]])
    np.testing.assert_allclose(locations, [[0, 0, 0.5], [0, 0, -0.5]])
    assert len(ours.intersects_id([[0, 0, 5]], [[0, 0, -1]])[0]) == 4


def test_rays_through_corners_count_as_trimesh_counts_them():
    from trimesh.ray.ray_triangle import RayMeshIntersector as Theirs

    # Straight down on corners, edges and faces of an octahedron on the ground, exactly: coordinates are halves.
    corners = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    faces = [[4, 0, 2], [4, 2, 1], [4, 1, 3], [4, 3, 0], [5, 2, 0], [5, 1, 2], [5, 3, 1], [5, 0, 3]]
    mesh = trimesh.Trimesh(corners, faces, process=False)
    origins = np.array([[0, 0, 5], [0.5, 0, 5], [0.25, 0.25, 5]])
    directions = np.broadcast_to([0, 0, -1.0], origins.shape)
    ours, theirs = RayMeshIntersector(mesh), Theirs(mesh)

    def counts(asked, **keywords):
        return np.bincount(asked.intersects_id(origins, directions, **keywords)[1], minlength=3).tolist()

    assert counts(ours) == counts(theirs) == [8, 4, 2]
    assert counts(ours, return_locations=True) == counts(theirs, return_locations=True) == [2, 2, 2]
    assert counts(ours, unique=True) == [2, 2, 2]
    assert counts(ours, return_locations=True, unique=False) == [8, 4, 2]
    assert counts(ours, unique=True, max_hits=1) == [1, 1, 1]
    # Of a corner's triangles the lowest is hit, on either side.
    assert ours.intersects_id(origins[:1], directions[:1], unique=True)[0].tolist() == [0, 4]


def test_points_inside_are_told_from_those_outside(random):
    ball = trimesh.creation.icosphere(3)
    points = random.uniform(-1.2, 1.2, (2000, 3))
    away = np.linalg.norm(points, axis=1)
    clear = (away < 0.985) | (away > 1)
    inside = RayMeshIntersector(ball).contains_points(points)
    np.testing.assert_array_equal(inside[clear], (away < 1)[clear])
    torus = RayMeshIntersector(trimesh.creation.torus(1.0, 0.3))
    assert torus.contains_points([[0, 0, 0], [1, 0, 0], [0, -1, 0.1], [0, 0, 0.2]]).tolist() == [False, True, True, False]
    assert RayMeshIntersector(trimesh.Trimesh()).contains_points([[0, 0, 0]]).tolist() == [False]


def test_a_mesh_that_changed_is_looked_at_again():
    box = trimesh.creation.box()
    ours = RayMeshIntersector(box)
    asked = ([[3, 0.1, 5]], [[0, 0, -1]])
    assert not ours.intersects_any(*asked)[0]
    box.apply_translation([3, 0, 0])
    assert ours.intersects_any(*asked)[0]


def test_it_takes_the_place_of_trimeshs_own():
    ball = trimesh.creation.icosphere()
    ball.ray = umbrage.trimesh.RayMeshIntersector(ball)
    assert ball.ray.contains_points([[0, 0, 0]]).all()
    assert ball.contains([[0.1, 0.2, 0], [3, 0, 0]]).tolist() == [True, False]


def test_distances_are_those_of_trimesh(random, mesh):
    mesh = trimesh.Trimesh(mesh.vertices.astype(np.float32), mesh.faces, process=False)
    points = random.uniform(-1.5, 1.5, (300, 3)).astype(np.float32)
    ours = ProximityQuery(mesh)
    closest, distance, triangle = ours.on_surface(points)
    theirs, their_distance, _ = trimesh.proximity.closest_point_naive(mesh, points)
    np.testing.assert_allclose(distance, their_distance, atol=1e-7)
    np.testing.assert_allclose(closest, theirs, atol=1e-6)
    assert triangle.dtype == np.int64
    signed = ours.signed_distance(points)
    np.testing.assert_array_equal(np.abs(signed), distance)
    far = distance > 1e-6
    np.testing.assert_array_equal(signed[far] > 0, mesh.ray.contains_points(points)[far])
    assert 5 < np.count_nonzero(signed > 0) < 290
