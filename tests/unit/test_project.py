"""The project: imports, what it needs, its version, what `make` removes; its linear algebra, in one thread."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import crackgrow
import crackgrow.linear
from crackgrow import blas
from crackgrow.blas import THREAD_SETTINGS, one_thread, single_threaded
from crackgrow.run import loop
from tests.scenes import make_run, shipped_case

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "crackgrow"
LAYERS = (
    "errors", "arrays", "ragged", "blas", "limits", "vectors", "compiled", "case", "geometry", "cover", "approximation",
    "quadrature", "linear", "solid", "contact", "fracture", "accuracy", "run", "results", "plan", "study", "api", "cli",
)  # fmt: skip
RESULTS_MAY_READ = (
    "crackgrow", "crackgrow.errors", "crackgrow.arrays", "crackgrow.case", "crackgrow.run.warning_causes",
    "crackgrow.run.result", "crackgrow.results",
)  # fmt: skip
COMPRESSION = str(ROOT / "cases" / "compression30.yaml")
ENTRIES = ("__init__.py", "__main__.py")  # the concept map with its lazy names, and python -m


@cache
def imported(source: str, package: str) -> list[str]:
    """Dotted names that a module of `package` imports, also inside functions and under TYPE_CHECKING."""
    found: list[str] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*parents, *([node.module] if node.module else [])])
            found += [f"{base}.{alias.name}" for alias in node.names]
    return found


def offences(layer: str, source: str, package: str) -> list[str]:
    """Imports of a module in `layer` that break the order, or go past the door of the direct solver."""
    own = [name for name in imported(source, package) if name.split(".")[0] == "crackgrow"]
    if layer == "results":
        broken = [name for name in own if not any(allowed_in_results(name, home) for home in RESULTS_MAY_READ)]
    else:
        below = LAYERS[: LAYERS.index(layer) + 1]
        broken = [name for name in own if name.count(".") and name.split(".")[1] not in (*below, "__version__")]
    solver = [name for name in own if name.startswith("crackgrow.linear") and layer != "linear"]
    return broken + [n for n in solver if n.removeprefix("crackgrow.linear.") not in crackgrow.linear.__all__]


def allowed_in_results(name: str, home: str) -> bool:
    if home == "crackgrow":  # the version alone
        return name in ("crackgrow", "crackgrow.__version__")
    return name == home or name.startswith(f"{home}.")


def test_modules_import_from_their_layer_and_below_and_the_direct_solver_has_one_door() -> None:
    offenders = {}
    for path in sorted(path for path in PACKAGE.rglob("*.py") if str(path.relative_to(PACKAGE)) not in ENTRIES):
        parts, source = path.relative_to(PACKAGE).with_suffix("").parts, path.read_text(encoding="utf-8")
        package = ".".join(["crackgrow", *parts[:-1]])
        found = offences(parts[0], source, package) if parts[0] in LAYERS else ["no known layer"]
        offenders |= {str(path.relative_to(PACKAGE)): found} if found else {}
    assert offenders == {}
    assert offences("solid", "def f():\n    from ..fracture import tips", "crackgrow.solid")
    assert offences("results", "from crackgrow.run import grow", "crackgrow.results")
    assert offences("solid", "from crackgrow.linear.fronts import fronts_of", "crackgrow.solid")


NUMBERS = ["numpy", "scipy", "shapely", "yaml"]
SOLVING = ["numba", "llvmlite", "scipy", "pandas", "pyvista", "vtkmodules", "matplotlib", "PIL"]
LOADED = [
    ([["--version"]], [*NUMBERS, "argparse"]),  # it takes no longer than Python itself, nearly
    ([["--help"], ["run", "--help"], ["completion", "bash"]], NUMBERS),
    ([["check", COMPRESSION], ["explain", "friction"], ["list"]], SOLVING),
    pytest.param([["report", "FOLDER"]], SOLVING[:-2], marks=pytest.mark.physics),  # matplotlib draws the scene
    pytest.param(
        [["run", COMPRESSION, "--out", "FOLDER", "--set", "growth.steps=0", "--set", "numerics.spacing=3"]],
        ["pyvista", "vtkmodules", "pandas", "matplotlib.pyplot", "dask", "scipy.optimize", "scipy.spatial"],
        marks=pytest.mark.physics,
    ),
]
"""Commands, and modules that they do not load: of a run with frames, figures and a report, as it writes them."""


@pytest.mark.parametrize(("commands", "heavy"), LOADED, ids=str)
def test_nothing_is_loaded_that_is_not_used(commands: list[list[str]], heavy: list[str], tmp_path: Path) -> None:
    """Numba and SciPy take as long to load as all of the rest of a check; elsewhere there is nothing of POSIX."""
    if ["report", "FOLDER"] in commands:
        make_run(tmp_path, ["growth.steps=0"])
    code = """
