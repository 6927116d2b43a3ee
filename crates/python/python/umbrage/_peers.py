"""Rays and distances beside Open3D's and trimesh's: what ``python -m umbrage.bench --peers`` prints."""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import umbrage

Array = NDArray[Any]

# Points for trimesh, which takes milliseconds for each.
FEW = 100


class Question(NamedTuple):
    """What all are asked about a mesh."""

    name: str
    count: int
    ours: Callable[[umbrage.RaycastingScene], Array]
    open3d: Callable[[Any], Array]
    # Of a mesh of trimesh; only where it doesn't take minutes.
    trimesh: Callable[[Any], Array] | None
    # Whether two answers are the same.
    same: Callable[[Array, Array], Array]


def measure(asked: argparse.Namespace) -> None:
    """Print a table: each scene as it stays and as it moves."""
    import open3d

    try:
        import trimesh
    except ImportError:
        trimesh = None
    tensor, threads = open3d.core.Tensor, asked.threads
    print(f"threads {threads}, trimesh 1; medians of {asked.rounds} answers in milliseconds\n")
    print("| scene | triangles | mesh | question | asked | Umbrage | Open3D | ratio | trimesh | ratio | differ |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for address in asked.scenes:
        animation = umbrage.open(address)
        for moves in (False, True):
            times: dict[str, list[list[float]]] = {}
            differ: dict[str, int] = {}
            counts: dict[str, int] = {}
            scene, mesh = umbrage.RaycastingScene(nthreads=threads), None
            theirs: dict[str, Any] = {}
            for number in range(asked.rounds + 1):
                frame = animation.at(animation.duration * number / (asked.rounds + 1) if moves else 0.0)
                vertices, faces = frame.vertices, frame.triangles
                if mesh is None:
                    mesh = scene.add_triangles(vertices, faces)
                for question in _questions(vertices, asked, tensor):
                    # Whatever was built for the last question isn't used again where meshes move.
                    def ask_ours(question: Question = question) -> Array:
                        if moves:
                            scene.update_vertices(mesh, vertices)
                        return question.ours(scene)

                    def ask_open3d(question: Question = question) -> Array:
                        if moves or "open3d" not in theirs:
                            theirs["open3d"] = open3d.t.geometry.RaycastingScene(nthreads=threads)
                            theirs["open3d"].add_triangles(tensor(vertices), tensor(faces))
                        return question.open3d(theirs["open3d"])

                    def ask_trimesh(question: Question = question) -> Array:
                        if moves or "trimesh" not in theirs:
                            theirs["trimesh"] = trimesh.Trimesh(vertices, faces, process=False)
                        assert question.trimesh is not None
                        return question.trimesh(theirs["trimesh"])

                    asks = [ask_ours, ask_open3d] + ([ask_trimesh] if trimesh and question.trimesh else [])
                    answers, taken = zip(*(_timed(ask) for ask in asks))
                    counts[question.name] = question.count
                    # The first one builds what stays.
                    if number > 0:
                        times.setdefault(question.name, []).append(list(taken))
                        others = np.count_nonzero(~question.same(answers[0], answers[1]))
                        differ[question.name] = differ.get(question.name, 0) + int(others)
            for name, rows in times.items():
                ours, *peers = (statistics.median(column) for column in zip(*rows))
                columns = [f"{peer:.1f} | {peer / ours:.2f}" for peer in peers] + ["– | –"] * (2 - len(peers))
                print(
                    f"| `{address}` | {len(faces):,} | {'moves' if moves else 'stays'} | {name} | {counts[name]:,} "
                    f"| {ours:.1f} | {' | '.join(columns)} | {differ[name]:,} |",
                    flush=True,
                )
    print("\nratio: how many times as long others take. differ: answers of Open3D that are others: hits, counts, or distances")
    print("(without their sign, by more than 1e-4 of the scene's size).")


def _timed(ask: Callable[[], Array]) -> tuple[Array, float]:
    start = time.perf_counter()
    answer = ask()
    return answer, 1e3 * (time.perf_counter() - start)


def _questions(vertices: Array, asked: argparse.Namespace, tensor: Any) -> Iterator[Question]:
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    random = np.random.default_rng(1)
    count = asked.any_rays
    rays = np.float32(np.concatenate([random.uniform(low, high, (count, 3)), random.normal(size=(count, 3))], axis=1))
    as_tensor, threads = tensor(rays), asked.threads

    def equal(ours: Array, theirs: Array) -> Array:
        return ours == theirs

    yield Question(
        "`cast_rays`",
        count,
        lambda scene: np.isfinite(scene.cast_rays(rays)["t_hit"]),
        lambda scene: np.isfinite(scene.cast_rays(as_tensor, nthreads=threads)["t_hit"].numpy()),
        None,
        equal,
    )
    yield Question(
        "`test_occlusions`",
        count,
        lambda scene: scene.test_occlusions(rays),
        lambda scene: scene.test_occlusions(as_tensor, nthreads=threads).numpy(),
        None,
        equal,
    )
    yield Question(
        "`count_intersections`",
        count,
        lambda scene: scene.count_intersections(rays),
        lambda scene: scene.count_intersections(as_tensor, nthreads=threads).numpy(),
        None,
        equal,
    )
    middle = (low + high) / 2
    from_middle = tensor(np.concatenate([np.broadcast_to(middle, (count, 3)), rays[:, 3:]], axis=1))
    yield Question(
        "one origin, `scan`",
        count,
        lambda scene: np.isfinite(scene.scan(middle, rays[:, 3:])["t_hit"]),
        lambda scene: np.isfinite(scene.cast_rays(from_middle, nthreads=threads)["t_hit"].numpy()),
        None,
        equal,
    )
    size = float((high - low).max())

    def near(ours: Array, theirs: Array) -> Array:
        return np.abs(np.abs(ours) - np.abs(theirs)) <= 1e-4 * size

    for number, with_trimesh in ((asked.points, False), (FEW, True)):
        points = np.float32(random.uniform(low - 0.1 * size, high + 0.1 * size, (number, 3)))
        of_points = tensor(points)
        yield Question(
            "`compute_closest_points`" + (", few" if with_trimesh else ""),
            number,
            lambda scene, points=points: np.linalg.norm(scene.compute_closest_points(points)["points"] - points, axis=1),
            lambda scene, points=points, of_points=of_points: np.linalg.norm(
                scene.compute_closest_points(of_points, nthreads=threads)["points"].numpy() - points, axis=1
            ),
            (lambda mesh, points=points: mesh.nearest.on_surface(points)[1]) if with_trimesh else None,
            near,
        )
        yield Question(
            "`compute_signed_distance`" + (", few" if with_trimesh else ""),
            number,
            lambda scene, points=points: scene.compute_signed_distance(points),
            lambda scene, of_points=of_points: scene.compute_signed_distance(of_points, nthreads=threads).numpy(),
            (lambda mesh, points=points: mesh.nearest.signed_distance(points)) if with_trimesh else None,
            near,
        )
