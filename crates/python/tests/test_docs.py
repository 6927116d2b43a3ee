"""What the docs say is so: examples of docstrings, and those of docs/python.md."""

import doctest
import pathlib
import re

import numpy as np
import pytest

import umbrage
import umbrage.trimesh

GUIDE = pathlib.Path(__file__).parents[3] / "docs/python.md"


def documented():
    for name in umbrage.__all__:
        if name == "__version__":
            continue
        of = getattr(umbrage, name)
        yield name, of
        for method, function in vars(of).items() if isinstance(of, type) else ():
            if not method.startswith("_") and method != "INVALID_ID":
                yield f"{name}.{method}", function


@pytest.mark.parametrize(("name", "of"), list(documented()))
def test_examples_of_docstrings_hold(name, of):
    text = of.__doc__ or getattr(getattr(of, "__func__", None), "__doc__", None)
    assert text, "without docs"
    scene = umbrage.RaycastingScene()
    scene.add_triangles(np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.uint32([[0, 1, 2]]))
    case = doctest.DocTestParser().get_doctest(text, {"umbrage": umbrage, "np": np, "scene": scene}, name, None, None)
    assert doctest.DocTestRunner().run(case).failed == 0


def test_examples_of_the_trimesh_module_hold():
    pytest.importorskip("trimesh")
    result = doctest.testmod(umbrage.trimesh)
    assert result.attempted and not result.failed


def test_examples_of_the_guide_print_what_they_say(capsys):
    pytest.importorskip("trimesh")
    known = {}
    blocks = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 8
    for block in blocks:
        if "ProcessPoolExecutor" in block:
            # Other processes read a file: test_copies.py has one.
            continue
        exec(compile(block, str(GUIDE), "exec"), known)
        said = re.findall(r"^print\(.*?\)  +# (.*)$", block, re.MULTILINE)
        assert [line.strip() for line in capsys.readouterr().out.splitlines()] == said
