"""What the project says of itself: what it needs, its version, and what `make` removes."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import crackgrow

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
NAMES = {"PIL": "pillow", "yaml": "pyyaml"}  # of packages that are imported by another one
THROUGH_OTHERS = {"h5py"}  # meshio has it as an extra, and imports it whenever it reads or writes XDMF


def imported() -> set[str]:
    """Packages of others that the program imports, anywhere."""
    found = set()
    for path in (ROOT / "crackgrow").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found.add(node.module.split(".")[0])
    return {NAMES.get(name, name) for name in found - {"crackgrow", *sys.stdlib_module_names}}


def test_all_that_is_imported_is_declared_with_the_oldest_version_that_will_do() -> None:
    optional = PROJECT["optional-dependencies"]
    declared = [*PROJECT["dependencies"], *optional["sweep"], *optional["maps"]]
    assert all(re.fullmatch(r"[a-z][a-z0-9]*>=[\d.]+", text) for text in declared)
    assert {text.split(">=")[0] for text in declared} == imported() | THROUGH_OTHERS
    assert f'".[{",".join(sorted(optional))}]"' in (ROOT / "Makefile").read_text(
        encoding="utf-8"
    )  # what `make lock` pins
    pinned = (ROOT / ".requirements.lock").read_text(encoding="utf-8").lower()
    assert all(f"\n{text.split('>=')[0]}==" in f"\n{pinned}" for text in declared)


def test_the_version_stands_in_one_place_and_the_citation_has_it() -> None:
    assert "version" not in PROJECT
    assert "version" in PROJECT["dynamic"]
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert re.findall(r"version = \{(.*)\}", text) == [crackgrow.__version__]


@pytest.mark.parametrize(("target", "answer", "stays"), [
    ("clean", "", True), ("clean-outputs", "", True), ("clean-outputs", "n\n", True), ("clean-outputs", "y\n", False),
])  # fmt: skip
def test_results_go_only_where_the_user_says_so(target: str, answer: str, stays: bool, tmp_path: Path) -> None:
    shutil.copy(ROOT / "Makefile", tmp_path)
    result, cache = tmp_path / "outputs" / "mine" / "summary.json", tmp_path / ".pytest_cache" / "x"
    for file in (result, cache, tmp_path / "outputs" / "README.md"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("mine")
    done = subprocess.run(["make", target], cwd=tmp_path, input=answer, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert result.exists() == stays
    assert (tmp_path / "outputs" / "README.md").exists()
    assert cache.exists() == (target != "clean")