import contextlib, io, sys
sys.modules |= dict.fromkeys(("fcntl", "resource"))
from crackgrow.cli import main
for words in COMMANDS:
    with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()) as told:
        assert not main(words)
    assert told.getvalue()
sys.exit(" ".join(name for name in HEAVY if name in sys.modules) or 0)
"""
    code = code.replace("COMMANDS", str(commands)).replace("HEAVY", str(heavy)).replace("FOLDER", str(tmp_path))
    words = [sys.executable, "-W", "ignore:only soft file lock", "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT, check=False)
    assert (done.returncode, done.stderr) == (0, "")


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
NAMES = {"PIL": "pillow", "yaml": "pyyaml"}  # of packages that are imported by another one
THROUGH_OTHERS = {"h5py"}  # meshio has it as an extra, and imports it whenever it reads or writes XDMF


def test_all_that_is_imported_is_declared_with_the_oldest_version_that_will_do() -> None:
    optional = PROJECT["optional-dependencies"]
    declared = [*PROJECT["dependencies"], *optional["sweep"], *optional["maps"]]
    assert all(re.fullmatch(r"[a-z][a-z0-9]*>=[\d.]+", text) for text in declared)
    sources = [path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")]
    found = {name.split(".")[0] for source in sources for name in imported(source, "crackgrow")}
    others = {NAMES.get(name, name) for name in found - {"crackgrow", *sys.stdlib_module_names}}
    assert {text.split(">=")[0] for text in declared} == others | THROUGH_OTHERS
    assert f'".[{",".join(sorted(optional))}]"' in (ROOT / "Makefile").read_text(encoding="utf-8")  # of `make lock`
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


CASE = "compression30"


def threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def unset(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blas, "_settled", False)


@pytest.mark.physics
def test_a_case_is_solved_with_one_thread_and_the_user_s_are_back_between_its_steps(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    inside: list[set[int]] = []
    load = loop.load

    def looking(*arguments: object, **more: object) -> object:
        inside.append(threads())
        return load(*arguments, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(loop, "load", looking)
    case = shipped_case(CASE, ["numerics.spacing=4", "growth.steps=1"])
    with threadpool_limits(2, "blas"):
        crackgrow.solve(case)
        assert threads() == {2}
        run = crackgrow.run_case(case, tmp_path)
        run.solution(0)
        assert threads() == {2}
        for _ in crackgrow.grow(case):
            assert threads() == {2}
    assert inside
    assert all(found == {1} for found in inside)


def test_what_the_user_has_set_stays() -> None:
    code = (
        "import numpy; from threadpoolctl import threadpool_info; from crackgrow import blas; blas.one_thread()\n"
        "with blas.single_threaded(): print({pool['num_threads'] for pool in threadpool_info()})"
    )
    environment = {name: value for name, value in os.environ.items() if name not in THREAD_SETTINGS}
    for settings, expected in (({"OPENBLAS_NUM_THREADS": "2"}, "{2}\n"), ({}, "{1}\n")):
        command = [sys.executable, "-c", code]
        done = subprocess.run(command, env=environment | settings, capture_output=True, text=True, check=True)
        assert done.stdout == expected


def test_settings_that_come_too_late_are_not_taken_for_the_user_s(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of the command line in a program that has loaded numpy, and of Dask for the workers that it starts.

    Runs after them had several threads, and other bits than those of the command line.
    """
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    with threadpool_limits(2, "blas"):
        one_thread()
        assert "OPENBLAS_NUM_THREADS" not in os.environ
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
        with single_threaded():
            assert threads() == {1}
        assert threads() == {2}


@pytest.mark.physics
def test_routines_of_blas_are_those_of_kernels_without_compilation() -> None:
    """The direct solver calls all of them."""
    some = ["-k", "(superlu or repeat_each_other or is_that_of_solutions) and 5"]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/unit/linear", *some]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stdout
