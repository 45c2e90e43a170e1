"""The wheel: it holds all files of the package, and runs a scene where there is nothing but it and what it asks for."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import venv
import zipfile
from collections.abc import Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NO_PART = ("__pycache__", "*.pyc")

pytestmark = pytest.mark.slow


def run(command: Sequence[str | Path], folder: Path) -> str:
    """Run a command to its end, without what would lead Python elsewhere, and return what it says."""
    alone = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        [str(word) for word in command], cwd=folder, env=alone, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy: nothing that an earlier build has left gets into it."""
    folder = tmp_path_factory.mktemp("build")
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, folder / name)
    shutil.copytree(ROOT / "crackgrow", folder / "crackgrow", ignore=shutil.ignore_patterns(*NO_PART))
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps"]
    run([*pip, "--wheel-dir", "dist", "."], folder)
    (found,) = (folder / "dist").glob("crackgrow-*.whl")
    return found


@pytest.fixture(scope="module")
def program(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Programs of a new environment with the wheel and what it declares that it needs, in the pinned versions."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    pinned = ["--constraint", ROOT / ".requirements.lock"]
    run([folder / "bin/python", "-m", "pip", "install", "--quiet", *pinned, wheel], folder)
    return folder / "bin"


def test_wheel_holds_every_file_of_the_package(wheel: Path) -> None:
    package = ROOT / "crackgrow"
    files = {path.relative_to(ROOT).as_posix() for path in package.rglob("*") if path.is_file()}
    wanted = {name for name in files if "__pycache__" not in name}
    packed = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert packed == wanted


def test_the_program_and_the_python_interface_work_outside_of_the_repository(program: Path, tmp_path: Path) -> None:
    shutil.copy(ROOT / "cases/compression30.yaml", tmp_path)
    said = run([program / "crackgrow", "run", "compression30.yaml", "--set", "growth.steps=2"], tmp_path)
    assert "completed: all 2 growth steps are done" in said
    summary = json.loads((tmp_path / "outputs/compression30/summary.json").read_text())
    assert summary["status"] == "completed"
    assert summary["git_commit"] is None  # the installed program, not a checkout
    assert (tmp_path / "outputs/compression30/compression30.pvd").is_file()
    assert (tmp_path / "outputs/compression30/report.html").is_file()
    run([program / "crackgrow", "new", "rock"], tmp_path)
    assert "crack flaw" in run([program / "crackgrow", "check", "rock.yaml"], tmp_path)
    code = (
        "import crackgrow; case = crackgrow.load_case('compression30.yaml', ['numerics.spacing=3']); "
        "print(crackgrow.__file__); print(len(crackgrow.solve(case).tips))"
    )
    home, n_tips = run([program / "python", "-c", code], tmp_path).splitlines()
    assert Path(home).is_relative_to(program.parent)
    assert n_tips == "2"
