"""The tools of the benchmarks. Nothing here asserts a duration."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from crackgrow.cover.lattice import place_lattice
from tests.benchmarks import beside as side_by_side
from tests.benchmarks import scenes
from tests.benchmarks.beside import PHASES, Scene, beside
from tests.benchmarks.paths import ROOT
from tests.benchmarks.run import HEADER, row_of

Told = tuple[list[tuple[int, float, dict[str, float]]], float]
COARSE = Scene("coarse", "interface_friction04", ("numerics.spacing=0.1",))


def told(unknowns: int, *seconds: float) -> Told:
    """What a run of steps of so many seconds tells, a tenth of them in each phase."""
    return [(unknowns, each, dict.fromkeys(PHASES, 0.1 * each)) for each in seconds], 100.0


def by_turns(monkeypatch: pytest.MonkeyPatch, *runs: Told) -> None:
    """The programs tell these, run after run."""
    turns: Iterator[Told] = iter(runs)
    monkeypatch.setattr(side_by_side, "_run", lambda scene, program: next(turns))


def test_programs_take_turns_and_the_least_of_each_step_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    by_turns(monkeypatch, told(9, 2.0, 1.0, 3.0), told(9, 8.0, 8.0), told(9, 1.0, 2.0, 2.0), told(9, 4.0, 9.0))
    then, now = beside(COARSE, (ROOT, ROOT), 2)
    assert (then.first, then.later, then.whole) == (1.0, 1.5, 4.0)
    assert (now.first, now.later, now.phases["cover"]) == (4.0, 8.0, pytest.approx(0.8))
    row = dict(zip(HEADER[8:], row_of("coarse", then, now)[8:], strict=True))
    assert row["contact"] == "5.33"
    assert row_of("coarse", then, now)[7] == "5.33 slower"
    assert row_of("coarse", now, then)[7] == "0.188"


def test_other_cells_are_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    by_turns(monkeypatch, told(9, 1.0), told(10, 1.0))
    with pytest.raises(ValueError, match="coarse: 9 and 10 unknowns"):
        beside(COARSE, (ROOT, ROOT), 1)


def test_a_run_by_the_program_tells_of_its_steps() -> None:
    (found,) = beside(COARSE, (ROOT,), 1)
    assert found.unknowns > 100
    assert 0.0 < sum(found.phases.values()) <= found.first == found.whole
    assert np.isnan(found.later)


@pytest.mark.parametrize("n_dofs", [3_000, 500_000])
def test_the_spacing_gives_about_as_many_unknowns_as_asked_for(n_dofs: int) -> None:
    lattice = place_lattice(np.zeros(2), np.array([31.0, 55.0]), scenes.spacing_for(n_dofs), 2.0)
    assert 2 * np.prod(lattice.shape) + scenes.TIPS == pytest.approx(n_dofs, rel=0.1)
