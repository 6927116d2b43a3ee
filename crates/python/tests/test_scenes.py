"""Scenes of several meshes that move."""

import numpy as np
import pytest
from conftest import gltf_of_two_balls, scene_of, soup, sphere

import umbrage

INVALID = umbrage.RaycastingScene.INVALID_ID


def same(one, other):
    assert list(one) == list(other)
    for key in one:
        np.testing.assert_array_equal(one[key], other[key])


def test_ids_are_a_geometrys_and_a_number_within_it():
    vertices, triangles = sphere()
    scene = umbrage.RaycastingScene()
    assert scene.add_triangles(vertices, triangles) == 0
    assert scene.add_triangles(np.empty((0, 3)), np.empty((0, 3), int)) == 1
    assert scene.add_triangles(vertices + np.float32([0, 0, 5]), triangles) == 2
    rays = [[0.1, 0.2, 20, 0, 0, -1], [0.1, 0.2, -20, 0, 0, 1], [9, 9, 9, 0, 0, 1]]
    answer = scene.cast_rays(rays)
    assert answer["geometry_ids"].tolist() == [2, 0, INVALID]
    alone = scene_of(vertices, triangles).cast_rays(np.float32(rays) - np.float32([0, 0, 5, 0, 0, 0]))
    assert answer["primitive_ids"][0] == alone["primitive_ids"][0]
    assert [scene.triangle_slice(i) for i in range(3)] == [slice(0, 168, 1), slice(168, 168, 1), slice(168, 336, 1)]
    assert "3 geometries, 336 triangles" in repr(scene)


def test_meshes_are_added_whole(tmp_path):
    """Frames, instances where they are, tuples, and meshes with `faces` or `triangles`."""

    class Mesh:
        def __init__(self, **parts):
            vars(self).update(parts)

    path = tmp_path / "balls.gltf"
    path.write_text(gltf_of_two_balls())
    file = umbrage.open(path)
    frame, parts = file.at(0.5), file.instances(0.5)
    rays = np.float32([[0.1, 9, 0.2, 0, -1, 0], [5.1, 9, 0.2, 0, -1, 0]])
    expected = scene_of(frame.vertices, frame.triangles).cast_rays(rays)["t_hit"]
    assert np.isfinite(expected).all() and expected[0] != expected[1]
    vertices, triangles = frame.vertices, frame.triangles
    for mesh in (frame, (vertices, triangles), Mesh(vertices=vertices, faces=triangles), Mesh(vertices=vertices, triangles=triangles)):
        scene = umbrage.RaycastingScene()
        assert scene.add_triangles(mesh) == 0
        np.testing.assert_array_equal(scene.cast_rays(rays)["t_hit"], expected)
    scene = umbrage.RaycastingScene()
    assert [scene.add_triangles(part) for part in parts] == [0, 1]
    np.testing.assert_allclose(scene.cast_rays(rays)["t_hit"], expected, rtol=1e-6)
    # Its own vertices stay: another transform is in place of the instance's.
    scene.remove(0)
    scene.set_transform(1, np.eye(3, 4))
    alone = scene_of(parts[1].vertices, parts[1].triangles)
    np.testing.assert_array_equal(scene.cast_rays(rays)["t_hit"], alone.cast_rays(rays)["t_hit"])
    np.testing.assert_array_equal(scene.cast_rays(rays)["geometry_ids"], [1, INVALID])


def test_a_transform_may_lack_its_last_row(random):
    vertices, triangles = sphere()
    matrix = np.vstack((np.hstack((2 * np.eye(3), [[0.5], [-0.25], [1]])), [0, 0, 0, 1]))
    rays = np.hstack((random.uniform(-4, 4, (500, 3)), random.normal(size=(500, 3))))
    answers = []
    for transform in (matrix, matrix[:3]):
        scene = scene_of(vertices, triangles)
        scene.set_transform(0, transform)
        answers.append(scene.cast_rays(rays))
    assert 0.02 < np.isfinite(answers[0]["t_hit"]).mean() < 0.98
    same(*answers)


