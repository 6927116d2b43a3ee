"""Many frames on many machines, through Ray.

    python -m umbrage.farm render SCENE --frames 0..100000 -o out/%06d.exr --address auto -- --samples 16
    python -m umbrage.farm lit SCENE --frames 0..240 --suns suns.csv -o shares.parquet

``render`` has the command ``umbrage render`` do the work: a task is one ``--shard`` with ``--resume``. ``lit`` asks
``RaycastingScene.lit_areas``. Scenes and results are in folders that all machines share. The same line again goes on where it ended.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

import umbrage

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> int:
    """Run a line of the command, and give its exit code: 0, 1 where frames are missing, 2 for bad input."""
    line = sys.argv[1:] if arguments is None else arguments
    own, rest = (line[: line.index("--")], line[line.index("--") + 1 :]) if "--" in line else (line, [])
    parser = _parser()
    asked, unknown = parser.parse_known_args(own)
    if asked.task == "lit" and unknown + rest:
        parser.error(f"unknown arguments: {' '.join(unknown + rest)}")
    try:
        return _render(asked, unknown + rest) if asked.task == "render" else _lit(asked)
    except (ValueError, OSError) as wrong:
        print(f"error: {wrong}", file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m umbrage.farm", description="Many frames on many machines, through Ray")
    tasks = parser.add_subparsers(dest="task", required=True)
    about = "Render numbered frames; options that aren't known here, and all behind --, are those of `umbrage render`"
    render = tasks.add_parser("render", help=about, description=about, allow_abbrev=False)
    about = "Find how much of each triangle's area suns reach, frame by frame"
    lit = tasks.add_parser("lit", help=about, description=about, allow_abbrev=False)
    for task, output in ((render, "numbered pictures, such as out/%%06d.exr"), (lit, "a .parquet file, or a folder of .npz files")):
        task.add_argument("scene", metavar="SCENE", help="what `umbrage` reads; before other options")
        task.add_argument("--frames", type=_frames, required=True, metavar="A..B", help="without B, or A..=B with it")
        task.add_argument("-o", "--output", required=True, metavar="FILE", help=output)
        task.add_argument("--chunk", type=_above_zero, default=50, metavar="N", help="the most frames of a task [default: 50]")
        task.add_argument("--cpus", type=_above_zero, default=1, metavar="N", help="threads of a task [default: 1]")
        task.add_argument("--retries", type=int, default=3, metavar="N", help="how often a task is tried again [default: 3]")
        task.add_argument("--address", default="local", help="of the Ray cluster, or auto [default: local, this machine alone]")
        task.add_argument("--summary", metavar="FILE", help="a JSON file to write the summary to")
    render.add_argument("--command", metavar="PATH", help="the command [default: `umbrage`, as each machine finds it]")
    lit.add_argument("--suns", required=True, metavar="FILE", help=".csv or .npy of directions x, y, z in which light travels")
    lit.add_argument("--fps", type=float, default=24.0, help="frame k shows second k / FPS [default: 24]")
    lit.add_argument("--samples", type=_above_zero, default=64, help="points of each triangle [default: 64]")
    return parser


def _above_zero(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("give a number from 1")
    return number


def _frames(text: str) -> range:
    first, _, last = text.partition("..")
    try:
        frames = range(int(first), int(last[1:]) + 1 if last.startswith("=") else int(last))
    except ValueError:
        raise argparse.ArgumentTypeError("give frames as A..B or A..=B, such as 0..24") from None
    if not frames or frames.start < 0:
        raise argparse.ArgumentTypeError("there is no frame in that range")
    return frames


def _shares(frames: range, most: int) -> list[range]:
    """Contiguous shares of at most so many frames, as `umbrage render --shard` has them."""
    count = -(-len(frames) // most)
    starts = [frames.start + len(frames) * share // count for share in range(count + 1)]
    return [range(*pair) for pair in zip(starts, starts[1:])]


def _render(asked: argparse.Namespace, rest: list[str]) -> int:
    command = asked.command or shutil.which("umbrage")
    if command is None:
        raise ValueError("there is no command `umbrage` on the PATH; name it by --command")
    # Each machine has it somewhere else, unless it is named.
    program = str(pathlib.Path(command).resolve()) if asked.command else "umbrage"
    frames = asked.frames
    shares = _shares(frames, asked.chunk)
    fixed = [program, "render", asked.scene, *rest, "--frames", f"{frames.start}..{frames.stop}", "-o", asked.output]
    fixed += ["--resume", "--stats", "json", "--quiet", "--threads", str(asked.cpus)]
    lines = [[*fixed, "--shard", f"{share + 1}/{len(shares)}"] for share in range(len(shares))]
    done, failed = _run(asked, _run_command, [(line, os.getcwd()) for line in lines], shares)
    costs = [frame["render_milliseconds"] for report in done for frame in report["frames"]]
    there = sum(report["already_there"] for report in done)
    return _conclude(asked, failed, costs, there)


def _run_command(line: list[str], folder: str) -> dict[str, Any]:
    ran = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False)
    said = ran.stderr.strip().removeprefix("error: ") or f"{line[0]} ended with {ran.returncode}"
    if ran.returncode == 2:
        raise ValueError(said)
    if ran.returncode != 0:
        raise RuntimeError(said)
    return json.loads(ran.stdout)


def _lit(asked: argparse.Namespace) -> int:
    output = pathlib.Path(asked.output)
    is_table = output.suffix == ".parquet"
    if is_table:
        _parquet()
    suns = _suns(pathlib.Path(asked.suns))
    folder = output.with_name(output.name + ".frames") if is_table else output
    folder.mkdir(parents=True, exist_ok=True)
    about = [umbrage.__version__, asked.scene, _size_and_time(asked.scene), asked.fps, asked.samples, suns.tolist()]
    key = hashlib.sha256(json.dumps(about).encode()).hexdigest()
    shares = _shares(asked.frames, asked.chunk)
    fixed = (os.path.abspath(folder), key, suns, asked.fps, asked.samples, asked.cpus)
    where = os.path.abspath(asked.scene) if os.path.exists(asked.scene) else asked.scene
    done, failed = _run(asked, _lit_frames, [(where, share, *fixed) for share in shares], shares)
    if is_table and not failed:
        _write_table(output, [folder / _part(frame) for frame in asked.frames])
    costs = [cost for costs, _ in done for cost in costs]
    return _conclude(asked, failed, costs, sum(there for _, there in done))


def _lit_frames(
    address: str, frames: range, folder: str, key: str, suns: np.ndarray, fps: float, samples: int, threads: int
) -> tuple[list[float], int]:
    """Write a file for each frame that isn't there: milliseconds of each, and how many were there."""
    import time

    missing = [frame for frame in frames if not _is_there(pathlib.Path(folder, _part(frame)), key)]
    animation = umbrage.open(address)
    costs = []
    for frame in missing:
        start = time.perf_counter()
        moment = animation.at(frame / fps, threads)
        scene = umbrage.RaycastingScene(threads)
        scene.add_triangles(moment.vertices, moment.triangles)
        lit = scene.lit_areas(umbrage.Light.suns(suns), samples=samples)
        path = pathlib.Path(folder, _part(frame))
        _whole(path, lambda file: np.savez_compressed(file, key=key, frame=frame, seconds=frame / fps, **lit))
        costs.append(1e3 * (time.perf_counter() - start))
    return costs, len(frames) - len(missing)


