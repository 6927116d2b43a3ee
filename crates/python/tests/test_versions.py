"""The oldest Python that the package promises is one that it runs on."""

import ast
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).parents[3]
SOURCES = sorted((ROOT / "crates/python").rglob("*.py"))


def oldest():
    """Major and minor version, as pyproject.toml says them."""
    said = re.search(r'^requires-python = ">=(\d+)\.(\d+)"$', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
    return tuple(map(int, said.groups()))


def test_the_library_is_built_for_the_oldest_python():
    major, minor = oldest()
    assert f'"abi3-py{major}{minor}"' in (ROOT / "crates/python/Cargo.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.name)
def test_sources_are_read_by_the_oldest_python(path):
    tree = ast.parse(path.read_text(encoding="utf-8"), feature_version=oldest())
    # The one newer argument that is easily written.
    strict = [node.lineno for node in ast.walk(tree) if isinstance(node, ast.keyword) and node.arg == "strict"]
    assert not strict, f"lines {strict}: zip has no `strict` before Python 3.10"
