"""Errors about arrays name the argument, and the shape and dtype that were expected and found."""

import numpy as np
import pytest
from conftest import scene_of

import umbrage
import umbrage.trimesh

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]
RAYS = np.zeros((4, 6), np.float32)
POINTS = np.zeros((4, 3), np.float32)
SUN = umbrage.Light.sun([0, -1, 0])
K = np.diag([30.0, 30, 1])
make = umbrage.RaycastingScene

# The argument's name, shape and dtype, and a call with it.
ARGUMENTS = [
    ("vertex_positions", "(N, 3)", "float32", lambda s, of: s.add_triangles(of, TRIANGLE[1])),
    ("triangle_indices", "(M, 3)", "uint32", lambda s, of: s.add_triangles(TRIANGLE[0], of)),
    ("vertex_positions", "(N, 3)", "float32", lambda s, of: s.update_vertices(0, of)),
    ("world_from_object", "(3 or 4, 4)", "float64", lambda s, of: s.set_transform(0, of)),
    ("rays", "(..., 6)", "float32", lambda s, of: s.cast_rays(of)),
    ("rays", "(..., 6)", "float32", lambda s, of: s.test_occlusions(of)),
    ("rays", "(..., 6)", "float32", lambda s, of: s.count_intersections(of)),
    ("rays", "(..., 6)", "float32", lambda s, of: s.list_intersections(of)),
    ("mask", "() or (4,)", "uint32", lambda s, of: s.cast_rays(RAYS, mask=of)),
    ("mask", "() or (4,)", "uint32", lambda s, of: s.test_occlusions(RAYS, mask=of)),
    ("mask", "() or (4,)", "uint32", lambda s, of: s.count_intersections(RAYS, mask=of)),
    ("mask", "() or (4,)", "uint32", lambda s, of: s.list_intersections(RAYS, mask=of)),
    ("origin", "(..., 3)", "float64", lambda s, of: s.scan(of, POINTS)),
    ("directions", "(..., 3)", "float32", lambda s, of: s.scan([0, 0, 0], of)),
    ("directions", "(..., 3)", "float32", lambda s, of: s.scan_any([0, 0, 0], of)),
    ("mask", "() or (2,)", "uint32", lambda s, of: s.scan([[0, 0, 0]] * 2, POINTS, mask=of)),
    ("mask", "()", "uint32", lambda s, of: s.scan_any([0, 0, 0], POINTS, mask=of)),
    ("query_points", "(..., 3)", "float32", lambda s, of: s.compute_closest_points(of)),
    ("query_points", "(..., 3)", "float32", lambda s, of: s.compute_distance(of)),
    ("query_points", "(..., 3)", "float32", lambda s, of: s.compute_signed_distance(of)),
    ("query_points", "(..., 3)", "float32", lambda s, of: s.compute_occupancy(of)),
    ("points", "(..., 3)", "float32", lambda s, of: s.lit(SUN, points=of)),
    ("geometry_ids", "(4,)", "uint32", lambda s, of: s.lit(SUN, points=POINTS, geometry_ids=of, primitive_ids=[0] * 4)),
    ("primitive_ids", "(4,)", "uint32", lambda s, of: s.incidence(SUN, points=POINTS, geometry_ids=[0] * 4, primitive_ids=of)),
    ("mask", "() or (1,)", "uint32", lambda s, of: s.lit(SUN, faces=True, mask=of)),
    ("mask", "() or (1,)", "uint32", lambda s, of: s.lit_areas(SUN, mask=of)),
    ("primitive_uvs", "(..., 2)", "float32", lambda s, of: s.object_positions([0], [0], of)),
    ("intrinsic_matrix", "(3, 3)", "float64", lambda s, of: make.create_rays_pinhole(of, np.eye(4), 4, 3)),
    ("extrinsic_matrix", "(3 or 4, 4)", "float64", lambda s, of: make.create_rays_pinhole(K, of, 4, 3)),
    ("eye", "(3,)", "float64", lambda s, of: make.create_rays_pinhole(60, [0, 0, 0], of, [0, 1, 0], 4, 3)),
    ("elevations_deg", "(N,)", "float64", lambda s, of: make.create_rays_lidar(of, 4)),
    ("columns", "(N,)", "float64", lambda s, of: make.create_rays_lidar([0], of)),
    ("world_from_sensor", "(3 or 4, 4)", "float64", lambda s, of: make.create_rays_lidar([0], 4, of)),
    ("velocity", "(3,)", "float64", lambda s, of: make.create_rays_lidar([0], 4, velocity=of)),
    ("intrinsics", "(3, 3)", "float64", lambda s, of: umbrage.Camera.from_intrinsics(of, width=4, height=3)),
    ("extrinsics", "(3 or 4, 4)", "float64", lambda s, of: umbrage.Camera.from_intrinsics(K, of, width=4, height=3)),
    ("position", "(3,)", "float64", lambda s, of: umbrage.Camera(of, [0, 0, 1])),
    ("direction", "(3,)", "float64", lambda s, of: umbrage.Light.sun(of)),
    ("directions", "(L, 3)", "float64", lambda s, of: umbrage.Light.suns(of)),
    ("origin", "(3,)", "float64", lambda s, of: umbrage.RaycastingScene(origin=of)),
]

