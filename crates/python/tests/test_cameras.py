"""Cameras of computer vision, beside the projection that they stand for."""

import numpy as np
import pytest
from conftest import scene_of, soup, sphere

import umbrage

WIDTH, HEIGHT = 80, 60


def extrinsics(random):
    """A camera before the origin, turned anyhow around its axis and a little across it."""
    turn, _ = np.linalg.qr(np.eye(3) + 0.15 * random.normal(size=(3, 3)))
    turn *= np.sign(np.diag(turn))
    if np.linalg.det(turn) < 0:
        turn[0] *= -1
    return np.hstack((turn, [[0.1], [-0.2], [5]]))


def intrinsics(fx=90.0, fy=90.0, cx=31.25, cy=40.0):
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])


def project(K, camera_from_world, points):
    """Pixels as OpenCV counts them, from the middle of the upper left one."""
    seen = K @ (camera_from_world[:, :3] @ points.T + camera_from_world[:, 3:])
    return (seen[:2] / seen[2]).T, seen[2]


@pytest.mark.parametrize("fy", [90.0, 75.0], ids=["square", "wide"])
def test_points_are_seen_where_they_are_projected(random, fy):
    vertices, triangles = soup(random, 200)
    K, world = intrinsics(fy=fy), extrinsics(random)
    camera = umbrage.Camera.from_intrinsics(K, world, width=WIDTH, height=HEIGHT)
    assert camera.size == (WIDTH, HEIGHT)
    scene = scene_of(vertices, triangles)
    seen = scene.see(camera)
    rays = camera.rays()
    assert rays.shape == (HEIGHT, WIDTH, 6)
    hit = np.isfinite(seen["t_hit"])
    assert 0.1 < hit.mean() < 0.9
    points = (rays[..., :3] + rays[..., 3:] * np.where(hit, seen["t_hit"], 1)[..., None])[hit]
    pixels, depth = project(K, world, points)
    rows, columns = np.nonzero(hit)
    np.testing.assert_allclose(pixels, np.stack((columns, rows), axis=1), atol=1e-3)
    np.testing.assert_allclose(depth, seen["t_hit"][hit], rtol=1e-5)
    cast = scene.cast_rays(rays)
    for key in seen:
        np.testing.assert_array_equal(seen[key], cast[key])
    assert scene.last_structures != []


def test_views_far_off_centre_see_what_their_rays_hit(random):
    scene = scene_of(*soup(random, 300))
    for cx, cy in [(-60.0, 29.5), (39.5, 170.25), (140.0, -75.0)]:
        K = intrinsics(400.0, 400.0, cx, cy)
        # Turned so that the origin is in the middle of the image.
        forward = np.array([39.5 - cx, 29.5 - cy, 400.0])
        world = np.hstack((np.eye(3), 6 * (forward / np.linalg.norm(forward))[:, None]))
        camera = umbrage.Camera.from_intrinsics(K, world, width=WIDTH, height=HEIGHT)
        seen, cast = scene.see(camera), scene.cast_rays(camera.rays())
        assert 0.1 < np.isfinite(seen["t_hit"]).mean()
        for key in seen:
            np.testing.assert_array_equal(seen[key], cast[key])


def test_matrices_come_back(random):
    K, world = intrinsics(fy=75.0), extrinsics(random)
    camera = umbrage.Camera.from_intrinsics(K, world, width=WIDTH, height=HEIGHT)
    np.testing.assert_array_equal(camera.intrinsics(), K)
    np.testing.assert_allclose(camera.extrinsics, np.vstack((world, [0, 0, 0, 1])), atol=1e-6)
    np.testing.assert_allclose(camera.position, -world[:, :3].T @ world[:, 3], atol=1e-6)
    # Of a camera without an image of its own, they make the same one.
    plain = umbrage.Camera([1, 2, 3], [0, 0.5, 0], fov_degrees=50)
    again = umbrage.Camera.from_intrinsics(plain.intrinsics(WIDTH, HEIGHT), plain.extrinsics, width=WIDTH, height=HEIGHT)
    np.testing.assert_allclose(again.rays(), plain.rays(WIDTH, HEIGHT), atol=1e-6)


def test_pictures_are_of_the_part_that_the_camera_sees():
    scene = scene_of(*sphere())
    for cx, cy in [(39.5, 29.5), (20.0, 45.0), (60.5, 10.0)]:
        camera = umbrage.Camera.from_intrinsics(
            intrinsics(60.0, 60.0, cx, cy), [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 4]], width=WIDTH, height=HEIGHT
        )
        picture = scene.render(camera, lights="sun:0,-1,-1", background="none")
        assert picture.shape == (HEIGHT, WIDTH, 4)
        # The larger picture's field of view is rounded for itself: a pixel at an edge may be on its other side.
        assert ((picture[..., 3] == 255) != np.isfinite(scene.see(camera)["t_hit"])).sum() <= 2
        assert (picture[..., 3] == 255).any() and (picture[..., 3] == 0).any()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda **size: umbrage.Camera.from_intrinsics([[90, 1, 40], [0, 90, 30], [0, 0, 1]], **size), "intrinsics: expected"),
        (lambda **size: umbrage.Camera.from_intrinsics(intrinsics(fx=0), **size), "focal lengths above 0"),
        (lambda **size: umbrage.Camera.from_intrinsics(intrinsics(fy=np.nan), **size), "focal lengths above 0"),
        (lambda **size: umbrage.Camera.from_intrinsics(intrinsics(), np.diag([1, 1, -1, 1]), **size), "extrinsics: expected a rotation"),
        (lambda **size: umbrage.Camera.from_intrinsics(intrinsics(), np.diag([2, 2, 2, 1]), **size), "extrinsics: expected a rotation"),
        (lambda **size: umbrage.Camera.from_intrinsics(intrinsics(), **size).rays(80, 61), "height: expected 60, that of the camera"),
        (lambda **size: umbrage.Camera([0, 0, 1], [0, 0, 0]).rays(80), "height: expected a number of pixels"),
        (lambda **size: umbrage.Camera([0, 0, 1], [0, 0, 0], half_height=1).intrinsics(8, 6), "no focal length"),
        (lambda **size: scene_of(*sphere()).render(umbrage.Camera.from_intrinsics(intrinsics(fy=75), **size)), "expected fx = fy"),
        (lambda **size: scene_of(*sphere()).render(umbrage.Camera.from_intrinsics(intrinsics(cx=1e9), **size)), "16384 pixels"),
    ],
)
def test_errors_say_what_was_expected(call, words):
    with pytest.raises(ValueError, match=words):
        call(width=WIDTH, height=HEIGHT)
