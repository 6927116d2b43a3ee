"""Rays: the same answers as brute force, and the facts that no rounding may break."""

import numpy as np
import pytest
from conftest import oracle, scene_of, soup, sphere

import umbrage

INVALID = umbrage.RaycastingScene.INVALID_ID


def rays_around(random, count, dtype=np.float32):
    origins = random.uniform(-2, 2, (count, 3)).astype(dtype)
    directions = random.normal(size=(count, 3)).astype(dtype)
    return np.hstack((origins, directions))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("mesh", ["sphere", "soup"])
def test_rays_hit_what_brute_force_says(random, mesh, dtype):
    vertices, triangles = sphere() if mesh == "sphere" else soup(random, 200)
    rays = rays_around(random, 2000, dtype)
    answer = scene_of(vertices, triangles).cast_rays(rays)
    t, triangle, margin = oracle(vertices, triangles, rays[:, :3], rays[:, 3:])
    clear = margin > 1e-9
    assert clear.mean() > 0.99 and 0.1 < np.isfinite(t).mean() < 0.9
    assert answer["t_hit"].dtype == dtype
    np.testing.assert_array_equal(answer["primitive_ids"][clear], triangle[clear])
    np.testing.assert_allclose(answer["t_hit"][clear], t[clear], rtol=1e-6 if dtype == np.float32 else 1e-12)


def test_weights_and_normals_are_of_the_hit(random):
    vertices, triangles = sphere()
    rays = rays_around(random, 1000, np.float64)
    answer = scene_of(vertices, triangles).cast_rays(rays)
    hit = np.isfinite(answer["t_hit"])
    points = rays[hit, :3] + answer["t_hit"][hit, None] * rays[hit, 3:]
    corners = vertices.astype(np.float64)[triangles[answer["primitive_ids"][hit]]]
    u, v = answer["primitive_uvs"][hit].T[:, :, None]
    np.testing.assert_allclose(corners[:, 0] * (1 - u - v) + corners[:, 1] * u + corners[:, 2] * v, points, atol=1e-6)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    np.testing.assert_allclose(answer["primitive_normals"][hit], normals, atol=1e-6)
    assert (np.einsum("ij,ij->i", normals, corners.mean(axis=1)) > 0).all(), "they point outwards"
    for key in ("primitive_uvs", "primitive_normals"):
        assert (answer[key][~hit] == 0).all()
    for key in ("geometry_ids", "primitive_ids"):
        assert (answer[key][~hit] == INVALID).all()


def test_only_the_keys_that_are_named_are_found(random):
    vertices, triangles = sphere()
    scene = scene_of(vertices, triangles)
    camera = umbrage.Camera([0, 0.2, 3], [0.2, 0, 0])
    rays = rays_around(random, 1000)
    for ask in (
        lambda **named: scene.cast_rays(rays, **named),
        lambda **named: scene.scan([0.1, 0.2, 2], rays[:, 3:], **named),
        lambda **named: scene.scan([0.1, 0.2, 2], rays[:, 3:], returns=2, **named),
        lambda **named: scene.see(camera, 60, 40, **named),
    ):
        whole = ask()
        assert list(whole) == ["t_hit", "geometry_ids", "primitive_ids", "primitive_uvs", "primitive_normals"]
        assert (whole["primitive_ids"] != INVALID).any() and (whole["primitive_ids"] == INVALID).any()
        for names in (*([name] for name in whole), ("primitive_ids", "geometry_ids"), ["primitive_uvs", "t_hit"], []):
            part = ask(keys=names)
            assert set(part) == set(names)
            for name in names:
                np.testing.assert_array_equal(part[name], whole[name])
                assert part[name].dtype == whole[name].dtype
        with pytest.raises(ValueError, match="keys: expected some of t_hit, .*, found distance"):
            ask(keys=["t_hit", "distance"])


def test_no_ray_from_inside_slips_through_seams_and_corners():
    vertices, triangles = sphere(16, 24)
    scene = scene_of(vertices, triangles)
    corners = vertices.astype(np.float64)[triangles]
    middles = [(corners[:, i] + corners[:, (i + 1) % 3]) / 2 for i in range(3)]
    targets = np.concatenate((vertices.astype(np.float64), *middles, np.eye(3), -np.eye(3)))
    for origin in ([0, 0, 0], [0.3, 0.1, -0.2], vertices[40] * 0.999):
        directions = targets - np.asarray(origin, np.float64)
        rays = np.hstack((np.broadcast_to(np.asarray(origin, np.float64), directions.shape), directions))
        assert np.isfinite(scene.cast_rays(rays)["t_hit"]).all()
        assert scene.test_occlusions(rays).all()
        assert (scene.count_intersections(rays) >= 1).all()
        scanned = scene.scan(origin, directions.astype(np.float32))
        assert np.isfinite(scanned["t_hit"]).all()