def test_what_is_removed_is_not_hit_and_others_keep_their_ids(random):
    vertices, triangles = sphere()
    scene, without = umbrage.RaycastingScene(), umbrage.RaycastingScene()
    nothing = (np.empty((0, 3)), np.empty((0, 3), int))
    matrix = np.hstack((np.linalg.qr(random.normal(size=(3, 3)))[0], [[0.1], [3], [0.3]]))
    for id in range(4):
        moved = vertices + np.float32([0, 0, 3 * id])
        scene.add_triangles(moved, triangles)
        without.add_triangles(*(nothing if id in (0, 2) else (moved, triangles)))
        for each in (scene, without):
            each.set_transform(id, matrix)
    rays = np.hstack((random.uniform(-9, 9, (3000, 3)), random.normal(size=(3000, 3))))
    assert set(scene.cast_rays(rays)["geometry_ids"]) == {0, 1, 2, 3, INVALID}
    scene.see(umbrage.Camera([0, 0, 30], [0, 0, 0]), 8, 8)
    for id in (2, 0):
        scene.remove(id)
    same(scene.cast_rays(rays), without.cast_rays(rays))
    same(*(each.see(umbrage.Camera([0, 9, 40], [0, 0, 9]), 40, 30) for each in (scene, without)))
    assert "2 geometries, 336 triangles" in repr(scene)
    assert scene.triangle_slice(3) == slice(168, 336, 1)
    for ask in (scene.remove, scene.triangle_slice, lambda id: scene.set_transform(id, matrix)):
        with pytest.raises(IndexError, match="geometry 0 was removed"):
            ask(0)
    assert scene.add_triangles(vertices, triangles) == 4


@pytest.mark.parametrize("question", ["cast_rays", "scan", "see", "lit"])
def test_meshes_that_moved_answer_as_new_ones(random, question):
    """Each structure is built for what the meshes are when it is asked, also if it was asked before."""
    vertices, triangles = soup(random, 300)
    turned = soup(random, 300)[0]
    camera = umbrage.Camera([0, 0, 4], [0, 0, 0])
    rays = np.hstack((random.uniform(-2, 2, (500, 3)), random.normal(size=(500, 3)))).astype(np.float32)

    def ask(scene):
        if question == "cast_rays":
            return scene.cast_rays(rays)
        if question == "scan":
            return scene.scan([0, 0, 3], rays[:, 3:])
        if question == "see":
            return scene.see(camera, 50, 40)
        return {"lit": scene.lit(umbrage.Light.sun([0, -1, 0]), faces=True)}

    scene = scene_of(vertices, triangles)
    before = ask(scene)
    scene.update_vertices(0, turned)
    same(ask(scene), ask(scene_of(turned, triangles)))
    scene.update_vertices(0, vertices)
    same(ask(scene), before)


def test_transforms_are_of_the_meshs_own_vertices(random):
    vertices, triangles = sphere()
    scene = scene_of(vertices, triangles)
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(random.normal(size=(3, 3)))[0] * 1.5
    matrix[:3, 3] = [3, -2, 1]
    rays = np.hstack((random.uniform(-4, 4, (500, 3)), random.normal(size=(500, 3))))

    def moved(by, of):
        return (of.astype(np.float64) @ by[:3, :3].T + by[:3, 3]).astype(np.float32)

    def close(one, other):
        # The transform's sums may be in another order than numpy's.
        hit = np.isfinite(one["t_hit"])
        assert 0.02 < hit.mean() < 0.98
        assert (hit != np.isfinite(other["t_hit"])).mean() < 0.01
        both = hit & np.isfinite(other["t_hit"])
        np.testing.assert_allclose(one["t_hit"][both], other["t_hit"][both], rtol=1e-4)

    scene.set_transform(0, matrix)
    close(scene.cast_rays(rays), scene_of(moved(matrix, vertices), triangles).cast_rays(rays))
    # Another transform is in its place, and moved vertices go through it.
    matrix[:3, 3] = 0
    scene.set_transform(0, matrix)
    scene.update_vertices(0, 2 * vertices)
    close(scene.cast_rays(rays), scene_of(moved(matrix, 2 * vertices), triangles).cast_rays(rays))
    scene.set_transform(0, np.eye(4))
    same(scene.cast_rays(rays), scene_of(2 * vertices, triangles).cast_rays(rays))


