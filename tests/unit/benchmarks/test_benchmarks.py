"""The tools of the benchmarks: what they fit, compare and hold steps against. Nothing here asserts a duration."""

from __future__ import annotations

import cProfile
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.cover.lattice import place_lattice
from crackgrow.run.configuration import Configuration
from crackgrow.run.load_level import LoadLevel
from tests.benchmarks import scenes
from tests.benchmarks.compare import changes, comparison_text, load_baseline, store_baseline
from tests.benchmarks.fits import exponent, exponents, same_program
from tests.benchmarks.floor import condensation, floor, from_nothing
from tests.benchmarks.measure import measured
from tests.benchmarks.paths import ROOT
from tests.benchmarks.profile import functions
from tests.benchmarks.record import PHASES, Environment, Measurement, append, latest, ratios, read
from tests.benchmarks.report import write_report
from tests.benchmarks.tables import write_part

HERE = Environment("0", "abc", "3", "2", "1", "a processor")
STEP = Measurement(
    part="runs", run="a", n_dofs=1000, n_contact=3, steps=4, first=0.5, step=0.4, step_wall=0.4, cover=0.05,
    assembly=0.1, factorize=0.15, contact=0.05, criterion=0.04, output=0.01, floor_factorize=0.1, floor_solve=0.1,
    condensation=0.05, yardstick=0.05, peak_MB=100.0, environment=HERE,
)  # fmt: skip


def configuration(case: str, *settings: str) -> Configuration:
    return from_nothing(load_case(ROOT / "cases" / f"{case}.yaml", settings))


@pytest.mark.parametrize("power", [0.5, 1.0, 1.5])
def test_the_exponent_of_a_power_is_found(power: float) -> None:
    sizes = np.array([1e4, 3e4, 1e5, 5e5])
    assert exponent(sizes, 7.0 * sizes**power) == pytest.approx(power, rel=1e-12)


def test_an_exponent_needs_positive_values() -> None:
    with pytest.raises(ValueError, match="positive"):
        exponent([1.0, 2.0], [1.0, 0.0])


def test_sizes_of_one_program_alone_are_fitted() -> None:
    def size(n: int, commit: str, step: float) -> Measurement:
        environment = replace(HERE, commit=commit)
        return replace(STEP, part="sizes", run=f"size {n}", n_dofs=n, step=step, factorize=0.0, environment=environment)

    new = [size(n, "new", 1e-3 * n) for n in (400, 100, 200)]
    same = same_program([STEP, size(10_000, "old", 1.0), *new])
    assert [m.n_dofs for m in same] == [100, 200, 400]
    positive = [replace(m, factorize=1e-6 * m.n_dofs**2) for m in same]
    found = exponents(positive)
    assert found["step"] == pytest.approx(1.0)
    assert found["factorize"] == pytest.approx(2.0)
    assert found["memory"] == pytest.approx(0.0, abs=1e-12)
    assert exponents(same[:2]) == {}


def test_the_comparison_finds_what_has_become_worse() -> None:
    before = {"a": {"step/floor": 2.0, "cover/floor": 1.0, "gone": 1.0}, "b": {"step/floor": 1.0}}
    now = {"a": {"step/floor": 2.6, "cover/floor": 1.2, "new": 9.0}, "c": {"step/floor": 9.0}}
    found = changes(now, before)
    assert [(c.run, c.ratio, c.worse) for c in found] == [("a", "step/floor", True), ("a", "cover/floor", False)]
    assert found[0].factor == pytest.approx(1.3)
    lines = comparison_text(found).splitlines()
    assert [("WORSE" in line) for line in lines[2:4]] == [True, False]
    assert lines[-1] == "1 of 2 ratios are more than 25 % worse"


@pytest.mark.parametrize("slower", ["step", "first", "assembly", "condensation", "floor_factorize", "peak_MB"])
def test_every_slowdown_makes_a_ratio_worse(slower: str) -> None:
    doubled = replace(STEP, **{slower: 2.0 * getattr(STEP, slower)})
    found = changes({"a": ratios(doubled)}, {"a": ratios(STEP)})
    assert any(change.worse for change in found)


def test_what_was_not_measured_has_no_ratio() -> None:
    static = ratios(replace(STEP, steps=1, condensation=math.nan, output=1e-5))
    assert not {"later/first step", "condensation/factorization", "output/floor", "command/yardstick"} & set(static)


def test_a_baseline_keeps_the_runs_that_were_not_measured(tmp_path: Path) -> None:
    path = tmp_path / "baseline.json"
    assert load_baseline(path) == {}
    store_baseline(path, {"a": {"x": 1.0}, "b": {"x": 2.0}})
    store_baseline(path, {"b": {"x": 3.0, "y": 1.0 / 3.0}})
    assert load_baseline(path) == {"a": {"x": 1.0}, "b": {"x": 3.0, "y": 0.3333}}


