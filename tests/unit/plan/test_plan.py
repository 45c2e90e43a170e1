"""What `crackgrow check` says of a case: its words, counts that are those of the run, cost and warnings."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import pytest
import yaml

from crackgrow.case import Case
from crackgrow.plan import cost
from crackgrow.plan.cost import Sizes, cost_of, estimated_cost, guessed_sizes, sizes_of
from crackgrow.plan.text import overview, plan_text
from crackgrow.run.loop import grow
from tests.scenes import shipped_case
from tests.unit.case.scenes import EVERYTHING, load

CASES = Path(__file__).parents[3] / "cases"
COARSE = {
    "compression30": ("numerics.spacing=3",),
    "interface_friction04": ("numerics.spacing=0.1",),
    "block_rigid": ("numerics.spacing=0.25",),
    "junction_static": ("numerics.spacing=4",),
    "cyclic_friction": ("numerics.spacing=15",),
}


def words_of(sizes: Sizes) -> tuple[str, ...]:
    return tuple(warning.words for warning in sizes.scene_warnings)


def coarse(name: str, *settings: str) -> Case:
    return shipped_case(name, (*COARSE.get(name, ()), *settings))


@pytest.mark.parametrize("name", sorted(COARSE))
def test_counts_are_those_of_the_run(name: str) -> None:
    case = coarse(name)
    sizes, first = sizes_of(case), next(grow(case))
    assert (sizes.n_dofs, sizes.n_contact) == (first.n_dofs, len(first.contact.s))
    assert sizes.n_dofs == 2 * sizes.n_patches + 8 * sizes.n_singular
    assert sizes.n_tips == len(first.tips)
    plan_alone = {text for text in words_of(sizes) if text.startswith("the increment")}
    assert set(words_of(sizes)) - plan_alone <= set(first.warnings)  # the same words


CHECKED = yaml.safe_load(Path(__file__).with_name("check.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("table", "row"), [(table, row) for table, rows in CHECKED.items() for row in rows])
def test_what_is_told(table: str, row: list[Any], tmp_path: Path) -> None:
    """All that check.yaml wants of a case, and nothing of what it does not want."""
    name, settings, told, *untold = row
    case = load(tmp_path, EVERYTHING, *settings) if name == "everything" else shipped_case(name, settings)
    text = {"overview": overview, "plan": plan_text}[table](case)
    assert [part for part in told if part not in text] == []
    assert [part for parts in untold for part in parts if part in text] == []


def test_more_memory_than_the_machine_has_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    case = coarse("compression30")
    needed = cost_of(case).memory
    monkeypatch.setattr(cost, "machine_memory", lambda: 1.1 * needed)
    assert "of memory, and this machine" not in plan_text(case)
    monkeypatch.setattr(cost, "machine_memory", lambda: 0.9 * needed)
    assert f"needs about {needed:.0f} MiB of memory, and this machine has {0.9 * needed:.0f} MiB" in plan_text(case)


@pytest.mark.parametrize("spacing", [0.8, 0.4])
def test_a_guess_without_a_cover_is_near_that_with_one(spacing: float) -> None:
    case = shipped_case("compression30", [f"numerics.spacing={spacing}", "growth.steps=0"])
    counted, guessed = (estimated_cost(case, sizes(case)) for sizes in (sizes_of, guessed_sizes))
    assert guessed.seconds == pytest.approx(counted.seconds, rel=0.25)
    assert guessed.memory == pytest.approx(counted.memory, rel=0.25)


UNTOLD = {
    **dict.fromkeys(("en_echelon", "tunnel_excavated"), "three and more rounds of refinement in a step"),
    "13_curved": "two rounds: cells to begin with take no heed of curves",
    "05_initiation": "cracks that are not there yet",
    "08_safety": "one factor after the other is tried",
}
"""What makes runs longer, and is not told of."""


@pytest.mark.physics
@pytest.mark.parametrize("name", sorted(path.stem for path in CASES.glob("*.yaml")))
def test_what_is_told_of_a_shipped_case_is_within_a_factor_of_two_of_what_it_took(name: str) -> None:
    with (CASES.parent / "tests" / "benchmarks" / "cost.csv").open(encoding="utf-8") as file:
        next(file)
        taken = next(row for row in csv.DictReader(file) if row["run"] == name)
    told = cost_of(shipped_case(name))
    lowest = 0.2 if name in UNTOLD else 0.5
    assert lowest < told.seconds / float(taken["taken_s"]) < 2.0
    assert lowest < told.memory / float(taken["taken_MiB"]) < 2.0
