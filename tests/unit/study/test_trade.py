"""Whether a setting is good enough: what is run, what runs tell of each other, and real, short trades."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.study.findings import Findings, findings
from crackgrow.study.runs import Table, Values
from crackgrow.study.trade import trade_text
from crackgrow.study.trade_plan import OWN, TradePlan, plan_trade
from tests.scenes import rows_of

pytestmark = pytest.mark.physics

CASES = Path(__file__).parents[3] / "cases"
HALF = "half increment"
SIZES = {"draft": 4e-3, "standard": 2e-3, "fine": 1e-3, "own": 1.5e-3, HALF: 1.5e-3}
COST: Values = {"status": "completed", "reason": "done", "n_dofs": 100, "cpu_seconds": 1.0, "peak_memory_mb": 300.0}
STEPS = "step,n_dofs,load_factor,load_displacement\n"
TIPS = "step,crack,tip,K_I,K_II,K_I_error,K_II_error,cell_size,advanced\n"

Order = Sequence[str]
"""Tips in the order in which they advance."""


def folder(made: Path, K: Callable[[float, int], float], order: Order, bend: float, size: float) -> Path:
    """A crack along x with K_I by the side of the cells and the state, whose end grows along x and bends upwards.

    Of an `order` what is no tip is a crack that starts.
    """
    made.mkdir(parents=True)
    grown = {"start": 0, "end": 0}
    steps, tips, events = [], [], []
    for step in range(len(order) + 1):
        steps.append(f"{step},100,{1.0 + size},{1e-3}\n")
        advancing = order[step] if step < len(order) else ""
        state = sum(grown.values())
        for tip in grown:
            flag = "true" if tip == advancing else "false"
            tips.append(f"{step},flaw,{tip},{K(size, state)},0.0,7e4,7e4,{size},{flag}\n")
        if advancing in grown:
            grown[advancing] += 1
        elif advancing:
            events.append(f"{step + 1},initiation,{advancing},start,0.0,0.0,crack 'flaw' (shear)\n")
    (made / "steps.csv").write_text(STEPS + "".join(steps))
    (made / "tips.csv").write_text(TIPS + "".join(tips))
    (made / "events.csv").write_text("step,kind,crack,tip,x,y,met\n" + "".join(events))
    n, m = grown["start"], grown["end"]
    rows = [(-0.01 - 0.002 * k, 0.0, k) for k in range(n, 0, -1)] + [(-0.01, 0.0, 0), (0.01, 0.0, 0)]
    rows += [(0.01 + 0.002 * k, bend * k, k) for k in range(1, m + 1)]
    lines = [f"flaw,{i},{x},{y},{step}\n" for i, (x, y, step) in enumerate(rows)]
    (made / "paths.csv").write_text("crack,vertex,x,y,step\n" + "".join(lines))
    (made / "case.yaml").write_text("title: a crack\n")
    (made / "summary.json").write_text(json.dumps({"status": "completed", "stop_reason": "done"}))
    return made


def converged(size: float, state: int) -> float:
    """1 MPa sqrt(m) and 2 % more on cells of 1 mm, with order 1; more in later states."""
    return 1e6 * (1 + state) * (1.0 + 20.0 * size)


def study(
    parent: Path,
    *,
    K: Callable[[float, int], float] = converged,
    orders: dict[str, Order] | None = None,
    bends: dict[str, float] | None = None,
    sizes: dict[str, float] | None = None,
    case: str = "compression30",
    tolerance: float = 0.05,
) -> Findings:
    orders, bends, sizes = orders or {}, bends or {}, {**SIZES, **(sizes or {})}
    increments = ("half",) if bends else ("none",)
    given = {"overrides": ("numerics.spacing=1.5",), "tolerance": tolerance, "increments": increments}
    plan = plan_trade(CASES / f"{case}.yaml", parent, **given)  # type: ignore[arg-type]
    for run in plan.study.runs:
        name = run.name
        folder(run.folder, K, orders.get(name, ("end", "start")), bends.get(name, 0.0), sizes[name])
    return findings(plan)


def told(found: Findings) -> str:
    study = found.plan.study
    return trade_text(found, Table(study, {run.number: dict(COST) for run in study.runs}))


def test_K_tends_to_its_limit_and_every_setting_has_its_error(tmp_path: Path) -> None:
    found = study(tmp_path)
    assert [(q.step, q.tip, q.name) for q in found.quantities[:4]] == [
        (0, "start", "K_I"), (0, "start", "K_II"), (0, "end", "K_I"), (0, "end", "K_II")
    ]  # fmt: skip
    last = found.quantities[-2]
    assert (last.step, last.name) == (2, "K_I")
    assert last.limit.order == pytest.approx(1.0, rel=1e-6)
    assert last.limit.value == pytest.approx(3e6, rel=1e-6)
    size = 3e6 * 1.02  # the largest K of the step on the finest cells
    assert last.error("own") == pytest.approx(3e6 * 0.03 / size, rel=1e-6)
    assert found.error("draft") == pytest.approx(3e6 * 0.08 / size, rel=1e-6)
    assert found.good_enough
    assert not replace(found, plan=replace(found.plan, tolerance=0.02)).good_enough


@pytest.mark.parametrize(("order", "steps"), [
    (("start", "end"), [0, 2]),  # the tips in the other order: the step between is no state of the other runs
    (("end", "new1"), [0, 1]),  # a state in which a crack has started is another one
])  # fmt: skip
def test_states_are_told_apart_by_how_often_tips_have_grown_not_by_their_step(
    order: tuple[str, str], steps: list[int], tmp_path: Path
) -> None:
    found = study(tmp_path, orders={"fine": order})
    assert sorted({quantity.step for quantity in found.quantities}) == steps
    assert found.left_out == 2
    assert "2 more states" in told(found)


def test_a_verdict_names_the_coarsest_setting_that_is_good_enough(tmp_path: Path) -> None:
    found = study(tmp_path, tolerance=0.021)
    text = told(found)
    assert "not good enough" in text
    assert "numerics.accuracy: fine is within it" in text
    assert "smaller cells are needed" in told(replace(found, plan=replace(found.plan, tolerance=0.001)))


def test_a_path_that_moves_by_more_than_twice_the_tolerance_is_not_good_enough(tmp_path: Path) -> None:
    """Of 2 mm that the end grows; K is within the tolerance in both."""
    found = study(tmp_path / "near", bends={"own": 1.8e-4, HALF: 1.8e-4})
    assert found.moves["finer cells"].share == pytest.approx(0.09, rel=5e-3)
    assert found.good_enough
    assert "good enough: " in told(found)
    assert "finer cells would move the path by 9 % of what has grown, within 10 %" in told(found)
    for name, bends in (("cells", {"own": 2.5e-4, HALF: 2.5e-4}), ("increment", {"own": 0.0, HALF: 2.5e-4})):
        other = study(tmp_path / name, bends=bends)
        assert not other.good_enough
        assert other.error("own") == found.error("own")
        assert "not good enough for paths" in told(other)


def test_equal_cells_are_not_taken_for_convergence(tmp_path: Path) -> None:
    """K is the same since the cells are: what the run itself states counts, 70 kPa sqrt(m)."""
    same = dict.fromkeys(SIZES, 1e-3)
    found = study(tmp_path, sizes=same)
    assert found.error("own") == pytest.approx(7e4 / converged(1e-3, 0), rel=1e-6)
    assert "the same cells" in told(found)


FLAW = CASES / "compression30.yaml"
EXACT = 5.9363e6 * 1e-3**0.5
"""Pa sqrt(m), K_I of edge_tension by an independent code, good to 0.01 %."""

GIVEN = ("numerics.spacing=1.5",)


def plan(folder: Path, **asked: object) -> TradePlan:
    return plan_trade(FLAW, folder, **asked)  # type: ignore[arg-type]


def test_the_own_setting_is_one_of_the_three_where_it_is_the_same(tmp_path: Path) -> None:
    assert plan(tmp_path).own == "standard"
    assert plan(tmp_path, overrides=("numerics.accuracy=fine",)).own == "fine"
    own = plan(tmp_path, overrides=GIVEN)  # its spacing is given
    assert own.own == OWN
    spacings = [run.case.numerics.spacing for run in own.study.runs if run.case]
    assert spacings[3:] == [1.5e-3, 1.5e-3]  # with half the increment, too


def test_targets_are_settings_too(tmp_path: Path) -> None:
    found = plan(tmp_path, settings=("3%", "1 %", "0.003", "0.002"))
    targets = [run.case.numerics.target for run in found.study.runs if run.case]
    assert targets[:4] == [0.03, 0.01, 0.003, 0.002]
    same = plan(tmp_path, overrides=("numerics.accuracy=1 %",), settings=("3%", "1%", "0.3%"))
    assert same.own == "1%"


@pytest.mark.parametrize(("increments", "steps"), [
    (("half",), [6]), (("1.5 mm", "1", "0.3"), [4, 6, 20]), (("none",), [])
])  # fmt: skip
def test_increments_grow_by_the_same_length(tmp_path: Path, increments: tuple[str, ...], steps: list[int]) -> None:
    """Of three increments of 2 mm; the longest first."""
    found = plan(tmp_path, steps=3, increments=increments)
    grown = [run.case.growth.steps for run in found.study.runs[3:] if run.case and run.case.growth]
    assert grown == steps
    assert len(found.increments) == len(steps)
    assert plan(tmp_path, steps=0).increments == ()


@pytest.mark.physics
def test_an_edge_crack_converges_to_its_K(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    words = ["trade", str(CASES / "edge_tension.yaml"), "--json", "--out", str(out)]
    assert cli.main(words) == 0
    record = json.loads(capsys.readouterr().out)
    K_I = [row for row in record["rows"] if row["quantity"] == "K_I"]
    assert [row["setting"] for row in K_I] == ["draft", "standard", "fine"]
    for row in K_I:
        assert row["extrapolated"] == pytest.approx(EXACT, rel=2e-3)
        assert abs(row["value"] - EXACT) <= 2.0 * row["error"] * EXACT + 2e-4 * EXACT
    assert record["good_enough"]
    assert {path.name for path in out.iterdir()} == {
        "convergence.csv", "draft", "fine", "standard", "trade.csv", "trade.png"
    }  # fmt: skip
    rows = rows_of(out / "trade.csv")
    assert [float(row["error"]) for row in rows] == [row["error"] for row in record["runs"]]
    assert all(float(row["cpu_seconds"]) > 0.0 and float(row["peak_memory_mb"]) > 50.0 for row in rows)