def test_points_are_known_in_the_space_of_their_geometry(random):
    vertices, triangles = soup(random, 200)
    scene = scene_of(vertices, triangles)
    scene.add_triangles(vertices, triangles)
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(random.normal(size=(3, 3)))[0] * 3
    matrix[:3, 3] = [9, 0, 0]
    scene.set_transform(1, matrix)
    directions = random.normal(size=(400, 3)) + [2, 0, 0]
    answer = scene.scan([-3, 0, 0], directions)
    keys = "geometry_ids", "primitive_ids", "primitive_uvs"
    found = scene.object_positions(*(answer[key] for key in keys))
    assert found.shape == (400, 3) and found.dtype == np.float64
    hit = np.isfinite(answer["t_hit"])
    assert np.isnan(found[~hit]).all() and set(answer["geometry_ids"][hit]) == {0, 1}
    world = np.float64([-3, 0, 0]) + np.float32(directions[hit]).astype(np.float64) * answer["t_hit"][hit, None]
    back = (world - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T
    expected = np.where(answer["geometry_ids"][hit, None] == 1, back, world)
    np.testing.assert_allclose(found[hit], expected, atol=1e-5)
    with pytest.raises(ValueError, match="primitive_ids: expected ids below 200"):
        scene.object_positions([0], [200], [[0, 0]])


def test_rays_say_what_answered_them_and_answers_do_not_depend_on_it(random):
    vertices, triangles = soup(random, 300)
    directions = random.normal(size=(3000, 3)).astype(np.float32)
    rays = np.hstack((np.broadcast_to(np.float32([0.1, 0.2, 3]), directions.shape), directions))
    others = np.hstack((random.uniform(-2, 2, (3000, 3)), directions)).astype(np.float32)
    both = np.stack((rays, others), axis=1).reshape(-1, 6)
    scene = scene_of(vertices, triangles)
    assert scene.last_structures == []
    together, of_together = scene.cast_rays(rays), scene.last_structures
    apart, of_apart = scene.cast_rays(both), scene.last_structures
    assert (of_together, of_apart) == (["scanner"], ["hierarchy"])
    assert 100 < np.isfinite(together["t_hit"]).sum() < 2900
    for key in together:
        np.testing.assert_array_equal(together[key], apart[key][::2])


def test_triangles_that_no_ray_can_hit_are_counted():
    vertices = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0], [0, 0, 0]])
    scene = scene_of(vertices, [[0, 1, 2], [0, 1, 3], [0, 1, 1], [0, 4, 2]])
    assert scene.omitted() == {"not_finite": 1, "zero_area": 2}
    assert (scene.cast_rays([[0.2, 0.2, 1, 0, 0, -1]])["primitive_ids"] == 0).all()


def test_a_scene_of_nothing_is_missed():
    scene = umbrage.RaycastingScene()
    assert np.isinf(scene.cast_rays([[0, 0, 0, 1, 0, 0]])["t_hit"]).all()
    assert scene.cast_rays(np.empty((0, 6)))["t_hit"].shape == (0,)
    assert np.isinf(scene.scan([0, 0, 0], [[1, 0, 0]])["t_hit"]).all()
    assert np.isinf(scene.see(umbrage.Camera([0, 0, 1], [0, 0, 0]), 4, 3)["t_hit"]).all()
    assert scene.lit(umbrage.Light.sun([0, -1, 0]), points=[[0, 0, 0]]).all()
    assert scene.lit(umbrage.Light.sun([0, -1, 0]), faces=True).shape == (1, 0)
    assert scene.render(width=8, height=6).shape == (6, 8, 3)


