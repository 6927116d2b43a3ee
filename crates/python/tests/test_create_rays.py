"""Rays of pinhole cameras, as Open3D makes them, and of lidars."""

import numpy as np
import pytest
from conftest import scene_of, sphere

import umbrage

pinhole = umbrage.RaycastingScene.create_rays_pinhole
lidar = umbrage.RaycastingScene.create_rays_lidar

K = np.array([[90, 0.5, 31.3], [0, 80, 22], [0, 0, 1]])
TURNED = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
TURNED *= np.sign(np.linalg.det(TURNED))
POSE = np.vstack((np.hstack((TURNED, [[1], [2], [3]])), [0, 0, 0, 1]))
VIEW = {"fov_deg": 70, "center": [1, 2, 3], "eye": [4, -1, 0.5], "up": [0.1, 1, 0.2], "width_px": 48, "height_px": 32}


def test_pinhole_rays_are_open3ds():
    open3d = pytest.importorskip("open3d", reason="Open3D isn't installed")
    theirs = open3d.t.geometry.RaycastingScene.create_rays_pinhole
    matrices = {"intrinsic_matrix": K, "extrinsic_matrix": POSE, "width_px": 48, "height_px": 32}
    for named in (matrices, VIEW):
        ours, expected = pinhole(**named), theirs(**named).numpy()
        assert ours.dtype == expected.dtype and ours.shape == expected.shape == (32, 48, 6)
        np.testing.assert_allclose(ours, expected, rtol=1e-6, atol=1e-6)


def test_pinhole_rays_are_those_of_the_matrices():
    rays = pinhole(K, POSE, 48, 32)
    np.testing.assert_allclose(rays[..., :3] - (-TURNED.T @ POSE[:3, 3]), 0, atol=1e-6)
    for row, column in ((0, 0), (31, 0), (7, 40)):
        direction = TURNED.T @ np.linalg.inv(K) @ [column + 0.5, row + 0.5, 1]
        np.testing.assert_allclose(rays[row, column, 3:], direction, rtol=1e-6, atol=1e-6)
    # Without a skew it is also OpenCV's camera, whose pixels have whole numbers in their middles.
    straight = K - [[0, 0.5, 0.5], [0, 0, 0.5], [0, 0, 0]]
    camera = umbrage.Camera.from_intrinsics(straight, POSE, width=48, height=32)
    rays = pinhole(straight + [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]], POSE, 48, 32)
    np.testing.assert_allclose(rays, camera.rays(), atol=1e-6)


def test_a_view_is_turned_by_half_a_turn_as_open3ds():
    rays = pinhole(*VIEW.values())
    np.testing.assert_array_equal(rays, pinhole(**VIEW))
    eye, center = np.float64(VIEW["eye"]), np.float64(VIEW["center"])
    forward = (center - eye) / np.linalg.norm(center - eye)
    np.testing.assert_allclose(rays[15:17, 23:25, 3:].mean(axis=(0, 1)), forward, atol=1e-6)
    np.testing.assert_allclose(rays[..., 3:] @ forward, 1, rtol=1e-6)
    right = np.cross(forward, VIEW["up"])
    assert (rays[:, 0, 3:] @ right > 0).all() and (rays[0, :, 3:] @ VIEW["up"] < rays[31, :, 3:] @ VIEW["up"]).all()
    half = np.degrees(np.arctan(np.linalg.norm(rays[16, 0, 3:] - rays[16, 47, 3:]) / 2 * 48 / 47))
    assert half == pytest.approx(35, abs=1e-3)


def test_a_lidar_turns_counterclockwise_from_ahead():
    elevations = [-30, 0, 12.5]
    rays = lidar(elevations, 8, POSE)
    assert rays.shape == (3, 8, 6) and rays.dtype == np.float64
    for row, elevation in enumerate(np.radians(elevations)):
        for column, azimuth in enumerate(np.arange(8) * np.pi / 4):
            beam = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
            np.testing.assert_allclose(rays[row, column], np.concatenate((POSE[:3, 3], TURNED @ beam)), atol=1e-7)
    np.testing.assert_array_equal(rays[:, [2, 1]], lidar(elevations, [90, 45], POSE))
    # float32 holds the directions, so the structure for one origin takes them.
    np.testing.assert_array_equal(rays[..., 3:], np.float32(rays[..., 3:]))
    scene = scene_of(*sphere())
    scene.cast_rays(lidar(np.linspace(-20, 20, 64), 512, POSE))
    assert scene.last_structures == ["scanner"]


