"""What a run says and does where the cells are smaller than the lattice's: all of them are told to be, none is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from crackgrow.cover.cover import Cover, build_cover
from crackgrow.run import grow, layout
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case
from tests.unit.cell_sizes import with_sizes

CASE = "compression30"

Step = Callable[..., StepResult]


@pytest.fixture
def first_step(monkeypatch: pytest.MonkeyPatch) -> Step:
    """The first step of compression30 with settings, with cells of a `side` in lattice units, also `at_tips`."""

    def solve(*settings: str, side: float = 1.0, at_tips: bool = True) -> StepResult:
        def build(*args: Any) -> Cover:
            cover = build_cover(*args)
            tips = tuple(replace(tip, size=side if at_tips else 1.0) for tip in cover.tips)
            return with_sizes(replace(cover, tips=tips), side)

        monkeypatch.setattr(layout, "build_cover", build)
        return next(
            grow(shipped_case(CASE, ["numerics.spacing=1.5", *settings, "output.frames=none", "output.figures=false"]))
        )

    return solve


def test_the_stiffness_of_contact_goes_by_the_cells_beside_it(first_step: Step) -> None:
    """k = kappa E/h: half the h is twice the kappa. Gauss points lie where they do whatever the cells."""
    points = "numerics.contact.discretization=gauss"
    stiff = first_step(points, "numerics.contact.stiffness=2")
    small = first_step(points, "numerics.contact.stiffness=1", side=0.5, at_tips=False)
    large = first_step(points, "numerics.contact.stiffness=1")
    for one, other in zip(small.tips, stiff.tips, strict=True):
        assert pytest.approx(other.K_II, rel=1e-12) == one.K_II
    assert small.energy.strain == pytest.approx(stiff.energy.strain, rel=1e-12)
    assert small.overlap == pytest.approx(stiff.overlap, rel=1e-9)
    assert abs(large.tips[0].K_II / small.tips[0].K_II - 1.0) > 1e-3


def test_every_tip_tells_the_side_of_its_cells(first_step: Step) -> None:
    assert [tip.cell_size for tip in first_step(side=0.25).tips] == pytest.approx([0.25 * 1.5e-3] * 2)