def test_several_origins_have_all_directions_or_their_own(random):
    scene = scene_of(*soup(random, 200))
    origins = random.uniform(-1, 1, (4, 3))
    directions = random.normal(size=(4, 30, 3)).astype(np.float32)
    shared, own = scene.scan(origins, directions[0]), scene.scan(origins, directions, each=True)
    assert shared["t_hit"].shape == own["t_hit"].shape == (4, 30)
    assert own["primitive_uvs"].shape == (4, 30, 2)
    for index, origin in enumerate(origins):
        for answer, asked in ((shared, directions[0]), (own, directions[index])):
            alone = scene.scan(origin, asked)
            for key in alone:
                np.testing.assert_array_equal(answer[key][index], alone[key])
    hit = np.isfinite(own["t_hit"])
    assert 0.1 < hit.mean() < 1
    np.testing.assert_array_equal(scene.scan_any(origins, directions, each=True), hit)


def test_returns_are_the_nearest_hits_in_order(random):
    scene = scene_of(*soup(random, 200))
    origin, directions = np.float64([0.1, 0.2, 0.3]), random.normal(size=(300, 3)).astype(np.float32)
    answer = scene.scan(origin, directions, returns=3)
    rays = np.hstack((np.broadcast_to(origin, directions.shape), directions.astype(np.float64)))
    listed = scene.list_intersections(rays)
    assert answer["t_hit"].shape == (300, 3)
    for ray, (start, end) in enumerate(zip(listed["ray_splits"][:-1], listed["ray_splits"][1:])):
        count = min(end - start, 3)
        np.testing.assert_array_equal(answer["t_hit"][ray, :count], listed["t_hit"][start : start + count])
        np.testing.assert_array_equal(answer["primitive_ids"][ray, :count], listed["primitive_ids"][start : start + count])
        assert np.isinf(answer["t_hit"][ray, count:]).all()
    assert (np.diff(listed["ray_splits"]) > 3).any()
    one = scene.scan(origin, directions)
    same(one, {key: value[:, 0] for key, value in answer.items()})