# the second one has a block that contact alone holds: the supports that stand in are part of the matrix
@pytest.mark.parametrize(
    ("case", "setting"), [("compression30", "numerics.spacing=3"), ("block_foundation", "title=x")]
)
def test_the_floor_is_the_solver_of_the_step(case: str, setting: str) -> None:
    step = configuration(case, setting)
    assert (step.contact.loose is not None) == (case == "block_foundation")
    u, _ = step.contact.system.solve(step.loads(LoadLevel(1.0)), step.held.given)
    np.testing.assert_array_equal(floor(step).u, u)
    assert np.abs(u).max() > 0.0


def test_the_condensation_is_the_response_of_the_rock() -> None:
    step = configuration("compression30", "cracks.flaw.contact.friction=0.3")
    _, jumps = condensation(step)
    n = step.faces.n
    assert jumps.shape == (2 * n, 2 * n)
    for column, operator in ((1, step.contact.gap_of), (n + 1, step.contact.slip_of)):
        traction = np.zeros(n)
        traction[1] = 1.0
        u, _ = step.contact.system.solve(operator.T @ (step.contact.weights * traction))
        expected = np.concatenate([step.contact.gap_of @ u, step.contact.slip_of @ u])
        np.testing.assert_allclose(jumps[:, column], expected, atol=1e-9 * np.abs(expected).max())


def test_a_measurement_is_whole() -> None:
    run = scenes.Run("coarse", "interface_friction04", ("numerics.spacing=0.1",), repeats=1)
    found = measured(run)
    step = configuration("interface_friction04", "numerics.spacing=0.1")
    assert (found.n_dofs, found.n_contact, found.steps) == (len(step.scaled), step.faces.n, 1)
    assert min(found.step, found.floor, found.condensation, found.yardstick) > 0.0
    assert sum(getattr(found, phase) for phase in PHASES) <= found.step
    assert found.peak_MB > 1.0
    assert math.isnan(found.K_II_error)


def test_the_history_gives_back_what_was_measured(tmp_path: Path) -> None:
    history = tmp_path / "history.csv"
    rows = [STEP, replace(STEP, run="b, with a comma"), replace(STEP, step=0.3, K_II_error=1e-3)]
    for row in rows:
        append(history, row)
    assert [ratios(row) for row in read(history)] == [ratios(row) for row in rows]
    assert [(row.run, row.step, row.environment) for row in latest(read(history))] == [
        ("a", 0.3, HERE), ("b, with a comma", 0.4, HERE)
    ]  # fmt: skip
    history.write_text("other,columns\n")
    with pytest.raises(ValueError, match="other columns"):
        append(history, STEP)


def test_reports_keep_what_is_written_by_hand(tmp_path: Path) -> None:
    path = tmp_path / "bench.md"
    path.write_text((ROOT / "tests" / "benchmarks" / "bench.md").read_text() + "\nby hand\n")
    write_report(path, [STEP])
    first = path.read_text()
    assert first.endswith("\nby hand\n")
    assert "| a " in first
    write_report(path, [STEP])
    assert path.read_text() == first
    with pytest.raises(ValueError, match="no part 'missing'"):
        write_part(path, "missing", "")


@pytest.mark.parametrize("n_dofs", [3_000, 500_000])
def test_the_spacing_gives_about_as_many_unknowns_as_asked_for(n_dofs: int) -> None:
    lattice = place_lattice(np.zeros(2), np.array([31.0, 55.0]), scenes.spacing_for(n_dofs), 2.0)
    assert 2 * np.prod(lattice.shape) + scenes.TIPS == pytest.approx(n_dofs, rel=0.1)


def test_runs_are_chosen_by_name_speed_and_size() -> None:
    assert {run.case for run in scenes.chosen(only="two_flaws")} == {"two_flaws"}
    assert scenes.chosen(only="no such run") == []
    assert all(run.quick for run in scenes.chosen(quick=True))
    assert scenes.chosen(quick=True)
    names = {large: {run.name for run in scenes.chosen(large=large)} for large in (False, True)}
    assert names[True] - names[False] == {"size 200000", "size 500000"}
    assert len({run.name for run in scenes.all_runs()}) == len(list(scenes.all_runs()))


def test_a_profile_names_public_functions_with_their_classes() -> None:
    profile = cProfile.Profile()
    profile.enable()
    configuration("compression30", "numerics.spacing=3")
    profile.disable()
    found = {function.name: function for function in functions(profile, n_steps=2)}
    assert found["run.configuration.assemble"].n_calls == 0.5
    assert {"solid.linear_solver.ConstrainedSystem", "cover.cover.build_cover"} <= set(found)
    assert not any(part.startswith("_") for name in found for part in name.split("."))
    assert found["run.configuration.assemble"].cumulative >= found["cover.cover.build_cover"].cumulative