def _part(frame: int) -> str:
    return f"lit_{frame:06d}.npz"


def _is_there(path: pathlib.Path, key: str) -> bool:
    try:
        with np.load(path) as part:
            # Reading an array compares its checksum.
            return str(part["key"]) == key and part["share"].shape == part["standard_error"].shape
    except Exception:  # Whatever is broken about a file, it is written again.
        return False


def _whole(path: pathlib.Path, write: Callable[[Any], None]) -> None:
    """Write a file that takes its name only when it is whole."""
    partial = path.with_name(f".{path.name}.partial-{os.getpid()}")
    try:
        with open(partial, "wb") as file:
            write(file)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def _suns(path: pathlib.Path) -> np.ndarray:
    if path.suffix == ".npy":
        suns = np.load(path)
    else:
        with open(path, newline="", encoding="utf-8") as file:
            rows = [row for row in csv.reader(file) if row]
        try:
            suns = np.array([[float(cell) for cell in row] for row in rows])
        except ValueError:  # The first row has names.
            suns = np.array([[float(cell) for cell in row] for row in rows[1:]])
    if suns.ndim != 2 or suns.shape[1] != 3 or len(suns) == 0:
        raise ValueError(f"{path}: expected rows of x, y, z, found shape {suns.shape}")
    return suns.astype(np.float64)


