"""Frames that are rendered and lit by many processes, and what is left to do where some of them end."""

import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest

import umbrage
from umbrage import farm

RECIPES = pathlib.Path(__file__).parents[1] / "recipes"
SCENE, LOOK = "demo:cloth?triangles=300", ["--size", "32x24"]

pytestmark = pytest.mark.skipif(shutil.which("umbrage") is None, reason="there is no command `umbrage`")


@pytest.fixture(scope="module")
def cluster():
    """One of a single node; starting it takes longer than all that is asked of it."""
    pytest.importorskip("ray", reason="Ray isn't installed")
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    yield cluster
    cluster.shutdown()


def hashes(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.glob("*.png")}


@pytest.fixture
def whole(tmp_path):
    """The hashes of all frames of a single run."""

    def render(frames):
        folder = tmp_path / "whole"
        folder.mkdir()
        line = ["umbrage", "render", SCENE, *LOOK, "--frames", frames, "-o", str(folder / "%03d.png"), "--quiet"]
        subprocess.run(line, check=True)
        return hashes(folder)

    return render


def test_shares_are_those_of_the_command():
    for frames, most in ((range(1000), 50), (range(5, 12), 3), (range(7, 8), 3), (range(101), 50)):
        shares = farm._shares(frames, most)
        assert [frame for share in shares for frame in share] == list(frames)
        assert max(map(len, shares)) <= most and max(map(len, shares)) - min(map(len, shares)) <= 1


