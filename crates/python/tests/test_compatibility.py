"""The table of tools/compatibility: outcomes, limits, and the comparison with trimesh."""

import csv
import importlib.util
import os
import pathlib
import shutil
import sys

import pytest

SOURCE = pathlib.Path(__file__).parents[3] / "tools" / "compatibility" / "compatibility.py"
SPECIFICATION = importlib.util.spec_from_file_location("compatibility", SOURCE)
compatibility = importlib.util.module_from_spec(SPECIFICATION)
sys.modules["compatibility"] = compatibility
SPECIFICATION.loader.exec_module(compatibility)

unix = pytest.mark.skipif(os.name != "posix", reason="stands in for a program with a script of a Unix shell")

# Does with a file, its fifth argument, as the file's name says.
COMMAND = f"""#!/bin/sh
case "$5" in
    *slow*) exec sleep 60 ;;
    *signal*) kill -SEGV $$ ;;
    *hungry*) exec {sys.executable} -c 'bytearray(10**9)' ;;
    *panic*) printf "thread 'main' panicked at a.rs:1:2:\\nno such index\\n" >&2; exit 101 ;;
    *words*) echo words ;;
    *) echo "error: $5: line 1: a | in
second line" >&2; exit 2 ;;
esac
"""


def program(path, text):
    path.write_text(text)
    path.chmod(0o755)
    return str(path)


@unix
def test_every_end_of_a_process_is_an_outcome(tmp_path, capsys):
    models = tmp_path / "models"
    models.mkdir()
    for name in ("slow.obj", "signal.glb", "hungry.ply", "panic.STL", "words.gltf", "a|b.obj", "notes.txt"):
        (models / name).touch()
    command = program(tmp_path / "umbrage", COMMAND)
    arguments = [str(models), "--umbrage", command, "--seconds", "0.5", "--memory", "1MB"]
    table = tmp_path / "table.csv"
    assert compatibility.main([*arguments, "--output", str(table)]) == 1
    rows = {row["file"]: row for row in csv.DictReader(table.open())}
    expected = {
        "slow.obj": ("timed out", "after 0.5 s"),
        "signal.glb": ("crashed", "exit code -11: "),
        "hungry.ply": ("crashed", "exit code 1: Traceback (most recent call last): File "),
        "panic.STL": ("crashed", "exit code 101: thread 'main' panicked at a.rs:1:2: no such index"),
        "words.gltf": ("crashed", "its output isn't JSON"),
        "a|b.obj": ("refused", "line 1: a | in"),
    }
    assert rows.keys() == expected.keys()
    for name, (outcome, message) in expected.items():
        assert rows[name]["outcome"] == outcome and rows[name]["message"].startswith(message), rows[name]
        assert float(rows[name]["seconds"]) < 5 and int(rows[name]["MiB"]) < 600, rows[name]
    assert "6 files: 0 opened, 0 warned, 1 refused, 1 timed out, 4 crashed" in capsys.readouterr().err
    assert compatibility.main([str(models / "a|b.obj"), "--umbrage", command]) == 0
    assert "| a\\|b.obj | refused | line 1: a \\| in |" in capsys.readouterr().out


@unix
def test_sheets_have_so_many_files(tmp_path, monkeypatch):
    monkeypatch.setattr(compatibility, "PAGE", 2)
    painter = program(tmp_path / "painter", '#!/bin/sh\nfor last; do :; done\n[ "$1" != bad ] && echo "$1 $2" > "$last"\n')
    limits = compatibility.Limits(5, 10**8)
    target = tmp_path / "sheet.png"
    assert list(compatibility.sheets(painter, ["a", "b", "c"], target, limits)) == []
    written = [(tmp_path / f"sheet-{number}.png").read_text() for number in (1, 2)]
    assert written == ["a b\n", "c --times\n"]
    assert list(compatibility.sheets(painter, ["bad"], target, limits)) == [f"{target}: exit code 1"]


@pytest.mark.skipif(shutil.which("umbrage") is None, reason="there is no command `umbrage`")
def test_files_are_opened_and_compared(tmp_path):
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    texts = {"good.obj": corners + "f 1 2 3\n", "flat.obj": corners + "f 1 2 3\nf 1 1 2\n", "bad.obj": corners + "f 1 2 9\n"}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    limits = compatibility.Limits(20, 2**30)
    rows = {}
    for path, name in compatibility.models([tmp_path]):
        rows[name] = compatibility.opened("umbrage", path, name, limits)
    outcomes = {name: (row.outcome, row.triangles) for name, (row, _) in rows.items()}
    assert outcomes == {"good.obj": ("opened", 1), "flat.obj": ("warned", 2), "bad.obj": ("refused", None)}
    assert rows["flat.obj"][0].message.startswith("1 triangles left out") and "line 4" in rows["bad.obj"][0].message
    row, bounds = rows["good.obj"]
    assert bounds == [[0, 0, 0], [1, 1, 0]]
    # Our count and bounds, beside others of theirs.
    theirs = compatibility.other(sys.executable, tmp_path / "good.obj", limits)
    cases = [(1, bounds, "same"), (2, bounds, "1 triangles"), (1, [[0, 0, 0], [2, 1, 0]], "same triangles, bounds 44.7% apart")]
    for triangles, bounds, expected in cases:
        row.triangles = triangles
        assert compatibility.compared(row, bounds, theirs) == expected
    assert compatibility.other(sys.executable, tmp_path / "gone.obj", limits).startswith("refused: ")
