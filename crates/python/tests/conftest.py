"""Meshes and rays that tests have in common, and the truth about them."""

import base64
import json

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


def gltf_of_two_balls():
    """Two nodes with one mesh, of which the second rises by a unit a second."""
    vertices, triangles = sphere()
    parts = [vertices, triangles, np.float32([0, 1]), np.float32([[5, 0, 0], [5, 1, 0]])]
    starts = np.cumsum([0] + [part.nbytes for part in parts]).tolist()
    encoded = base64.b64encode(b"".join(part.tobytes() for part in parts)).decode()

    def accessor(view, component, kind, count, **more):
        return {"bufferView": view, "componentType": component, "type": kind, "count": count, **more}

    extent = {"min": vertices.min(0).tolist(), "max": vertices.max(0).tolist()}
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"name": "stays", "mesh": 0, "scale": [2, 1, 1]}, {"name": "rises", "mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "animations": [
                {
                    "samplers": [{"input": 2, "output": 3}],
                    "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
                }
            ],
            "accessors": [
                accessor(0, 5126, "VEC3", len(vertices), **extent),
                accessor(1, 5125, "SCALAR", triangles.size),
                accessor(2, 5126, "SCALAR", 2, min=[0], max=[1]),
                accessor(3, 5126, "VEC3", 2),
            ],
            "bufferViews": [
                {"buffer": 0, "byteOffset": start, "byteLength": part.nbytes} for start, part in zip(starts, parts)
            ],
            "buffers": [{"byteLength": starts[-1], "uri": f"data:application/octet-stream;base64,{encoded}"}],
        }
    )


def scene_of(vertices, triangles, **keywords):
    scene = umbrage.RaycastingScene(**keywords)
    scene.add_triangles(vertices, triangles)
    return scene