def test_a_node_that_dies_costs_no_frame(tmp_path, cluster, whole):
    # A task is under way when its node goes; the other node waits for that.
    command, out, mark = tmp_path / "slow", tmp_path / "out", tmp_path / "mark"
    command.write_text(
        f"""#!/bin/sh
if [ "$UMBRAGE_TEST_NODE" = mortal ]; then touch {mark}; sleep 30; fi
tries=0
until [ -e {mark} ] || [ $tries = 600 ]; do tries=$((tries + 1)); sleep 0.1; done
exec umbrage "$@"
"""
    )
    command.chmod(0o755)
    out.mkdir()
    line = ["render", SCENE, *LOOK, "--frames", "0..40", "--chunk", "4", "-o", str(out / "%03d.png"), "--command", str(command)]
    mortal = cluster.add_node(num_cpus=1, env_vars={"UMBRAGE_TEST_NODE": "mortal"})
    summary = tmp_path / "summary.json"
    ask = [sys.executable, "-m", "umbrage.farm", *line, "--address", cluster.address, "--summary", str(summary)]
    with subprocess.Popen(ask, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as asked:
        deadline = time.monotonic() + 120
        while not mark.exists() and asked.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        cluster.remove_node(mortal, allow_graceful=False)
        said, _ = asked.communicate(timeout=120)
    assert mark.exists(), said
    assert asked.returncode == 0, said
    assert hashes(out) == whole("0..40"), said
    assert '"missing": []' in summary.read_text()


def test_the_same_line_goes_on_and_failures_name_frames(tmp_path, cluster, capfd):
    line = ["render", SCENE, "--frames", "0..6", "--chunk", "2", "-o", str(tmp_path / "%03d.png")]
    line += ["--retries", "0", "--address", cluster.address, "--", *LOOK]
    # A folder in the way of a picture.
    (tmp_path / "003.png").mkdir()
    assert farm.main(line) == 2
    assert "is a folder" in capfd.readouterr().err
    (tmp_path / "003.png").rmdir()
    assert farm.main(line) == 0
    assert farm.main(line) == 0
    assert "0 of 6 frames" in (said := capfd.readouterr().out) and "6 were there already" in said
    # What fails for one share alone, and might not another time.
    broken = tmp_path / "broken"
    broken.write_text('#!/bin/sh\ncase "$*" in *"--shard 2/3"*) echo "error: no room" >&2; exit 1;; esac\nexec umbrage "$@"\n')
    broken.chmod(0o755)
    assert farm.main([*line[:-3], "--command", str(broken), *line[-3:]]) == 1
    said = capfd.readouterr().err
    assert "error: no room\nmissing: 2..4; the same line again goes on" in said and "error: error" not in said


def test_lit_areas_are_those_of_one_process(tmp_path, cluster, capfd):
    suns = np.array([[0.0, -1, 0], [-1, -1, 0.5]])
    (tmp_path / "suns.csv").write_text("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in suns))
    line = ["lit", SCENE, "--frames", "2..5", "--chunk", "2", "--suns", str(tmp_path / "suns.csv")]
    line += ["--samples", "16", "--address", cluster.address]
    assert farm.main([*line, "-o", str(tmp_path / "out")]) == 0
    animation = umbrage.open(SCENE)
    expected = {}
    for frame in range(2, 5):
        scene = umbrage.RaycastingScene()
        moment = animation.at(frame / 24)
        scene.add_triangles(moment.vertices, moment.triangles)
        expected[frame] = scene.lit_areas(umbrage.Light.suns(suns), samples=16)["share"]
        with np.load(tmp_path / f"out/lit_{frame:06d}.npz") as part:
            assert (part["share"] == expected[frame]).all() and part["seconds"] == frame / 24
    broken = tmp_path / "out/lit_000003.npz"
    broken.write_bytes(broken.read_bytes()[:-200])
    capfd.readouterr()
    assert farm.main([*line, "-o", str(tmp_path / "out")]) == 0
    assert "1 of 3 frames" in capfd.readouterr().out, "the one that was cut off"
    assert farm.main([*line, "-o", str(tmp_path / "out"), "--fps", "12"]) == 0
    assert "3 of 3 frames" in capfd.readouterr().out, "of other moments"

    parquet = pytest.importorskip("pyarrow.parquet")
    assert farm.main([*line, "-o", str(tmp_path / "shares.parquet")]) == 0
    table = parquet.read_table(tmp_path / "shares.parquet").to_pydict()
    rows = [expected[frame][sun, triangle] for frame, sun, triangle in zip(table["frame"], table["sun"], table["triangle"])]
    assert len(rows) == 3 * expected[2].size and table["share"] == rows


def test_bad_input_is_said(tmp_path, capsys):
    suns = tmp_path / "suns.npy"
    np.save(suns, np.zeros((2, 2)))
    assert farm.main(["lit", SCENE, "--frames", "0..2", "--suns", str(suns), "-o", str(tmp_path / "out")]) == 2
    assert "expected rows of x, y, z" in capsys.readouterr().err
    for frames in ("0", "2..2", "a..b"):
        with pytest.raises(SystemExit) as ended:
            farm.main(["render", SCENE, "--frames", frames, "-o", "%d.png"])
        assert ended.value.code == 2


@pytest.mark.skipif(os.name == "nt", reason="a script for sh")
def test_the_slurm_script_renders_all_shares(tmp_path, whole):
    for task in (1, 2, 3):
        array = {"SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": "3", "SLURM_CPUS_PER_TASK": "1"}
        line = [str(RECIPES / "slurm.sh"), SCENE, "0..7", str(tmp_path / "%03d.png"), *LOOK]
        subprocess.run(line, env=os.environ | array, check=True)
    assert hashes(tmp_path) == whole("0..7")


def test_the_openjd_template_renders_all_shares(tmp_path, whole):
    yaml = pytest.importorskip("yaml")
    template = yaml.safe_load((RECIPES / "openjd.yaml").read_text())
    given = {"Scene": SCENE, "Frames": "0..5", "Pictures": str(tmp_path / "%03d.png"), "Size": LOOK[1], "Shards": 3}
    known = {of["name"]: str(given.get(of["name"], of.get("default"))) for of in template["parameterDefinitions"]}
    assert given.keys() <= known.keys() and "None" not in known.values()
    (step,) = template["steps"]
    run = step["script"]["actions"]["onRun"]

    def filled(text, task):
        for name, value in known.items():
            text = text.replace(f"{{{{Param.{name}}}}}", value)
        return text.replace("{{Task.Param.Shard}}", str(task))

    (shard,) = step["parameterSpace"]["taskParameterDefinitions"]
    first, last = map(int, filled(shard["range"], 0).split("-"))
    for task in range(first, last + 1):
        subprocess.run([run["command"], *(filled(word, task) for word in run["args"])], check=True)
    assert hashes(tmp_path) == whole("0..5")


def test_openjd_takes_the_template():
    openjd = shutil.which("openjd", path=f"{pathlib.Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if openjd is None:
        pytest.skip("the command `openjd` isn't installed")
    subprocess.run([openjd, "check", str(RECIPES / "openjd.yaml")], check=True)