def test_each_column_of_a_moving_lidar_has_its_own_pose():
    velocity, turn, period, columns = np.array([3.0, -1, 0.5]), np.array([10.0, 20, -30]), 0.2, 5
    rays = lidar([5, -5], columns, POSE, period=period, velocity=velocity, angular_velocity_deg=turn)
    angle, axis = np.radians(np.linalg.norm(turn)), turn / np.linalg.norm(turn)
    across = np.cross(axis, np.eye(3)).T
    for column in range(columns):
        seconds = column * period / columns
        turned = np.eye(3) + np.sin(angle * seconds) * across + (1 - np.cos(angle * seconds)) * across @ across
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turned @ TURNED, POSE[:3, 3] + velocity * seconds
        still = lidar([5, -5], [360 * column / columns], pose)
        np.testing.assert_allclose(rays[:, column], still[:, 0], atol=2e-7)
    # Around the world's axes, counterclockwise.
    quarter = lidar([0], [0, 0], period=2, angular_velocity_deg=[0, 0, 90])
    np.testing.assert_allclose(quarter[0, 1, 3:], [0, 1, 0], atol=1e-7)
    np.testing.assert_array_equal(lidar([0], 4, POSE, velocity=velocity), lidar([0], 4, POSE))


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: pinhole(K[:2], POSE, 4, 3), ValueError, r"intrinsic_matrix: expected shape \(3, 3\) float64, found shape \(2, 3\) float64"),
        (lambda: pinhole(np.zeros((3, 3)), POSE, 4, 3), ValueError, "intrinsic_matrix: expected a matrix with an inverse"),
        (lambda: pinhole(K, np.eye(3), 4, 3), ValueError, r"extrinsic_matrix: expected shape \(3 or 4, 4\) float64, found shape \(3, 3\)"),
        (lambda: pinhole(K, POSE, 0, 3), ValueError, "width_px: expected 1 to 65536 pixels, found 0"),
        (lambda: pinhole(K, POSE, 4), TypeError, "create_rays_pinhole: expected .* found no height_px"),
        (lambda: pinhole(K, POSE, 4, 3, fov=3), TypeError, "found another fov"),
        (lambda: pinhole(K, POSE, 4, 3, width_px=3), TypeError, "found another width_px"),
        (lambda: pinhole(**{**VIEW, "fov_deg": 180}), ValueError, "fov_deg: expected degrees between 0 and 180, found 180"),
        (lambda: pinhole(**{**VIEW, "center": VIEW["eye"]}), ValueError, "center: expected another point than eye"),
        (lambda: pinhole(**{**VIEW, "up": [-3, 3, 2.5]}), ValueError, "up: expected a direction beside"),
        (lambda: lidar([[1, 2]], 4), ValueError, r"elevations_deg: expected shape \(N,\) float64, found shape \(1, 2\) int64"),
        (lambda: lidar([np.nan], 4), ValueError, "elevations_deg: expected finite degrees, found NaN"),
        (lambda: lidar([1], 0), ValueError, "columns: expected 1 to 65536 columns, found 0"),
        (lambda: lidar([1], "all"), TypeError, r"columns: expected shape \(N,\) float64"),
        (lambda: lidar([1], 4, period=-1), ValueError, "period: expected seconds from 0, found -1"),
        (lambda: lidar([1], 4, velocity=[1, np.inf, 0]), ValueError, "velocity: expected finite numbers"),
        (lambda: lidar([1], 4, np.eye(2)), ValueError, r"world_from_sensor: expected shape \(3 or 4, 4\)"),
    ],
)
def test_errors_say_what_was_expected_and_found(call, error, words):
    with pytest.raises(error, match=words):
        call()