def test_origins_a_million_away_lose_nothing():
    vertices, triangles = sphere()
    scene = scene_of(vertices, triangles)
    for axis in range(3):
        origin, direction = np.zeros(3), np.zeros(3)
        origin[axis], direction[axis] = 1e6, -1
        # Exactly along an axis, through a corner of the mesh or the middle of a ring.
        answer = scene.scan(origin, direction.astype(np.float32))
        expected, _, _ = oracle(vertices, triangles, origin[None], direction[None])
        assert abs(answer["t_hit"] - 1e6) < 1.1
        assert scene.cast_rays(np.concatenate((origin, direction)))["t_hit"] == answer["t_hit"]
        assert answer["t_hit"] == pytest.approx(expected[0], rel=1e-12)


@pytest.mark.parametrize("bad", [0, np.nan, np.inf])
def test_directions_that_go_nowhere_hit_nothing(bad):
    scene = scene_of(*sphere())
    direction = np.float32([bad, 0, 0])
    rays = np.concatenate((np.float32([0, 0, 0]), direction))[None]
    assert np.isinf(scene.cast_rays(rays)["t_hit"]).all()
    assert not scene.test_occlusions(rays).any()
    assert (scene.count_intersections(rays) == 0).all()
    assert np.isinf(scene.scan([0, 0, 0], [direction])["t_hit"]).all()
    assert not scene.scan_any([0, 0, 0], [direction]).any()
    assert np.isinf(scene.scan([np.nan, 0, 0], [[1, 0, 0]])["t_hit"]).all()


def test_intervals_are_open():
    scene = scene_of([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    ray = [[0.2, 0.2, 1, 0, 0, -1]]
    for near, far, hit in [(0, 1, False), (0, 1.001, True), (1, 2, False), (0.999, 2, True)]:
        assert scene.test_occlusions(ray, near, far)[0] == hit
        assert scene.scan_any([0.2, 0.2, 1], [[0, 0, -1]], t_min=near, t_max=far)[0] == hit
    assert not scene.test_occlusions([[0.2, 0.2, 0, 0, 0, -1]])[0], "what is at the origin isn't hit"


def test_equal_distances_go_to_the_lowest_triangle():
    quad = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    for triangles in ([[0, 1, 2], [0, 2, 3]], [[0, 2, 3], [0, 1, 2]]):
        answer = scene_of(quad, triangles).cast_rays([[0.5, 0.5, 1, 0, 0, -1]])
        assert answer["primitive_ids"][0] == 0


def test_all_hits_are_listed_in_order(random):
    vertices, triangles = soup(random, 150)
    rays = rays_around(random, 500, np.float64)
    scene = scene_of(vertices, triangles)
    listed = scene.list_intersections(rays)
    splits = listed["ray_splits"]
    assert splits[0] == 0 and splits[-1] == len(listed["t_hit"]) and len(splits) == len(rays) + 1
    np.testing.assert_array_equal(np.diff(splits), scene.count_intersections(rays))
    np.testing.assert_array_equal(listed["ray_ids"], np.repeat(np.arange(len(rays)), np.diff(splits)))
    # One triangle at a time, each ray has at most one hit.
    alone = np.array([scene_of(vertices, triangles[i : i + 1]).cast_rays(rays)["t_hit"] for i in range(len(triangles))])
    for ray, (start, end) in enumerate(zip(splits[:-1], splits[1:])):
        hit = np.flatnonzero(np.isfinite(alone[:, ray]))
        expected = hit[np.lexsort((hit, alone[hit, ray]))]
        np.testing.assert_array_equal(listed["primitive_ids"][start:end], expected)
        np.testing.assert_array_equal(listed["t_hit"][start:end], alone[expected, ray])


def test_the_same_rays_have_the_same_hits_whoever_is_asked(random):
    """Rays, scans and cameras share the predicate, so their answers are the same to the last bit."""
    scene = scene_of(*soup(random, 400))
    camera = umbrage.Camera([0.3, 0.2, 3.1], [0, 0, 0])
    seen, cast = scene.see(camera, 80, 60), scene.cast_rays(camera.rays(80, 60))
    assert np.isfinite(seen["t_hit"]).sum() > 500
    directions = random.normal(size=(5, 100, 3)).astype(np.float32)
    origin = np.float64([0.1, -0.2, 0.05])
    scanned = scene.scan(origin, directions)
    rays = np.concatenate((np.broadcast_to(origin, directions.shape), directions.astype(np.float64)), axis=-1)
    cast_too = scene.cast_rays(rays)
    assert scanned["t_hit"].shape == (5, 100)
    for one, other in ((seen, cast), (scanned, cast_too)):
        assert list(one) == ["t_hit", "geometry_ids", "primitive_ids", "primitive_uvs", "primitive_normals"]
        for key in one:
            assert one[key].shape == other[key].shape
            np.testing.assert_array_equal(one[key], other[key])
    np.testing.assert_array_equal(scene.scan_any(origin, directions), np.isfinite(scanned["t_hit"]))


def test_parallel_cameras_see_what_their_rays_hit(random):
    scene = scene_of(*soup(random, 100))
    camera = umbrage.Camera([0, 0, 5], [0, 0, 0], half_height=1.5)
    seen, cast = scene.see(camera, 40, 30), scene.cast_rays(camera.rays(40, 30))
    for key in seen:
        np.testing.assert_array_equal(seen[key], cast[key])
