"""Imports go up the layers only; results read what a run gives, never the solver."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import crackgrow.direct

ROOT = Path(__file__).resolve().parents[2] / "crackgrow"
LAYERS = (
    "errors", "arrays", "ragged", "blas", "limits", "vectors", "case", "geometry", "cover", "approximation",
    "quadrature", "direct", "solid", "contact", "fracture", "accuracy", "run", "results", "plan", "study", "api", "cli",
)  # fmt: skip
RESULTS_MAY_READ = (
    "crackgrow", "crackgrow.errors", "crackgrow.arrays", "crackgrow.case", "crackgrow.run.caution",
    "crackgrow.run.result", "crackgrow.results",
)  # fmt: skip
ENTRIES = ("__init__.py", "__main__.py")  # the concept map with its lazy names, and python -m


def modules() -> list[Path]:
    return sorted(path for path in ROOT.rglob("*.py") if str(path.relative_to(ROOT)) not in ENTRIES)


def imported(source: str, package: str) -> Iterator[str]:
    """Dotted names that a module of `package` imports, also inside functions and under TYPE_CHECKING."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*parents, *([node.module] if node.module else [])])
            yield from (f"{base}.{alias.name}" for alias in node.names)


def faults(layer: str, source: str, package: str) -> list[str]:
    """Imports of a module in `layer` that break the order."""
    own = [name for name in imported(source, package) if name.split(".")[0] == "crackgrow"]
    if layer == "results":
        return [name for name in own if not any(allowed_in_results(name, home) for home in RESULTS_MAY_READ)]
    below = LAYERS[: LAYERS.index(layer) + 1]
    return [name for name in own if name.count(".") and name.split(".")[1] not in (*below, "__version__")]


def allowed_in_results(name: str, home: str) -> bool:
    if home == "crackgrow":  # the version alone
        return name in ("crackgrow", "crackgrow.__version__")
    return name == home or name.startswith(f"{home}.")


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(ROOT)))
def test_module_imports_from_its_layer_and_below(path: Path) -> None:
    parts = path.relative_to(ROOT).with_suffix("").parts
    package = ".".join(["crackgrow", *parts[:-1]])
    assert parts[0] in LAYERS, f"{parts[0]} is no known layer"
    assert faults(parts[0], path.read_text(encoding="utf-8"), package) == []


def behind_the_door(source: str, package: str) -> list[str]:
    """What a module of another package imports of the direct solver besides its door."""
    own = [name for name in imported(source, package) if name.startswith("crackgrow.direct")]
    return [name for name in own if name.removeprefix("crackgrow.direct.") not in crackgrow.direct.__all__]


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(ROOT)))
def test_the_direct_solver_has_one_door(path: Path) -> None:
    package = ".".join(["crackgrow", *path.relative_to(ROOT).parts[:-1]])
    if package != "crackgrow.direct":
        assert behind_the_door(path.read_text(encoding="utf-8"), package) == []


def test_what_is_behind_the_door_is_found() -> None:
    assert behind_the_door("from crackgrow.direct.fronts import fronts_of", "crackgrow.solid")
    assert behind_the_door("import crackgrow.direct.matrix", "crackgrow.solid")
    assert not behind_the_door("from crackgrow.direct import factorize, Places", "crackgrow.solid")


@pytest.mark.parametrize(
    ("layer", "source"),
    [
        ("solid", "from crackgrow.contact import law"),
        ("solid", "import crackgrow.run.loop"),
        ("solid", "def f():\n    from ..fracture import tips"),
        ("case", "from crackgrow.geometry.polyline import length"),
        ("errors", "from crackgrow import case"),
        ("run", "from crackgrow.results import tables"),
        ("results", "from crackgrow.run import grow"),
        ("results", "from crackgrow.solid import elasticity"),
        ("results", "from crackgrow import grow"),
    ],
)
def test_import_up_the_layers_is_found(layer: str, source: str) -> None:
    assert faults(layer, source, f"crackgrow.{layer}")


@pytest.mark.parametrize(
    ("layer", "source"),
    [
        ("solid", "from crackgrow.case.model import Case\nimport numpy\nfrom . import stiffness"),
        ("results", "from crackgrow import __version__\nfrom crackgrow.run.result import StepResult"),
        ("cli", "import crackgrow\nfrom crackgrow.results.log import step_line"),
    ],
)
def test_import_down_the_layers_is_allowed(layer: str, source: str) -> None:
    assert faults(layer, source, f"crackgrow.{layer}") == []


def test_importing_the_package_and_the_command_line_is_cheap() -> None:
    heavy = ("numpy", "scipy", "matplotlib", "pyvista", "vtkmodules", "shapely")
    code = f"import sys, crackgrow.cli; sys.exit(' '.join(m for m in {heavy} if m in sys.modules) or 0)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT.parent, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_run_loads_nothing_heavy_that_it_does_not_use(tmp_path: Path) -> None:
    """With frames, figures and report, as it writes them by default."""
    heavy = ("pyvista", "pandas", "scipy.optimize", "scipy.stats", "matplotlib.pyplot", "dask")
    arguments = ["run", str(ROOT.parent / "cases" / "compression30.yaml"), "--out", str(tmp_path), "--quiet"]
    arguments += ["--set", "growth.steps=0", "--set", "numerics.spacing=3"]
    code = f"import sys, crackgrow.cli; crackgrow.cli.main({arguments})"
    code += f"; sys.exit(' '.join(m for m in {heavy} if m in sys.modules) or 0)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT.parent, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert {"frames", "figures", "report.html"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.parametrize("words", [["--version"], ["--help"], ["run", "--help"], ["completion", "bash"]])
def test_what_needs_no_numbers_loads_no_numpy(words: list[str]) -> None:
    """The version not even the commands: it takes no longer than Python itself, nearly."""
    heavy = ("numpy", "scipy", "shapely", "yaml", *(["argparse"] if words == ["--version"] else []))
    code = f"""
import contextlib, io, sys
from crackgrow.cli import main
with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()) as told:
    main({words})
assert told.getvalue()
sys.exit(' '.join(m for m in {heavy} if m in sys.modules) or 0)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT.parent, check=False)
    assert (done.returncode, done.stderr) == (0, "")
