"""Scenes far from the origin of their coordinates."""

import copy
import json
import pickle

import numpy as np
import pytest
from conftest import gltf_of_two_balls, soup, sphere

import umbrage

AWAY = np.array([500_000.0, 4_649_776.0, -64.0])
CORNERS = np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.25, 0.5, 0]])

AGAIN = {"copy": copy.copy, "deepcopy": copy.deepcopy, "pickle": lambda of: pickle.loads(pickle.dumps(of))}


def opened(folder, away):
    path = folder / "shape.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in (CORNERS + away).tolist()]
    path.write_text("\n".join([*lines, "f 1 2 3", ""]))
    return umbrage.open(path)


def opened_balls(folder, away):
    """Two balls, a camera before them and a bulb above them, all of a node that is far away."""
    file = json.loads(gltf_of_two_balls())
    file["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    file["extensionsUsed"] = ["KHR_lights_punctual"]
    file["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 100}]}}
    bulb = {"translation": [2.5, 5, 1.25], "extensions": {"KHR_lights_punctual": {"light": 0}}}
    file["nodes"] += [{"translation": [2.5, 0.5, 9.25], "camera": 0}, bulb, {"translation": away.tolist(), "children": [0, 1, 2, 3]}]
    file["scenes"] = [{"nodes": [4]}]
    path = folder / "balls.gltf"
    path.write_text(json.dumps(file))
    return umbrage.open(path)


def pinhole(position, fy=30.0, turn=None):
    """A camera off centre that looks along -z."""
    turn = np.diag([1.0, -1, -1]) if turn is None else turn
    K = [[30, 0, 14.5], [0, fy, 13], [0, 0, 1]]
    return umbrage.Camera.from_intrinsics(K, np.column_stack((turn, -turn @ position)), width=32, height=24)


def same_hits(some, others):
    for key in some:
        np.testing.assert_array_equal(some[key], others[key], key)


def test_cameras_and_lights_are_in_the_world(tmp_path):
    def picture(away):
        scene = opened(tmp_path, away)
        camera = umbrage.Camera(away + [0.25, 0.125, 2], away)
        np.testing.assert_array_equal(camera.position, away + [0.25, 0.125, 2])
        lights = [umbrage.Light.point(away + [0, 1, 3]), umbrage.Light.spot(away + [1, 1, 2], away, 60)]
        pictures = [scene.render(0, 32, 24, camera=camera, lights=lights)]
        x, y, z = away.tolist()
        words = {"camera": f"{x},{y},{z + 2}:{x},{y},{z}", "lights": [f"point:{x},{y + 1},{z + 3}"]}
        return np.array([*pictures, scene.render(0, 32, 24, **words)])

    assert opened(tmp_path, 0 * AWAY).origin == [0, 0, 0]
    np.testing.assert_array_equal(opened(tmp_path, AWAY).origin, AWAY)
    np.testing.assert_array_equal(picture(AWAY), picture(0 * AWAY))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_questions_are_asked_in_the_world(tmp_path, dtype):
    def answers(away):
        file = opened(tmp_path, away)
        scene = umbrage.RaycastingScene(origin=file.origin)
        for part in file.instances(0):
            scene.set_transform(scene.add_triangles(part.vertices, part.triangles), part.world_from_object)
        starts = away + [[0.0625, 0, 2], [3, 3, 2]]
        rays = np.hstack((starts, [[0, 0, -1]] * 2)).astype(dtype if not away.any() else np.float64)
        yield scene.cast_rays(rays)["t_hit"]
        yield scene.test_occlusions(rays)
        yield scene.count_intersections(rays)
        yield scene.list_intersections(rays)["t_hit"]
        yield scene.scan(starts, [[0, 0, -1], [0, 0.125, -1]])["t_hit"]
        yield scene.scan_any(starts, [[0, 0, -1], [0, 0.125, -1]])
        yield scene.see(umbrage.Camera(away + [0.25, 0.125, 2], away), 20, 16)["t_hit"]
        yield scene.lit(umbrage.Light.point(away + [0, 0, 1]), points=away + [[0, 0, -1], [3, 0, -1], [0, 0, 0.5]])
        yield umbrage.Camera(away + [0.25, 0.125, 2], away).rays(4, 3)[..., :3] - away

    for far, near in zip(answers(AWAY), answers(0 * AWAY)):
        np.testing.assert_allclose(far, near)


def test_meshes_are_put_where_they_are_in_the_world(tmp_path):
    file = opened(tmp_path, AWAY)
    frame, (part,) = file.at(0), file.instances(0)
    assert frame.origin == file.origin and pickle.loads(pickle.dumps(frame)).origin == file.origin
    np.testing.assert_array_equal(frame.vertices, CORNERS)
    # A unit beside the file's, and where float32 still has the whole of it.
    for origin in (file.origin, AWAY + [1, 0, 0], AWAY - [4096, 0, 1024]):
        scene = umbrage.RaycastingScene(origin=origin)
        ids = [scene.add_triangles(mesh) for mesh in (frame, part)]
        ids.append(scene.add_triangles(CORNERS + AWAY - origin, [[0, 1, 2]]))
        listed = scene.list_intersections([[*(AWAY + [0.0625, 0, 2]), 0, 0, -1]])
        np.testing.assert_array_equal(listed["geometry_ids"], ids)
        np.testing.assert_array_equal(listed["t_hit"], [2, 2, 2])


@pytest.mark.parametrize("fy", [30.0, 24.0], ids=["square", "wide"])
def test_cameras_of_computer_vision_see_far_scenes(random, fy):
    vertices, triangles = soup(random, 60)

    def seen(away, turn=None):
        scene = umbrage.RaycastingScene(origin=away)
        scene.add_triangles(vertices, triangles)
        position = away + [0.25, 0.125, 3]
        if turn is not None:
            position = away - 3 * turn[2]
        camera = pinhole(position, fy, turn)
        np.testing.assert_allclose(camera.position, position, rtol=0, atol=1e-8)
        again = umbrage.Camera.from_intrinsics(camera.intrinsics(), camera.extrinsics, width=32, height=24)
        np.testing.assert_allclose(again.position, position, rtol=0, atol=1e-7)
        rays = camera.rays()
        yield scene.see(camera), scene.cast_rays(rays), rays - [*away, 0, 0, 0]

    ((see, cast, rays),) = seen(0 * AWAY)
    ((far_see, far_cast, far_rays),) = seen(AWAY)
    assert 0.1 < np.isfinite(see["t_hit"]).mean() < 0.9
    for hits in (cast, far_see, far_cast):
        same_hits(hits, see)
    np.testing.assert_array_equal(far_rays, rays)
    # Turned anyhow, positions are others by what f64 rounds.
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    ((see, _, rays),) = seen(0 * AWAY, turn)
    ((far_see, _, far_rays),) = seen(AWAY, turn)
    both = np.isfinite(see["t_hit"]) & np.isfinite(far_see["t_hit"]) & (see["primitive_ids"] == far_see["primitive_ids"])
    assert (both == np.isfinite(see["t_hit"])).mean() > 0.99 and both.any()
    np.testing.assert_allclose(far_see["t_hit"][both], see["t_hit"][both], rtol=1e-4)
    np.testing.assert_allclose(far_rays, rays, atol=1e-6)


def test_cameras_of_computer_vision_make_pictures_of_far_scenes(tmp_path):
    def pictures(away):
        file, camera = opened(tmp_path, away), pinhole(away + [0.25, 0.125, 2])
        scene = umbrage.RaycastingScene(origin=file.origin)
        scene.add_triangles(file.at(0))
        light = umbrage.Light.point(away + [0, 1, 3])
        return [of.render(camera=camera, lights=light, background="none") for of in (file, scene)]

    for far, near in zip(pictures(AWAY), pictures(0 * AWAY)):
        assert near.shape == (24, 32, 4) and 0 < (near[..., 3] == 255).mean() < 1
        np.testing.assert_array_equal(far, near)


@pytest.mark.parametrize("again", AGAIN.values(), ids=AGAIN)
def test_copies_and_pickles_are_as_far_away(again, random):
    vertices, triangles = soup(random, 60)
    scene = umbrage.RaycastingScene(origin=AWAY)
    scene.add_triangles(vertices, triangles)
    matrix = np.eye(4)
    matrix[:3, 3] = AWAY + [0, 0.5, 0]
    scene.set_transform(scene.add_triangles(vertices, triangles), matrix)
    # A third of a unit is between two numbers of float32 there, and next to one of float64.
    start = AWAY + [1 / 3, 2 / 3, 3]
    cameras = [umbrage.Camera(start, AWAY), umbrage.Camera(start, AWAY, half_height=1.5), pinhole(start)]
    lights = [umbrage.Light.point(start), umbrage.Light.spot(start, AWAY, 30), umbrage.Light.sun([0, -1, -1])]
    other, others = again(scene), again(cameras)
    same_lights = again(lights)
    assert "origin=[500000.0, 4649776.0, -64.0]" in repr(scene) and repr(other) == repr(scene)
    for camera, same in zip(cameras, others):
        np.testing.assert_array_equal(same.position, start)
        np.testing.assert_array_equal(same.extrinsics, camera.extrinsics)
        assert repr(same) == repr(camera) and f"{start.tolist()}" in repr(camera)
        same_hits(other.see(same, 32, 24), scene.see(camera, 32, 24))
    x, y, z = start.tolist()
    assert list(map(repr, same_lights)) == list(map(repr, lights))
    assert repr(lights[0]) == f"Light(point:{x},{y},{z:g})" and f"spot:{x},{y},{z:g}:" in repr(lights[1])
    lit = scene.lit(lights, faces=True)
    assert 0.05 < lit.mean() < 0.95
    np.testing.assert_array_equal(other.lit(same_lights, faces=True), lit)


def test_cameras_and_lights_of_far_files_are_in_the_world(tmp_path):
    def pictures(away):
        file = opened_balls(tmp_path, away)
        assert (np.array(file.origin) != 0).any() == away.any()
        frame = pickle.loads(pickle.dumps(file.at(0.5)))
        ((_, camera),), (light,) = frame.cameras, frame.lights
        np.testing.assert_allclose(camera.position - away, [2.5, 0.5, 9.25], atol=1e-5)
        x, y, z = (away + [2.5, 5, 1.25]).tolist()
        assert repr(light) == f"Light(point:{x:.9g},{y:.9g},{z:.9g})"
        scene = umbrage.RaycastingScene(origin=file.origin)
        for part in file.instances(0.5):
            scene.add_triangles(part)
        yield file.render(0.5, 48, 32)
        yield file.render(0.5, 48, 32, camera=camera)
        yield np.isfinite(scene.see(camera, 48, 32)["t_hit"])
        yield scene.lit(light, faces=True, facing=True)

    for far, near in zip(pictures(AWAY), pictures(0 * AWAY)):
        # The origin is another middle than (0, 0, 0): float32 rounds vertices otherwise.
        assert near.any() and (far != near).mean() < 0.02


def test_sides_and_angles_are_those_of_near_scenes(random):
    vertices, triangles = sphere()
    vertices = np.round(1024 * vertices) / 1024
    points = vertices[triangles].mean(axis=1)
    on = {"geometry_ids": np.full(len(points), 2, np.uint32), "primitive_ids": np.arange(len(points), dtype=np.uint32)}

    def answers(away):
        scene = umbrage.RaycastingScene(origin=away)
        for shift in ([0, 3, 0], [0, -3, 0], [0, 0, 0]):
            scene.add_triangles(np.float32(vertices + shift), triangles)
        # Above the first ball, which is taken out.
        x, y, z = (away + [0.25, 5, 0.5]).tolist()
        lights = [umbrage.Light.point([x, y, z]), umbrage.Light.spot([x, y, z], away, 90), f"point:{x},{y},{z}", "sun:0,-1,0.25"]
        yield scene.lit(lights, faces=True, facing=True)
        scene.remove(0)
        with pytest.raises(IndexError, match="removed"):
            scene.remove(0)
        yield scene.lit(lights, faces=True, facing=True)
        yield scene.incidence(lights, faces=True)
        yield scene.lit(lights, points=away + points, facing=True, **on)
        yield scene.incidence(lights, points=away + points, **on)
        yield scene.lit_areas(lights, samples=16)["share"]
        yield scene.object_positions(*on.values(), np.full((len(points), 2), 0.25, np.float32))
        assert scene.add_triangles(vertices, triangles) == 3
        yield scene.cast_rays(np.float64([[*(away + [0.1, 9, 0.2]), 0, -1, 0]]))["t_hit"]

    far, near = list(answers(AWAY)), list(answers(0 * AWAY))
    for some, others in zip(far, near):
        np.testing.assert_allclose(some, others, atol=1e-6)
    in_shade, facing, incidence, *_ = near
    assert in_shade[:, -168:].sum() < facing[:, -168:].sum()
    assert facing.any() and (incidence < 0).any() and (incidence > 0).any()


def test_meshes_of_trimesh_may_be_far_away(random):
    trimesh = pytest.importorskip("trimesh")
    from umbrage.trimesh import RayMeshIntersector

    def answers(away):
        # A quarter of a unit from edge to edge, which float32 doesn't have there.
        mesh = trimesh.Trimesh(np.round(1024 * box.vertices) / 1024 + away, box.faces, process=False)
        ray = RayMeshIntersector(mesh)
        for unique in (False, True):
            yield from ray.intersects_id(starts + away, directions, unique=unique)
        yield from ray.intersects_id(starts + away, directions, multiple_hits=False)
        locations, index_ray, index_tri = ray.intersects_location(starts + away, directions)
        yield from (locations - away, index_ray, index_tri)
        yield ray.contains_points(points + away)

    box = trimesh.creation.icosphere(2, radius=0.25)
    # The first ray passes a corner, with several triangles.
    corner = np.round(1024 * box.vertices[5]) / 1024
    starts = np.vstack((corner + [0, 0, 2], np.round(1024 * random.uniform(-1, 1, (50, 3))) / 1024))
    directions = np.vstack(([0, 0, -1], np.round(64 * (random.uniform(-0.25, 0.25, (50, 3)) - starts[1:]))))
    points = np.round(1024 * random.uniform(-0.3, 0.3, (200, 3))) / 1024
    near, far = list(answers(0 * AWAY)), list(answers(AWAY))
    for some, others in zip(far, near):
        np.testing.assert_allclose(some, others, atol=1e-8)
    assert len(near[0]) > len(near[2]) > 10, "a corner is hit once where each crossing counts once"
    assert 0.1 < near[-1].mean() < 0.9