def _size_and_time(address: str) -> list[int]:
    if not os.path.isfile(address):
        return []
    about = os.stat(address)
    return [about.st_size, about.st_mtime_ns]


def _parquet() -> Any:
    try:
        import pyarrow.parquet
    except ImportError:
        raise ValueError("Parquet files need pyarrow (pip install pyarrow); a folder takes .npz files") from None
    return pyarrow


def _write_table(path: pathlib.Path, parts: list[pathlib.Path]) -> None:
    """One row for each frame, sun and triangle, and a group of rows for each frame."""
    arrow = _parquet()
    fields = {"frame": "int32", "sun": "int32", "triangle": "int32", "share": "float64", "standard_error": "float64"}
    schema = arrow.schema([(name, kind) for name, kind in fields.items()])

    def write(file: Any) -> None:
        with arrow.parquet.ParquetWriter(file, schema) as writer:
            for part in map(np.load, parts):
                suns, triangles = np.indices(part["share"].shape).reshape(2, -1)
                columns = [np.full(suns.size, part["frame"]), suns, triangles, part["share"].ravel(), part["standard_error"].ravel()]
                writer.write_table(arrow.table([arrow.array(of, kind) for of, kind in zip(columns, schema.types)], schema=schema))

    _whole(path, write)


def _run(
    asked: argparse.Namespace, work: Callable[..., Any], arguments: list[tuple[Any, ...]], shares: list[range]
) -> tuple[list[Any], dict[range, str]]:
    """Have a cluster do a piece of work for each share: what came of those that went well, and why the others didn't."""
    try:
        import ray
    except ImportError:
        raise ValueError("the farm needs Ray: pip install 'umbrage[farm]'") from None
    ray.init(address=asked.address, log_to_driver=False, logging_level="error", configure_logging=True)
    try:
        task = ray.remote(num_cpus=asked.cpus, max_retries=asked.retries, retry_exceptions=[RuntimeError])(work)
        share_of = {task.remote(*of): share for of, share in zip(arguments, shares)}
        done, failed = [], {}
        for finished in _progress(_as_they_finish(ray, list(share_of)), len(share_of)):
            try:
                done.append(ray.get(finished))
            except ray.exceptions.RayTaskError as error:
                if isinstance(error.cause, (ValueError, OSError)):
                    raise error.cause from None
                failed[share_of[finished]] = str(error.cause)
            except ray.exceptions.RayError as error:
                failed[share_of[finished]] = str(error)
        return done, failed
    finally:
        ray.shutdown()


def _as_they_finish(ray: Any, pending: list[Any]) -> Iterator[Any]:
    while pending:
        finished, pending = ray.wait(pending)
        yield from finished


def _progress(tasks: Iterable[Any], count: int) -> Iterable[Any]:
    try:
        import tqdm
    except ImportError:
        return tasks
    return tqdm.tqdm(tasks, total=count, unit="task", disable=None)


def _conclude(asked: argparse.Namespace, failed: dict[range, str], costs: list[float], there: int) -> int:
    missing = sorted(frame for share in failed for frame in share)
    summary: dict[str, Any] = {
        "frames": len(asked.frames),
        "rendered" if asked.task == "render" else "computed": len(costs),
        "already_there": there,
        "median_milliseconds": statistics.median(costs) if costs else 0.0,
        "total_seconds": sum(costs) / 1e3,
        "missing": _spans(missing),
        "failures": sorted(set(failed.values())),
    }
    if asked.summary:
        pathlib.Path(asked.summary).write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    print(
        f"{asked.output}: {len(costs)} of {len(asked.frames)} frames in {summary['total_seconds']:.1f} s of work, "
        f"{summary['median_milliseconds']:.1f} ms in the median; {there} were there already"
    )
    for why in summary["failures"]:
        print(f"error: {why}", file=sys.stderr)
    if missing:
        print(f"missing: {', '.join(summary['missing'])}; the same line again goes on", file=sys.stderr)
    return 1 if missing else 0


def _spans(frames: list[int]) -> list[str]:
    """Frames as ranges A..B, without B."""
    known = set(frames)
    starts = [frame for frame in frames if frame - 1 not in known]
    ends = [frame + 1 for frame in frames if frame + 1 not in known]
    return [f"{start}..{end}" for start, end in zip(starts, ends)]


if __name__ == "__main__":
    sys.exit(main())
