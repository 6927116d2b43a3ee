"""Scenes far from the origin of their coordinates."""

import numpy as np
import pytest

import umbrage

AWAY = np.array([500_000.0, 4_649_776.0, -64.0])
CORNERS = np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.25, 0.5, 0]])


def opened(folder, away):
    path = folder / "shape.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in (CORNERS + away).tolist()]
    path.write_text("\n".join([*lines, "f 1 2 3", ""]))
    return umbrage.open(path)


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
        yield scene.scan(starts, [[0, 0, -1], [0, 0.125, -1]])["t_hit"]
        yield scene.see(umbrage.Camera(away + [0.25, 0.125, 2], away), 20, 16)["t_hit"]
        yield scene.lit(umbrage.Light.point(away + [0, 0, 1]), points=away + [[0, 0, -1], [3, 0, -1], [0, 0, 0.5]])
        yield umbrage.Camera(away + [0.25, 0.125, 2], away).rays(4, 3)[..., :3] - away

    for far, near in zip(answers(AWAY), answers(0 * AWAY), strict=True):
        np.testing.assert_allclose(far, near)
