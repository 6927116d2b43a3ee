"""Moving meshes, asked again in every frame, beside Embree through ``embreex``.

    python -m umbrage.bench
    python -m umbrage.bench 'demo:statue?triangles=300000' walk.glb --suns 100 --threads 2
    python -m umbrage.bench --peers
    python -m umbrage.bench --overhead target/release/examples/timed_questions

Both get the frame's vertices, build what they need and answer the same rays, in turn. ``embreex`` works on one thread, and so does
Umbrage unless ``--threads`` says otherwise. With ``--peers`` rays and distances are asked beside Open3D and trimesh, of meshes that
stay and of meshes that move. With ``--overhead`` the same questions are asked in Rust and in Python, in turn, of a
scene that stays as it is; the program is an example of the library (``cargo build --release --example timed_questions``).
"""

from __future__ import annotations

import argparse
import importlib
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import umbrage

__all__ = ["main"]

SCENES = ["demo:cloth?triangles=82000", "demo:shatter?triangles=82000", "demo:statue?triangles=300000"]

Array = NDArray[Any]


class Question(NamedTuple):
    """What both are asked about a frame."""

    name: str
    rays: int
    ours: Callable[[umbrage.RaycastingScene], Array]
    theirs: Callable[[Any], Array]


def main(arguments: list[str] | None = None) -> int:
    """Run a line of the command, and give its exit code: 0, 2 for bad input or where what it compares with is missing."""
    asked = _parser().parse_args(arguments)
    measure, missing = _measure, "embreex"
    if asked.overhead:
        measure, missing = _overhead, ""
    elif asked.peers:
        from umbrage import _peers

        measure, missing = _peers.measure, "open3d"
    if missing:
        try:
            importlib.import_module(missing)
        except ImportError:
            print(f"error: this compares with {missing}, which isn't installed: pip install {missing}", file=sys.stderr)
            return 2
    try:
        measure(asked)
    except (ValueError, OSError) as wrong:
        print(f"error: {wrong}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    about = "Times scans, cameras, rays and suns of moving meshes beside Embree, and counts where answers differ"
    parser = argparse.ArgumentParser(prog="python -m umbrage.bench", description=about)
    parser.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE", help=f"what `umbrage` reads [default: {' '.join(SCENES)}]")
    parser.add_argument("--size", type=_above_zero, default=1024, metavar="N", help="width and height of the camera's image [default: 1024]")
    parser.add_argument("--suns", type=_above_zero, default=8, metavar="N", help="suns that shine on all faces [default: 8]")
    parser.add_argument("--rounds", type=_above_zero, default=5, metavar="N", help="frames over the animation; one more doesn't count [default: 5]")
    parser.add_argument("--threads", type=_above_zero, default=1, metavar="N", help="threads of Umbrage [default: 1, as embreex has]")
    parser.add_argument("--offset", type=float, default=1e-5, metavar="PART", help="how far Embree's rays to suns begin from their face, in sizes of the scene [default: 1e-5]")
    parser.add_argument("--overhead", metavar="PROGRAM", help="ask this program of the library in place of Embree: what Python adds to a million rays")
    parser.add_argument("--peers", action="store_true", help="ask beside Open3D and, where it is installed, trimesh in place of embreex")
    parser.add_argument("--any-rays", type=_above_zero, default=200_000, metavar="N", help="rays of --peers [default: 200000]")
    parser.add_argument("--points", type=_above_zero, default=100_000, metavar="N", help="points of --peers [default: 100000]")
    parser.add_argument("--rays", type=_above_zero, default=1_000_000, metavar="N", help="rays of --overhead [default: 1000000]")
    return parser


def _above_zero(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} isn't above zero")
    return number


def _measure(asked: argparse.Namespace) -> None:
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    print(f"threads: Umbrage {asked.threads}, embreex 1; medians of {asked.rounds} frames in milliseconds\n")
    print("| scene | triangles | question | rays | Umbrage: build and ask | embreex: build and ask | ratio | differ |")
    print("|---|---|---|---|---|---|---|---|")
    for address in asked.scenes:
        animation = umbrage.open(address)
        times: dict[str, tuple[list[float], list[float]]] = {}
        differ: dict[str, int] = {}
        rays: dict[str, int] = {}
        mesh, scene = None, umbrage.RaycastingScene(nthreads=asked.threads)
        triangles = 0
        for number in range(asked.rounds + 1):
            frame = animation.at(animation.duration * number / (asked.rounds + 1))
            vertices, faces = frame.vertices, frame.triangles
            triangles = len(faces)
            if mesh is None:
                mesh = scene.add_triangles(vertices, faces)
            for question in _questions(vertices, faces, asked):
                start = time.perf_counter()
                scene.update_vertices(mesh, vertices)
                ours = question.ours(scene)
                asked_ours = time.perf_counter()
                embree = rtcore_scene.EmbreeScene()
                TriangleMesh(embree, vertices, faces.astype(np.int32))
                theirs = question.theirs(embree)
                end = time.perf_counter()
                rays[question.name] = question.rays
                if number > 0:
                    both = times.setdefault(question.name, ([], []))
                    both[0].append(1e3 * (asked_ours - start))
                    both[1].append(1e3 * (end - asked_ours))
                    differ[question.name] = differ.get(question.name, 0) + int(np.count_nonzero(ours != theirs))
        for name, (ours_times, theirs_times) in times.items():
            ours_median, theirs_median = statistics.median(ours_times), statistics.median(theirs_times)
            print(
                f"| `{address}` | {triangles:,} | {name} | {rays[name]:,} | {ours_median:.1f} | {theirs_median:.1f} "
                f"| {theirs_median / ours_median:.2f} | {differ[name]:,} |",
                flush=True,
            )
    print("\nratio: how many times as long embreex takes. differ: answers of all frames that are others: whether a ray hits anything.")
    print("Embree's are in float32; its rays to suns begin beside their face, Umbrage's need no offset.")


def _overhead(asked: argparse.Namespace) -> None:
    """Time questions in Rust and in Python, in turn."""
    print(f"threads {asked.threads}, {asked.rays:,} rays; medians of {asked.rounds} answers in milliseconds\n")
    print("| scene | question | Rust | Python | more |\n|---|---|---|---|---|")
    for address in asked.scenes:
        frame = umbrage.open(address).at(0.5)
        random = np.random.default_rng(1)
        directions = random.normal(size=(asked.rays, 3)).astype(np.float32)
        origins = random.uniform(frame.vertices.min(axis=0), frame.vertices.max(axis=0), directions.shape)
        rays = np.concatenate([np.float32(origins), directions], axis=1)
        scene = umbrage.RaycastingScene(nthreads=asked.threads)
        scene.add_triangles(frame.vertices, frame.triangles)
        suns = umbrage.Light.suns([[sun * 0.1 - 0.4, -1.0, 0.2] for sun in range(8)])
        questions: dict[str, Callable[[], Any]] = {
            "scan": lambda scene=scene, directions=directions: scene.scan([0, 1, 0], directions),  # type: ignore[misc]
            "cast_rays": lambda scene=scene, rays=rays: scene.cast_rays(rays),  # type: ignore[misc]
            "lit": lambda scene=scene, suns=suns: scene.lit(suns, faces=True),  # type: ignore[misc]
        }
        with tempfile.NamedTemporaryFile(suffix=".f32") as file:
            rays.tofile(file.name)
            command = [asked.overhead, address, file.name, str(asked.threads)]
            with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as rust:
                assert rust.stdin is not None and rust.stdout is not None
                for name, ask in questions.items():
                    times: list[tuple[float, float]] = []
                    for _ in range(asked.rounds + 2):
                        print(name, file=rust.stdin, flush=True)
                        in_rust = float(rust.stdout.readline())
                        start = time.perf_counter()
                        ask()
                        times.append((in_rust, 1e3 * (time.perf_counter() - start)))
                    # What is built, and memory that is new, isn't counted.
                    rust_median, python_median = (statistics.median(side) for side in zip(*times[2:]))
                    more = 100 * (python_median / rust_median - 1)
                    print(f"| `{address}` | `{name}` | {rust_median:.1f} | {python_median:.1f} | {more:.1f} % |", flush=True)


def _questions(vertices: Array, faces: Array, asked: argparse.Namespace) -> Iterator[Question]:
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle, size = (low + high) / 2, float((high - low).max())

    def of_rays(origins: Array, directions: Array) -> Callable[[Any], Array]:
        origins, directions = np.float32(origins), np.float32(directions)
        return lambda embree: embree.run(origins, directions, query="INTERSECT") >= 0

    # Of hits Embree's wheel gives ids.
    ids = ["primitive_ids"]

    def hits(answer: Any) -> Array:
        return answer["primitive_ids"] != umbrage.RaycastingScene.INVALID_ID

    camera = umbrage.Camera(position=middle + size * np.float32([0.9, 0.5, 1.1]), target=middle)
    of_camera = camera.rays(asked.size, asked.size).reshape(-1, 6)
    yield Question(
        "camera, `see`",
        len(of_camera),
        lambda scene: hits(scene.see(camera, asked.size, asked.size, keys=ids)).reshape(-1),
        of_rays(of_camera[:, :3], of_camera[:, 3:]),
    )
    turn, height = np.meshgrid(np.linspace(0, 2 * np.pi, 2048, endpoint=False), np.radians(np.linspace(-22, 22, 128)))
    sweep = np.stack([np.cos(turn) * np.cos(height), np.sin(height), np.sin(turn) * np.cos(height)], axis=-1)
    sweep = np.float32(sweep.reshape(-1, 3))
    yield Question(
        "lidar, `scan`",
        len(sweep),
        lambda scene: hits(scene.scan(middle, sweep, keys=ids)),
        of_rays(np.broadcast_to(middle, sweep.shape), sweep),
    )
    random = np.random.default_rng(1)
    any_rays = np.float32(np.concatenate([random.uniform(low, high, (200_000, 3)), random.normal(size=(200_000, 3))], axis=1))
    yield Question(
        "any rays, `cast_rays`",
        len(any_rays),
        lambda scene: hits(scene.cast_rays(any_rays, keys=ids)),
        of_rays(any_rays[:, :3], any_rays[:, 3:]),
    )
    heights = 1 - (np.arange(asked.suns) + 0.5) / asked.suns
    turns = np.arange(asked.suns) * 2.399963
    across = np.sqrt(1 - heights * heights)
    suns = np.float32(np.stack([-across * np.cos(turns), -heights, -across * np.sin(turns)], axis=-1))

    def occluded(embree: Any) -> Array:
        corners = vertices[faces]
        centroids = np.float32(corners.mean(axis=1))
        lit = np.empty((len(suns), len(faces)), bool)
        for number, sun in enumerate(suns):
            directions = np.broadcast_to(-sun, centroids.shape)
            hit = embree.run(np.float32(centroids - sun * (asked.offset * size)), np.float32(directions), query="OCCLUDED")
            lit[number] = hit < 0
        return lit

    lights = umbrage.Light.suns(suns)
    yield Question(
        f"{asked.suns} suns on all faces, `lit`",
        asked.suns * len(faces),
        lambda scene: scene.lit(lights, faces=True),
        occluded,
    )


if __name__ == "__main__":
    sys.exit(main())
