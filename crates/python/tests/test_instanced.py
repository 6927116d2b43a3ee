"""Instances, and triangles that move while rays are sent: answers are those of a scene with all triangles where they are."""

import numpy as np
import pytest
import umbrage

RNG = np.random.default_rng(62)


def ball(count=300):
    """Triangles all around."""
    middles = RNG.normal(size=(count, 1, 3))
    middles /= np.linalg.norm(middles, axis=2, keepdims=True)
    vertices = np.float32(middles + RNG.normal(scale=0.15, size=(count, 3, 3))).reshape(-1, 3)
    return vertices, np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)


def transforms(count):
    """Turned, stretched, mirrored, and moved; the last one is flat."""
    matrices = np.tile(np.eye(4), (count, 1, 1))
    matrices[:, :3, :3] = RNG.normal(size=(count, 3, 3))
    matrices[:, :3, 3] = RNG.normal(scale=4, size=(count, 3))
    matrices[-1, :3, 1] = 0
    return matrices


def rays(count=2000):
    origins = RNG.normal(scale=6, size=(count, 3))
    return np.float32(np.concatenate([origins, RNG.normal(size=(count, 3)) - origins], axis=1))


def equal(one, other):
    assert one.keys() == other.keys()
    for key in one:
        assert np.array_equal(one[key], other[key], equal_nan=True), key


def test_instances_are_hit_as_their_flattened_triangles_are():
    meshes, instanced = [ball(), ball(40)], umbrage.InstancedScene()
    for mesh in meshes:
        instanced.add_mesh(*mesh)
    for count in (1, 20, 7):
        matrices, ids = transforms(count), RNG.integers(0, 2, count)
        instanced.set_instances(ids, matrices)
        flattened = umbrage.RaycastingScene()
        for matrix, mesh in zip(matrices, ids):
            flattened.set_transform(flattened.add_triangles(*meshes[mesh]), matrix)
        some = rays()
        hits = flattened.cast_rays(some)
        equal(instanced.cast_rays(some), hits)
        equal(instanced.cast_rays(some, nthreads=2, keys=["t_hit"]), {"t_hit": hits["t_hit"]})
        directions = some[:, 3:]
        equal(instanced.scan([1, 2, 3], directions, t_max=1.5), flattened.scan([1, 2, 3], directions, t_max=1.5))
        lights = [umbrage.Light.sun([0.3, -1, 0.2]), umbrage.Light.point([3, 4, 5])]
        assert np.array_equal(instanced.lit(lights, faces=True), flattened.lit(lights, faces=True))
        hit = np.isfinite(hits["t_hit"])
        on = {
            "points": (some[:, :3] + some[:, 3:] * hits["t_hit"][:, None])[hit],
            "geometry_ids": hits["geometry_ids"][hit],
            "primitive_ids": hits["primitive_ids"][hit],
        }
        assert hit.any()
        assert np.array_equal(instanced.lit(lights, **on), flattened.lit(lights, **on))


def test_changed_meshes_are_hit_where_they_are():
    vertices, triangles = ball(50)
    scene = umbrage.InstancedScene()
    mesh = scene.add_mesh(vertices, triangles)
    scene.set_instances(mesh, np.eye(4)[None])
    some = rays()
    for step in range(3):
        moved = vertices * np.float32(1 + step)
        scene.update_mesh(mesh, moved)
        alone = umbrage.RaycastingScene()
        alone.add_triangles(moved, triangles)
        equal(scene.cast_rays(some), alone.cast_rays(some))
    scene.set_instances(mesh, np.zeros((0, 4, 4)))
    assert not np.isfinite(scene.cast_rays(some)["t_hit"]).any()


