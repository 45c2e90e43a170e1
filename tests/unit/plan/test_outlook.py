"""What a run is about to take: guessed in no time, and near to what is counted on the cover."""

from __future__ import annotations

from pathlib import Path

import pytest

from crackgrow.case import Case, load_case
from crackgrow.plan import cost
from crackgrow.plan.cost import estimated_cost, outlook
from crackgrow.plan.sizes import sizes_of

CASES = Path(__file__).resolve().parents[3] / "cases"


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("compression30", ["numerics.spacing=1.5"]),
        ("compression30", []),
        ("block_foundation", []),
        ("flaw_and_hole", ["numerics.spacing=1"]),
        ("interface_friction04", []),
        ("random_flaws", []),
        ("compression30", ["numerics.support=2.25", "numerics.spacing=1"]),
    ],
)
def test_guess_is_near_to_the_count(name: str, settings: list[str]) -> None:
    case = load_case(CASES / f"{name}.yaml", settings)
    found, sizes = outlook(case), sizes_of(case)
    assert found.n_dofs == pytest.approx(sizes.n_dofs, rel=0.15)
    counted = estimated_cost(case, sizes)
    assert found.cost.memory == pytest.approx(counted.memory, rel=0.1)
    assert found.cost.first_step == pytest.approx(counted.first_step, rel=0.3)
    assert f"about {found.n_dofs} dofs, " in found.needs
    assert "dofs" not in found.words


def test_a_scene_that_takes_minutes_to_lay_out_is_guessed_at_once_and_warned_of(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = load_case(CASES / "compression30.yaml", ["numerics.spacing=0.05"])

    def laid_out(_: Case) -> None:
        raise AssertionError("a lattice of 690,000 nodes is laid out for a guess")

    monkeypatch.setattr(cost, "make_scene", laid_out)
    found = outlook(case)
    assert "of CPU for the first step" in found.words
    assert " each of 22 more" in found.words
    monkeypatch.setattr(cost, "machine_memory", lambda: 8.0 * 1024.0)
    assert outlook(case).warning.startswith("the run needs about 13 GiB of memory, and this machine has 8 GiB: ")
    monkeypatch.setattr(cost, "machine_memory", lambda: 64.0 * 1024.0)
    assert outlook(case).warning == ""


def test_tip_functions_of_short_cracks_are_guessed_not_to_be_gathered() -> None:
    """`draft` has three to six cells along a flaw: each of 100 tips has five times as many functions as in `fine`.

    For 3 % there are five to nine, for 1 % more than are needed.
    """
    for accuracy, within in (("draft", 0.05), ("3 %", 0.05), ("1 %", 0.1)):
        flaws = load_case(CASES / "random_flaws.yaml", [f"numerics.accuracy={accuracy}", "numerics.spacing=auto"])
        assert outlook(flaws).n_dofs == pytest.approx(sizes_of(flaws).n_dofs, rel=within)
    fine = load_case(CASES / "compression30.yaml", ["numerics.accuracy=fine", "numerics.spacing=auto"])
    assert outlook(fine).n_dofs == pytest.approx(sizes_of(fine).n_dofs, rel=0.1)
