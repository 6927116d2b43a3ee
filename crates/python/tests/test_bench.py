"""The comparison with embreex: what it says without it, and that it runs with it."""

import sys

import pytest

from umbrage import bench


def test_without_embreex_it_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "embreex", None)
    assert bench.main(["demo:cloth?triangles=300"]) == 2
    assert "pip install embreex" in capsys.readouterr().err


def test_a_scene_that_is_not_there_is_an_error_in_words(monkeypatch, capsys):
    pytest.importorskip("embreex", reason="embreex isn't installed")
    assert bench.main(["demo:nowhere"]) == 2
    assert "nowhere" in capsys.readouterr().err


def test_each_question_has_a_row_and_both_agree(capsys):
    pytest.importorskip("embreex", reason="embreex isn't installed")
    assert bench.main(["demo:cloth?triangles=300", "--size", "64", "--suns", "2", "--rounds", "2"]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("| `demo:cloth")]
    assert [row.split("|")[3].strip().split("`")[1] for row in rows] == ["see", "scan", "cast_rays", "lit"]
    for row in rows:
        rays, differ = (int(row.split("|")[column].replace(",", "")) for column in (4, 8))
        # Embree answers in float32.
        assert rays > 0 and differ <= rays // 100, row


def test_without_open3d_it_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "open3d", None)
    assert bench.main(["--peers", "demo:cloth?triangles=300"]) == 2
    assert "pip install open3d" in capsys.readouterr().err


def test_peers_agree_about_meshes_that_stay_and_move(capsys):
    pytest.importorskip("open3d", reason="Open3D isn't installed")
    line = ["--peers", "demo:cloth?triangles=300", "--any-rays", "2000", "--points", "500", "--rounds", "2"]
    assert bench.main(line) == 0
    rows = [line.split("|") for line in capsys.readouterr().out.splitlines() if line.startswith("| `demo:cloth")]
    assert [row[3].strip() for row in rows] == ["stays"] * 8 + ["moves"] * 8
    for row in rows:
        count, ours, theirs, differ = int(row[5].replace(",", "")), float(row[6]), float(row[7]), int(row[11].replace(",", ""))
        assert count > 0 and ours > 0 and theirs > 0 and differ <= count // 100, row


def test_what_python_adds_is_a_row_for_each_question(tmp_path, capsys):
    program = tmp_path / "program"
    program.write_text("#!/bin/sh\nwhile read name; do echo 50; done\n")
    program.chmod(0o755)
    line = ["demo:cloth?triangles=300", "--overhead", str(program), "--rays", "100", "--rounds", "1"]
    assert bench.main(line) == 0
    rows = [row.split("|") for row in capsys.readouterr().out.splitlines() if row.startswith("| `")]
    assert [row[2].strip() for row in rows] == ["`scan`", "`cast_rays`", "`lit`"]
    assert all(row[3].strip() == "50.0" and float(row[4]) < 50 and row[5].strip().startswith("-") for row in rows)
    assert bench.main(["--overhead", str(tmp_path / "none")]) == 2
    assert "none" in capsys.readouterr().err
