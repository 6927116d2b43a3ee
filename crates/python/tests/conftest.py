"""Meshes and rays that tests have in common, and the truth about them."""

import numpy as np
import pytest

import umbrage


@pytest.fixture
def random():
    return np.random.default_rng(7)


def sphere(rings=8, around=12):
    """A closed mesh of a ball of radius 1, as vertices and triangles."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = np.arange(around) * (2 * np.pi / around)
    ring = np.stack(
        (
            np.outer(np.sin(theta), np.cos(phi)),
            np.broadcast_to(np.cos(theta)[:, None], (rings - 1, around)),
            np.outer(np.sin(theta), np.sin(phi)),
        ),
        axis=-1,
    )
    vertices = np.concatenate(([[0, 1, 0]], ring.reshape(-1, 3), [[0, -1, 0]])).astype(np.float32)
    triangles = []
    for a in range(around):
        b = (a + 1) % around
        triangles.append((0, 1 + b, 1 + a))
        for row in range(rings - 2):
            first, second = 1 + row * around, 1 + (row + 1) * around
            triangles += [(first + a, first + b, second + a), (first + b, second + b, second + a)]
        last = 1 + (rings - 2) * around
        triangles.append((last + a, last + b, len(vertices) - 1))
    return vertices, np.array(triangles, np.uint32)


def soup(random, triangles, size=0.4):
    """Unconnected triangles in a cube of side 2 around the origin."""
    middles = random.uniform(-1, 1, (triangles, 1, 3))
    vertices = (middles + random.uniform(-size, size, (triangles, 3, 3))).reshape(-1, 3).astype(np.float32)
    return vertices, np.arange(3 * triangles, dtype=np.uint32).reshape(-1, 3)


def oracle(vertices, triangles, origins, directions):
    """The nearest hit of each ray by brute force in float64: t, triangle, and how near to an edge or the next hit any decision was."""
    corners = vertices.astype(np.float64)[triangles]
    a, edges = corners[:, 0], (corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    t = np.full(len(origins), np.inf)
    triangle = np.full(len(origins), umbrage.RaycastingScene.INVALID_ID, np.uint32)
    margin = np.full(len(origins), np.inf)
    for index, (origin, direction) in enumerate(zip(origins.astype(np.float64), directions.astype(np.float64))):
        across = np.cross(direction, edges[1])
        determinant = np.einsum("ij,ij->i", edges[0], across)
        with np.errstate(divide="ignore", invalid="ignore"):
            offset = origin - a
            u = np.einsum("ij,ij->i", offset, across) / determinant
            turned = np.cross(offset, edges[0])
            v = turned @ direction / determinant
            at = np.einsum("ij,ij->i", edges[1], turned) / determinant
        inside = np.minimum(np.minimum(u, v), 1 - u - v)
        hit = (inside >= 0) & (at > 0)
        margin[index] = np.nanmin(np.abs(inside), initial=np.inf)
        if hit.any():
            order = np.argsort(np.where(hit, at, np.inf), kind="stable")
            t[index], triangle[index] = at[order[0]], order[0]
            if hit.sum() > 1:
                margin[index] = min(margin[index], at[order[1]] - at[order[0]])
    return t, triangle, margin


def scene_of(vertices, triangles, **keywords):
    scene = umbrage.RaycastingScene(**keywords)
    scene.add_triangles(vertices, triangles)
    return scene
