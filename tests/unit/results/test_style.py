"""Pictures are the same whatever the user's settings of matplotlib are, and texts of a case are no formulas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import pytest

from crackgrow.case import Case
from crackgrow.plan.sizes import squares_of
from crackgrow.results import figures
from crackgrow.results.drawing import draw_scene
from crackgrow.results.style import own_style
from crackgrow.results.summary import load_point
from tests.properties.broken_off import ENVIRONMENT, command, finished
from tests.scenes import shipped_case
from tests.unit.results.synthetic import make_case, make_paths, make_result

NO_FORMULA = r"$\frac{1}{0$ & <b> $_$"
ODD = {"font.family": ["cursive"], "font.size": 30.0, "lines.linewidth": 9.0, "figure.facecolor": "black",
       "axes.grid": True, "savefig.dpi": 20.0, "text.usetex": True, "figure.autolayout": True}  # fmt: skip
DRAWN: dict[str, Callable[[Path], None]] = {
    "paths": lambda path: figures.draw_paths(path, odd_case(), make_paths(2)),
    "sigma_1": lambda path: figures.draw_sigma_1(path, odd_case(), make_result(1)),
    "contact": lambda path: figures.draw_contact(path, odd_case(), make_result(1)),
    "load curve": lambda path: figures.draw_load_curve(
        path, odd_case(), [load_point(make_result(k, load_factor=1.0 + k)) for k in range(3)]
    ),
    "scene": lambda path: draw_scene(path, odd_case(), squares_of(odd_case())),
}


def odd_case() -> Case:
    case = shipped_case("compression30", ["numerics.spacing=3"])
    crack = replace(case.cracks[0], name=NO_FORMULA)
    return replace(make_case(), title=NO_FORMULA, bodies=case.bodies, cracks=(crack,))


@pytest.mark.parametrize("name", DRAWN)
def test_pictures_take_no_notice_of_settings_and_know_no_formulas(name: str, tmp_path: Path) -> None:
    DRAWN[name](tmp_path / "usual.png")
    with mpl.rc_context(ODD):
        DRAWN[name](tmp_path / "odd.png")
        assert {key: mpl.rcParams[key] for key in ODD} == ODD
    assert (tmp_path / "odd.png").read_bytes() == (tmp_path / "usual.png").read_bytes()


def test_settings_are_the_user_s_again_after_an_error() -> None:
    with mpl.rc_context(ODD):
        with pytest.raises(ValueError, match="no picture"), own_style():
            raise ValueError("no picture")
        assert {key: mpl.rcParams[key] for key in ODD} == ODD


def test_a_run_and_its_pictures_are_made_in_any_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "matplotlibrc").write_text("lines.linewidth: thick\nno such key: 1\n")
    monkeypatch.setitem(ENVIRONMENT, "MPLBACKEND", "of_another_program")
    monkeypatch.setitem(ENVIRONMENT, "MATPLOTLIBRC", str(tmp_path / "matplotlibrc"))
    coarse = ("numerics.spacing=3", "growth.steps=1", f"title='{NO_FORMULA}'")
    run = finished(command("compression30", coarse, tmp_path / "out"))
    assert (run.returncode, run.stderr) == (0, "")
    program = command("compression30", coarse, tmp_path)[:3]
    for words in (["render", tmp_path / "out"], ["report", tmp_path / "out"]):
        done = finished([*program, *map(str, words)])
        assert (done.returncode, done.stderr) == (0, "")
    picture = tmp_path / "scene.svg"
    done = finished([*program, "check", str(tmp_path / "out" / "case.yaml"), "--picture", str(picture)])
    assert (done.returncode, done.stderr) == (0, "")
    assert "figures/path.png" in {str(path.relative_to(tmp_path / "out")) for path in (tmp_path / "out").rglob("*")}
