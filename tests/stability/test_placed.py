"""What must not change where a case is placed otherwise; of trials: one bad row ends itself alone, verdicts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.case.model import Case, ContactSupport, EdgeTraction
from crackgrow.errors import SolveError
from crackgrow.run.caution import Cause, Caution
from tests.stability.extremes.trial import Row, Trial, evaluate
from tests.stability.placed import mirrored, moved, placed, scaled, turned
from tests.stability.solved import Solved, everything, overall, solved

ROOT = Path(__file__).parents[2]
CASES = ROOT / "cases"


@pytest.fixture(scope="module")
def flaw() -> Solved:
    return solved(coarse())


def coarse() -> Case:
    return load_case(CASES / "compression30.yaml", ["numerics.spacing=3", "growth.tip_stress.radius=2"])


def trial(solve: Callable[[], Solved], deviation: float, plain: Solved, refusable: bool = False) -> Trial:
    return Trial("axis", "1", "itself", 1e-3, solve, lambda _: deviation, lambda: plain, refusable)


def refuses() -> Solved:
    raise SolveError("no such luck")


def crashes() -> Solved:
    raise ZeroDivisionError("a bug")


def row(
    deviation: float = 1e-4, status: str = "solved", refusable: bool = False, axis: str = "a", value: str = "1"
) -> Row:
    return Row(axis, value, "itself", deviation, 1e-3, 1e5, 1, 1e-15, status, refusable, "why | not", 0.5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("found", "verdict"),
    [
        (row(), "yes"),
        (row(1e-4, "warned"), "yes"),
        (row(2e-3), "NO"),
        (row(2e-3, "warned"), "said"),
        (row(float("nan")), "NO"),
        (row(float("nan"), "warned"), "said"),
        (row(float("nan"), "refused"), "NO"),
        (row(float("nan"), "refused", refusable=True), "said"),
        (row(0.0, "crashed", refusable=True), "NO"),
    ],
)
def test_verdict(found: Row, verdict: str) -> None:
    assert found.verdict == verdict


def test_row_tells_how_its_scene_was_solved(flaw: Solved) -> None:
    found = evaluate(trial(lambda: flaw, 1e-4, flaw))
    assert (found.status, found.reason, found.iterations, found.verdict) == ("solved", "", 1, "yes")
    assert 1e5 < found.condition < 1e9
    assert 0.0 < found.residual < 1e-12


def test_warnings_that_the_usual_scene_does_not_have_are_news(flaw: Solved) -> None:
    warned = replace(
        flaw, result=replace(flaw.result, cautions=(Caution(Cause.NOTE, "old"), Caution(Cause.NOTE, "new")))
    )
    usual = replace(flaw, result=replace(flaw.result, cautions=(Caution(Cause.NOTE, "old"),)))
    found = evaluate(trial(lambda: warned, 1.0, usual))
    assert (found.status, found.reason, found.verdict) == ("warned", "new", "said")


def test_what_is_raised_ends_its_own_row_alone(flaw: Solved) -> None:
    refused = evaluate(trial(refuses, 0.0, flaw))
    assert (refused.status, refused.reason, refused.verdict, refused.iterations) == (
        "refused",
        "no such luck",
        "NO",
        -1,
    )
    crashed = evaluate(trial(crashes, 0.0, flaw))
    assert (crashed.status, crashed.reason, crashed.verdict) == ("crashed", "ZeroDivisionError: a bug", "NO")


@pytest.mark.parametrize("name", ["compression30", "block_rigid", "interface_friction01", "junction_static"])
@pytest.mark.parametrize(
    "placement", [turned(90.0), turned(180.0), mirrored(), moved(3.0, -2.0)], ids=["90", "180", "mirror", "moved"]
)
def test_placed_scene_is_the_same_scene(name: str, placement: object, flaw: Solved) -> None:
    case = coarse() if name == "compression30" else load_case(CASES / f"{name}.yaml")
    plain = flaw if name == "compression30" else solved(case)
    assert overall(solved(placed(case, placement), placement), plain) < 1e-3  # type: ignore[arg-type]


def test_other_units_are_the_same_to_round_off_and_other_loads_are_not(flaw: Solved) -> None:
    placement = scaled(1e-3, 1e6, 1e-4)
    case = placed(coarse(), placement)
    assert everything(solved(case, placement), flaw) < 1e-9
    more = replace(case, loads=tuple(_doubled(load) for load in case.loads))
    assert overall(solved(more, placement), flaw) > 0.5


def _doubled(load: object) -> EdgeTraction:
    assert isinstance(load, EdgeTraction)
    return replace(load, traction=(2.0 * load.traction[0], 2.0 * load.traction[1]))


def test_mirror_keeps_rock_on_the_left_and_edges_under_their_names() -> None:
    case = placed(load_case(CASES / "block_foundation.yaml"), mirrored())
    for body in case.bodies:
        x, y = body.outline.T
        assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0.0
    side = next(load.region for load in case.loads if isinstance(load, EdgeTraction) and load.region.edge == "right")
    ends = case.bodies[0].outline[[side.sides[0], (side.sides[0] + 1) % 4]]
    assert ends[:, 0].tolist() == [-2.0, -2.0]
    bottom = next(s for s in placed(load_case(CASES / "block_rigid.yaml"), mirrored()).supports)
    assert isinstance(bottom, ContactSupport)


def test_single_components_cannot_be_turned_askew() -> None:
    with pytest.raises(ValueError, match="right angles"):
        placed(coarse(), turned(30.0))
