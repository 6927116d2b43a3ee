#!/usr/bin/env python3
"""Opens every model below some folders with the command `umbrage`, each in a process with limits, and writes a table.

    cargo build --release -p umbrage-cli -p contact-sheet
    python tools/compatibility/compatibility.py MODELS --output table.md --sheet sheet.png

A row of the table has a file's outcome (opened, warned, refused, timed out or crashed), the first line of its message, its
triangles, seconds and peak memory. With `--python PATH`, a Python that has trimesh, triangles and bounds are compared with
trimesh's, which knows no skins, morph targets, animations, instances and Draco. The exit code is 1 where a file timed out
or crashed.
"""

import argparse
import collections
import csv
import dataclasses
import io
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

KINDS = {".gltf", ".glb", ".obj", ".ply", ".stl", ".pc2", ".mdd"}
OUTCOMES = ("opened", "warned", "refused", "timed out", "crashed")
BAD = OUTCOMES[3:]
UNITS = {"": 1, "KB": 10**3, "MB": 10**6, "GB": 10**9, "KIB": 2**10, "MIB": 2**20, "GIB": 2**30}
BUILT = pathlib.Path(__file__).resolve().parents[2] / "target" / "release"
# Characters of a message in the table.
LONGEST = 160
# Files on one contact sheet.
PAGE = 48
# Bounds count as the same up to this part of their diagonal.
ROUNDING = 1e-5
TRIMESH = """
import json, sys, trimesh
triangles = trimesh.load_scene(sys.argv[1], process=False).triangles
ends = [triangles.min((0, 1)).tolist(), triangles.max((0, 1)).tolist()] if len(triangles) else None
print(json.dumps({"triangles": len(triangles), "bounds": ends}))
"""


@dataclasses.dataclass
class Limits:
    seconds: float
    bytes: int


@dataclasses.dataclass
class Ended:
    """A process that has ended: its exit code, negative for a signal, and `None` when its time was over."""

    code: int | None
    output: str
    error: str
    seconds: float
    mebibytes: float | None


@dataclasses.dataclass
class Row:
    file: str
    outcome: str
    message: str
    triangles: int | None
    seconds: float
    mebibytes: float | None
    trimesh: str = ""

    def cells(self):
        memory = "" if self.mebibytes is None else f"{self.mebibytes:.0f}"
        triangles = "" if self.triangles is None else str(self.triangles)
        return self.file, self.outcome, self.message, triangles, f"{self.seconds:.2f}", memory, self.trimesh


def run(command, limits):
    """Runs a command to its end, or until its time is over. The system gives it little more than twice its memory, since a
    program's own limit holds only where the program is right."""

    def limited():
        import resource

        most = 2 * limits.bytes + 2**29
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))

    started = time.monotonic()
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as error:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=error,
            preexec_fn=limited if os.name == "posix" else None,
        )
        code, kibibytes = wait(process, started + limits.seconds)
        seconds = time.monotonic() - started
        texts = []
        for file in (output, error):
            file.seek(0)
            texts.append(file.read().decode(errors="replace"))
    # macOS counts in bytes.
    mebibytes = kibibytes and kibibytes / (2**20 if sys.platform == "darwin" else 2**10)
    return Ended(code, *texts, seconds, mebibytes)


def wait(process, until):
    """The process's exit code, and its peak memory where the system tells."""
    if not hasattr(os, "wait4"):
        try:
            return process.wait(until - time.monotonic()), None
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            return None, None
    pause, in_time = 0.001, True
    while True:
        ended, status, usage = os.wait4(process.pid, os.WNOHANG if in_time else 0)
        if ended:
            process.returncode = os.waitstatus_to_exitcode(status)
            return process.returncode if in_time else None, usage.ru_maxrss
        if time.monotonic() > until:
            in_time = False
            process.kill()
        else:
            time.sleep(pause)
            pause = min(2 * pause, 0.01)


