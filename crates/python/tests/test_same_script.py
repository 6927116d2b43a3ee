"""The scripts of docs/same-script.md, in each library that is installed, give the same answers."""

import pathlib
import re

import numpy as np
import pytest

PAGE = pathlib.Path(__file__).parents[3] / "docs/same-script.md"
TEXT = PAGE.read_text(encoding="utf-8")
BLOCKS = dict(re.findall(r"^#+ (.*?)$[^#]*?```python\n(.*?)```", TEXT, re.DOTALL | re.MULTILINE))


def answers(script):
    known = {}
    exec(compile(BLOCKS["The same script in four libraries"], str(PAGE), "exec"), known)
    exec(compile(script, str(PAGE), "exec"), known)
    assert len(known["answers"]) == len(known["FRAMES"])
    return known["answers"]


@pytest.mark.parametrize(
    ("library", "package", "instead"),
    [
        ("Open3D", "open3d", []),
        ("trimesh", "trimesh", []),
        (
            "trimesh",
            "trimesh",
            [
                ("import trimesh", "import trimesh, umbrage.trimesh"),
                ("mesh.ray.", "umbrage.trimesh.RayMeshIntersector(mesh)."),
                ("trimesh.proximity.closest_point(mesh, points)", "umbrage.trimesh.ProximityQuery(mesh).on_surface(points)"),
            ],
        ),
    ],
    ids=["Open3D", "trimesh", "umbrage.trimesh"],
)
def test_other_libraries_say_the_same(library, package, instead):
    pytest.importorskip(package, reason=f"{package} isn't installed")
    script = BLOCKS[library]
    for old, new in instead:
        assert script.count(old) == 1
        script = script.replace(old, new)
    frames = answers(BLOCKS["Umbrage"])
    for (ids, t, distance), (other_ids, other_t, other_distance) in zip(frames, answers(script)):
        np.testing.assert_array_equal(np.isfinite(t), np.isfinite(other_t))
        np.testing.assert_allclose(other_t, t, rtol=2e-6)
        np.testing.assert_allclose(other_distance, distance, rtol=1e-5, atol=1e-6)
        # A beam through an edge hits either triangle.
        assert (ids != other_ids).mean() < 1e-3
    first, last = frames[0], frames[-1]
    assert (first[0] != last[0]).any() and (first[2] != last[2]).all(), "the mesh moves"
    assert 0.5 < np.isfinite(first[1]).mean() < 1, "some beams miss"
