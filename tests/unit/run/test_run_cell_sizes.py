"""What a run says and does where the cells are smaller than the lattice's: all of them are told to be, none is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.run import grow, layout
from crackgrow.run.result import StepResult
from tests.unit.cell_sizes import with_sizes

CASE = Path(__file__).parents[3] / "cases" / "compression30.yaml"

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
            grow(load_case(CASE, ["numerics.spacing=1.5", *settings, "output.frames=none", "output.figures=false"]))
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


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["growth.tip_stress.radius=0.7"], "averaging radius"),
        (["cracks.flaw.path.length=4.4"], "spacings long"),
        (["bodies.rock.shape.holes=[{rectangle: {center: [9, 15], width: 6, height: 6}}]"], "width of hole0"),
        (["bodies.rock.shape.holes=[{rectangle: {center: [11, 9], width: 6, height: 9}}]"], "rock between the outline"),
        (["cracks.flaw.path.center=[10.2, 0]"], "closer than a spacing to the outline"),
        (
            ["cracks.second={path: {center: [0, 1.2], length: 10, angle: 30}, contact: none}"],
            "crack 'second' is closer than a spacing to crack 'flaw'",
        ),
        (["cracks.flaw={path: {points: [[-4, 0], [4, 0], [4, 8]]}, contact: none}"], "so sharp a corner"),
        (
            [
                "cracks.flaw.path={points: [[-6, -2], [3, 1]]}",
                "cracks.flaw.tips=start",
                "cracks.other={path: {points: [[3, 1], [8, 2.7]]}, tips: end, contact: none}",
            ],
            "ends on crack 'flaw' and is shorter",
        ),
    ],
)
def test_what_cells_do_not_resolve_smaller_ones_do(first_step: Step, settings: list[str], words: str) -> None:
    for side, told in ((1.0, True), (0.5, False)):
        assert any(words in warning for warning in first_step(*settings, side=side).warnings) == told


def test_the_bound_of_K_goes_by_the_cells_round_the_tip(first_step: Step) -> None:
    """Of an open straight crack only the term with (h / L)^2 knows them."""
    path = "cracks.flaw={path: {center: [0, 0], length: 4, angle: 30}, contact: none}"
    tips = [first_step(path, side=side).tips[0] for side in (1.0, 0.5, 0.25)]
    wider, closer = -np.diff([(tip.K_II_error - tip.K_II_spread) / max(abs(tip.K_I), abs(tip.K_II)) for tip in tips])
    assert closer > 0.0
    assert wider / closer == pytest.approx(4.0, rel=0.01)