def opened(umbrage, path, name, limits):
    """The row of a file, and its bounds."""
    ended = run([umbrage, "info", "--json", "--max-memory", str(limits.bytes), path], limits)
    lines = [line.strip() for line in ended.error.splitlines() if line.strip()] or [""]
    outcome, message, contents = "crashed", lines[0], {}
    if ended.code is None:
        outcome, message = "timed out", f"after {limits.seconds:g} s"
    elif ended.code == 0:
        try:
            contents = json.loads(ended.output)
        except ValueError:
            message = "its output isn't JSON"
        else:
            omitted = [f"{kind['count']} triangles left out: {kind['reason']}" for kind in contents["omitted"]]
            warnings = contents["warnings"] + omitted
            outcome, message = ("warned", warnings[0]) if warnings else ("opened", "")
            if len(warnings) > 1:
                message += f" (and {len(warnings) - 1} more)"
    elif ended.code in (1, 2) and lines[0].startswith("error: "):
        outcome, message = "refused", lines[0].removeprefix("error: ")
    else:
        message = f"exit code {ended.code}: {' '.join(lines[:2])}"
    message = message.removeprefix(f"{path}: ").replace(str(path), name)
    message = re.sub(r"[\x00-\x1f\x7f]+", " ", message)
    if len(message) > LONGEST:
        message = message[: LONGEST - 1] + "…"
    row = Row(name, outcome, message, contents.get("triangles"), ended.seconds, ended.mebibytes)
    return row, contents.get("bounds")


def other(python, path, limits):
    """Triangles and bounds by trimesh, or the reason why there are none."""
    ended = run([python, "-c", TRIMESH, path], limits)
    if ended.code is None:
        return "timed out"
    if ended.code != 0:
        lines = ended.error.strip().splitlines() or [f"exit code {ended.code}"]
        return "refused: " + re.sub(r"[\x00-\x1f\x7f]+", " ", lines[-1])[:60]
    return json.loads(ended.output)


def compared(row, bounds, theirs):
    """How triangles and bounds differ from trimesh's, in words."""
    if isinstance(theirs, str):
        return theirs
    if theirs["triangles"] != row.triangles:
        return f"{theirs['triangles']} triangles"
    if not bounds or not theirs["bounds"]:
        return "same triangles" if bounds or theirs["bounds"] else "same"
    ours, others = sum(bounds, []), sum(theirs["bounds"], [])
    if not all(map(math.isfinite, others)):
        return "same triangles, bounds not finite"
    # Umbrage's coordinates are of 32 bits.
    apart = max(abs(a - b) - abs(b) * 2**-23 for a, b in zip(ours, others)) / (math.dist(*bounds) or 1.0)
    return "same" if apart <= ROUNDING else f"same triangles, bounds {apart:.1%} apart"


def models(places):
    """All files that the command opens, below folders or by themselves, each with its name in the table."""
    for place in places:
        found = sorted(place.rglob("*")) if place.is_dir() else [place]
        for path in found:
            if path == place or (path.suffix.lower() in KINDS and path.is_file()):
                yield path.absolute(), path.name if path == place else path.relative_to(place).as_posix()


def written(rows, kind):
    """The table as Markdown or CSV."""
    heads = ("file", "outcome", "message", "triangles", "seconds", "MiB", "trimesh")
    if kind == ".csv":
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([heads, *(row.cells() for row in rows)])
        return text.getvalue()
    lines = [heads, ["---", "---", "---", "--:", "--:", "--:", "---"], *(row.cells() for row in rows)]
    # Names and messages come from files, and may hold anything.
    escaped = ([re.sub(r"([\\|`*_<\[])", r"\\\1", re.sub(r"\s+", " ", cell)) for cell in line] for line in lines)
    return "".join(f"| {' | '.join(line)} |\n" for line in escaped)