def test_masks_hide_instances():
    vertices, triangles = ball()
    scene, alone = umbrage.InstancedScene(), umbrage.RaycastingScene()
    mesh, matrices = scene.add_mesh(vertices, triangles), transforms(8)
    masks = np.uint32([1, 2, 3, 4] * 2)
    scene.set_instances(mesh, matrices, mask=masks)
    for matrix, mask in zip(matrices, masks):
        alone.set_transform(alone.add_triangles(vertices, triangles, mask=int(mask)), matrix)
    some, of_rays = rays(), RNG.integers(0, 8, 2000)
    equal(scene.cast_rays(some, mask=of_rays), alone.cast_rays(some, mask=of_rays))
    equal(scene.scan([0, 0, 0], some[:, :3], mask=2), alone.scan([0, 0, 0], some[:, :3], mask=2))
    lights = [umbrage.Light.point([0, 9, 0])] * 2
    assert np.array_equal(scene.lit(lights, faces=True, mask=[1, 6]), alone.lit(lights, faces=True, mask=[1, 6]))
    scene.set_instances(mesh, matrices, mask=4)
    assert not np.isfinite(scene.cast_rays(some, mask=3)["t_hit"]).any()


def test_bad_instances_are_refused():
    scene = umbrage.InstancedScene()
    mesh = scene.add_mesh(*ball(5))
    for error, ids, places in [
        (IndexError, mesh + 1, np.eye(4)[None]),
        (ValueError, mesh, np.eye(4)),
        (ValueError, [mesh, mesh], np.eye(4)[None]),
        (ValueError, mesh, np.full((1, 4, 4), np.nan)),
    ]:
        with pytest.raises(error):
            scene.set_instances(ids, places)
    with pytest.raises(IndexError, match="mesh_id: expected one of 1 meshes, found 3"):
        scene.update_mesh(3, np.zeros((15, 3)))
    with pytest.raises(ValueError, match=r"vertex_positions: expected \(15, 3\), found \(2, 3\)"):
        scene.update_mesh(mesh, np.zeros((2, 3)))
    with pytest.raises(ValueError, match="triangle_indices"):
        scene.add_mesh(np.zeros((2, 3)), [[0, 1, 2]])


def test_rays_meet_moving_triangles_at_their_own_times():
    vertices, triangles = ball()
    turned = vertices @ np.float32([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    scene = umbrage.MovingScene([vertices, turned, turned + 1], triangles, [0.5, 1.0, 3.0])
    some = rays()
    seconds = RNG.choice([0.0, 0.5, 0.625, 0.9, 1.0, 2.7, 3.0, 5.0], len(some))
    hits = scene.cast_rays(some, seconds, nthreads=2)
    assert np.isfinite(hits["t_hit"]).sum() > 200
    for moment in np.unique(seconds):
        alone = umbrage.RaycastingScene()
        alone.add_triangles(scene.pose(moment), triangles)
        at = seconds == moment
        expected = alone.cast_rays(some[at])
        expected["geometry_ids"][:] = np.where(np.isfinite(expected["t_hit"]), 0, umbrage.MovingScene.INVALID_ID)
        equal({key: of[at] for key, of in hits.items()}, expected)
    assert np.array_equal(scene.pose(0.5), vertices)
    assert np.array_equal(scene.pose(9), turned + 1)
    scene.update([vertices], [0.0])
    equal(scene.cast_rays(some, 7.0), scene.cast_rays(some, seconds))
    assert not np.isfinite(scene.cast_rays(some, np.nan)["t_hit"]).any()


def test_bad_keys_are_refused():
    vertices, triangles = ball(5)
    for positions, seconds in [(vertices, [0]), ([vertices] * 2, [0]), ([vertices] * 2, [1, 1]), ([vertices], [np.inf])]:
        with pytest.raises(ValueError):
            umbrage.MovingScene(positions, triangles, seconds)
    scene = umbrage.MovingScene([vertices], triangles, [0])
    with pytest.raises(ValueError, match=r"vertex_positions: expected shape \(K, 15, 3\), found \(1, 2, 3\)"):
        scene.update([vertices[:2]], [0])
    with pytest.raises(ValueError, match="seconds"):
        scene.cast_rays(rays(3), [0.0, 1.0])