def test_only_hits_of_the_interval_count(random):
    scene = scene_of(*soup(random, 200))
    directions = random.normal(size=(300, 3)).astype(np.float32)
    everything = scene.scan([0, 0, 0], directions, returns=64)["t_hit"]
    within = np.where((everything > 0.5) & (everything < 1.5), everything, np.inf).min(axis=1)
    assert (within != everything[:, 0]).any()
    np.testing.assert_array_equal(scene.scan([0, 0, 0], directions, t_min=0.5, t_max=1.5)["t_hit"], within)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda s: s.add_triangles([[0, 0]], [[0, 0, 0]]), ValueError, r"vertex_positions: expected shape \(N, 3\) float32, found shape \(1, 2\) int64"),
        (lambda s: s.add_triangles([[0, 0, 0]], [[0, 0, 1]]), ValueError, "triangle_indices: expected indices below 1"),
        (lambda s: s.add_triangles([[0, 0, 0]], [[0, 0, -1]]), ValueError, "found -1"),
        (lambda s: s.add_triangles([[0, 0, 0]], [[0.0, 0, 0]]), TypeError, r"triangle_indices: expected shape \(M, 3\) uint32, found shape \(1, 3\) float64"),
        (lambda s: s.add_triangles([[0, 0, 0]]), ValueError, "triangle_indices"),
        (lambda s: s.add_triangles(([[0, 0, 0]],)), ValueError, "a tuple of vertices and triangles"),
        (lambda s: s.remove(1), IndexError, "geometry_id: expected one of 1 geometries, found 1"),
        (lambda s: s.set_transform(0, np.eye(5, 4)), ValueError, r"world_from_object: expected shape \(3 or 4, 4\) float64, found shape \(5, 4\) float64"),
        (lambda s: s.add_triangles("no", [[0, 0, 0]]), TypeError, r"vertex_positions: expected shape \(N, 3\) float32, found shape \(\) <U2"),
        (lambda s: s.update_vertices(7, [[0, 0, 0]]), IndexError, "geometry_id: expected one of 1 geometries, found 7"),
        (lambda s: s.update_vertices(0, [[0, 0, 0]]), ValueError, r"vertex_positions: expected shape \(3, 3\), found shape \(1, 3\)"),
        (lambda s: s.set_transform(0, np.diag([1, 1, 1, 2])), ValueError, "last row"),
        (lambda s: s.cast_rays([[0, 0, 0, 1, 0]]), ValueError, r"rays: expected shape \(..., 6\) float32, found shape \(1, 5\) int64"),
        (lambda s: s.scan([[[0, 0, 0]]], [[1, 0, 0]]), ValueError, r"origin: expected shape \(3,\) or \(S, 3\)"),
        (lambda s: s.scan([0, 0, 0], [[1, 0, 0]], each=True), ValueError, "directions: expected each=False"),
        (lambda s: s.scan([0, 0, 0], [[1, 0, 0]], returns=0), ValueError, "returns: expected 1 to 1024 hits, found 0"),
        (lambda s: s.see(umbrage.Camera([0, 0, 1], [0, 0, 0]), 0, 5), ValueError, "width: expected 1 to 16384 pixels, found 0"),
        (lambda s: s.lit([3], faces=True), TypeError, "lights: expected a Light, a str or a sequence of them, found int"),
        (lambda s: s.lit("sun:0,0", faces=True), ValueError, "three numbers"),
        (lambda s: s.lit("disk:0,3,0:0,0,0:1", faces=True), ValueError, "lights: expected lights without a size"),
        (lambda s: s.lit("sun:0,-1,0:radius=1", faces=True), ValueError, "lights: expected lights without a size"),
        (lambda s: s.lit("sun:0,-1,0:noshadow", faces=True), ValueError, "lights: expected lights with shadows"),
        (lambda s: s.lit([], points=[[0, 0, 0]], facing=True), ValueError, "facing: expected faces=True, or geometry_ids"),
        (lambda s: s.incidence([], points=[[0, 0, 0]]), ValueError, "points: expected faces=True, or geometry_ids"),
        (lambda s: s.lit([], points=[[0, 0, 0]], faces=True), ValueError, "points or faces=True"),
        (lambda s: s.lit([], points=[[0, 0, 0]], geometry_ids=[0]), ValueError, "both of them or neither"),
        (lambda s: s.lit([], points=[[0, 0, 0]], geometry_ids=[0], primitive_ids=[9]), ValueError, "primitive_ids: expected ids below 1"),
        (lambda s: s.lit_areas([], samples=0), ValueError, "samples: expected 1 to 65536"),
        (lambda s: s.cast_rays([[0, 0, 0, 1, 0, 0]], nthreads=5000), ValueError, "nthreads: expected 0 to 1024 threads"),
        (lambda s: umbrage.Camera([0, 0, 0], [0, 0, 0]), ValueError, "target: expected another point"),
        (lambda s: umbrage.Light.sun([0, 0, 0]), ValueError, "direction: expected a direction with a finite length"),
        (lambda s: umbrage.Light.spot([0, 0, 0], [0, 1, 0], 0), ValueError, "degrees"),
        (lambda s: umbrage.open("no/such/file.glb"), FileNotFoundError, "no/such/file.glb"),
        (lambda s: umbrage.open("demo:nothing"), ValueError, "nothing"),
        (lambda s: s.render(camera="nowhere", width=4, height=4), ValueError, "camera"),
    ],
)
def test_errors_say_what_was_expected_and_found(call, error, words):
    scene = scene_of([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(error, match=words):
        call(scene)