def sheets(program, paths, target, limits):
    """Writes pictures of files, so many to a sheet, and says which sheets failed."""
    pages = [paths[first : first + PAGE] for first in range(0, len(paths), PAGE)]
    for number, page in enumerate(pages, 1):
        path = target if len(pages) == 1 else target.with_stem(f"{target.stem}-{number}")
        arguments = ["--times", "0.5", "--size", "240x160", "--samples", "4", "-o", path]
        ended = run([program, *page, *arguments], Limits(limits.seconds * len(page), limits.bytes))
        if ended.code not in (0, 1) or not path.exists():
            why = ended.error.strip().splitlines()[-1:] or [f"exit code {ended.code}"]
            yield f"{path}: " + ("its time was over" if ended.code is None else why[0])


def size(text):
    number, unit = re.fullmatch(r"([0-9.]+)\s*([A-Za-z]*)", text).groups()
    return int(float(number) * UNITS[unit.upper()])


def seconds(text):
    value = float(text)
    if not 0 < value < 1e6:
        raise ValueError
    return value


def program(given, name):
    """A program that is given, built in this repository, or found on the path; `None` if there is none."""
    return given or next(filter(None, (shutil.which(name, path=str(BUILT)), shutil.which(name))), None)


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Opens every model below some folders, and writes a table")
    parser.add_argument("places", nargs="+", type=pathlib.Path, metavar="FOLDER", help="folders, or single files")
    parser.add_argument("--output", type=pathlib.Path, metavar="FILE", help="table, .md or .csv [default: printed]")
    parser.add_argument("--sheet", type=pathlib.Path, metavar="FILE.png", help=f"pictures, {PAGE} files to a sheet")
    parser.add_argument("--seconds", type=seconds, default=20.0, help="for each file [default: 20]")
    parser.add_argument("--memory", type=size, default="4GiB", help="for each file [default: 4GiB]")
    parser.add_argument("--umbrage", metavar="PATH", help="the command [default: target/release, then PATH]")
    parser.add_argument("--contact-sheet", metavar="PATH", help="the program [default: target/release, then PATH]")
    parser.add_argument("--python", metavar="PATH", help="a Python that has trimesh, to compare with")
    flags = parser.parse_args(arguments)
    umbrage, painter = program(flags.umbrage, "umbrage"), program(flags.contact_sheet, "contact-sheet")
    if umbrage is None:
        parser.error("there is no command `umbrage`: build it, or give --umbrage PATH")
    if flags.sheet and painter is None:
        parser.error("there is no program `contact-sheet`: build it, or give --contact-sheet PATH")
    if missing := [str(place) for place in flags.places if not place.exists()]:
        parser.error(f"{missing[0]} isn't there")
    limits = Limits(flags.seconds, flags.memory)
    # A Python starts slowly, and reads in Python.
    patient = Limits(3 * flags.seconds, flags.memory)
    has_trimesh = flags.python and run([flags.python, "-c", "import trimesh"], patient).code == 0
    rows, pictured = [], []
    for path, name in models(flags.places):
        row, bounds = opened(umbrage, path, name, limits)
        if has_trimesh:
            row.trimesh = compared(row, bounds, other(flags.python, path, patient))
        print(f"{name}: {row.outcome}", file=sys.stderr)
        rows.append(row)
        if row.outcome in ("opened", "warned"):
            pictured.append(path)
    table = written(rows, flags.output.suffix.lower() if flags.output else ".md")
    if flags.output:
        flags.output.write_text(table, encoding="utf-8")
    else:
        print(table, end="")
    failed = list(sheets(painter, pictured, flags.sheet, limits)) if flags.sheet else []
    counts = collections.Counter(row.outcome for row in rows)
    summary = f"{len(rows)} files: " + ", ".join(f"{counts[outcome]} {outcome}" for outcome in OUTCOMES)
    if not flags.python:
        summary += "; not compared with trimesh (--python PATH)"
    elif not has_trimesh:
        summary += f"; not compared: {flags.python} has no trimesh"
    print("\n".join([*failed, summary]), file=sys.stderr)
    return int(bool(failed) or any(counts[outcome] for outcome in BAD))


if __name__ == "__main__":
    sys.exit(main())