BAD = {
    "shape": (np.zeros((5, 7, 5), np.int16), ValueError, "shape (5, 7, 5) int16"),
    "words": (["a", "b"], TypeError, "shape (2,) <U1"),
    "objects": ([None, None], TypeError, "shape (2,) object"),
    "ragged": ([[0, 0, 0], [0]], TypeError, "list: "),
}


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("argument", ARGUMENTS, ids=[f"{of[0]}-{number}" for number, of in enumerate(ARGUMENTS)])
def test_errors_name_argument_shape_and_dtype(argument, bad):
    (name, shape, dtype, call), (value, error, found) = argument, BAD[bad]
    with pytest.raises(error) as caught:
        call(scene_of(*TRIANGLE), value)
    message = str(caught.value)
    assert message.startswith(f"{name}: expected shape {shape} {dtype}, found {found}"), message


@pytest.mark.parametrize("argument", [of for of in ARGUMENTS if of[2] == "uint32"], ids=lambda of: of[0])
def test_fractions_are_no_integers(argument):
    name, shape, dtype, call = argument
    with pytest.raises(TypeError) as caught:
        call(scene_of(*TRIANGLE), np.full((4, 3), 0.5))
    assert str(caught.value) == f"{name}: expected shape {shape} {dtype}, found shape (4, 3) float64"


def test_origins_in_more_dimensions_than_two_are_refused():
    with pytest.raises(ValueError, match=r"^origin: expected shape \(3,\) or \(S, 3\) float64, found shape \(1, 1, 3\) int64$"):
        scene_of(*TRIANGLE).scan([[[0, 0, 0]]], POINTS)
    with pytest.raises(ValueError, match=r"^directions: expected shape \(2, \.\.\., 3\) float32, found shape \(4, 3\) float32$"):
        scene_of(*TRIANGLE).scan([[0, 0, 0]] * 2, POINTS, each=True)


@pytest.mark.parametrize(
    ("method", "name", "wanted"),
    [
        ("intersects_id", "ray_origins", "(m, 3)"),
        ("intersects_first", "ray_directions", "(4, 3)"),
        ("intersects_any", "ray_origins", "(m, 3)"),
        ("contains_points", "points", "(n, 3)"),
        ("on_surface", "points", "(n, 3)"),
        ("signed_distance", "points", "(n, 3)"),
    ],
)
@pytest.mark.parametrize("bad", BAD)
def test_errors_about_trimesh_name_argument_shape_and_dtype(method, name, wanted, bad):
    class Mesh:
        vertices, faces = (np.array(of) for of in TRIANGLE)

    classes = umbrage.trimesh.RayMeshIntersector, umbrage.trimesh.ProximityQuery
    (of,) = [made for made in classes if hasattr(made, method)]
    value, error, found = BAD[bad]
    arguments = {"ray_origins": [value, POINTS], "ray_directions": [POINTS, value], "points": [value]}[name]
    with pytest.raises(error) as caught:
        getattr(of(Mesh()), method)(*arguments)
    message = str(caught.value)
    assert message.startswith(f"{name}: expected shape {wanted} float64, found {found}"), message
