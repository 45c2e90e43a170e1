"""What a step warns of, and what it keeps quiet about."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.run import grow
from crackgrow.run.result import StepResult

CASES = Path(__file__).parents[3] / "cases"


def first_step(scene: str, *settings: str) -> StepResult:
    case = load_case(CASES / f"{scene}.yaml", [*settings, "output.frames=none", "output.figures=false"])
    return next(grow(case))


def test_the_shipped_scenes_warn_of_nothing() -> None:
    assert first_step("compression30").warnings == ()
    assert first_step("tension0").warnings == ()
    assert first_step("compression30", "cracks.flaw.contact.friction=0.6").warnings == ()  # stuck: jumps are noise


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["growth.tip_stress.radius=0.7"], "averaging radius"),
        (["numerics.support=1.5"], "numerics.support is 1.5"),
        (["cracks.flaw.path.length=4.4"], "crack 'flaw' is 2.93 spacings long"),
        (["cracks.flaw.path.center=[10.5, 0]"], "the end of crack 'flaw' is closer than a spacing to the outline"),
        (
            ["cracks.second={path: {center: [0, 1.2], length: 10, angle: 30}, contact: none}"],
            "crack 'second' is closer than a spacing to crack 'flaw'",
        ),
    ],
)
def test_what_the_cover_resolves_badly_is_said(settings: list[str], words: str) -> None:
    assert [words in warning for warning in first_step("compression30", *settings).warnings].count(True) == 1


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ("{stiffness: 1, discretization: gauss}", []),  # E'/(2k) is half a spacing
        ("{stiffness: 10, discretization: gauss}", ["elastic contact with gauss points"]),
        ("{stiffness: 1, discretization: mortar}", ["K_I there is not resolved; use a rigid contact, or numerics"]),
        ("{stiffness: 100, discretization: mortar}", ["elastic contact with mortar nodes"]),
        ("{stiffness: 1e8, discretization: mortar}", []),  # as good as rigid
        ("{stiffness: 10000, discretization: gauss}", ["contact tractions on 'flaw' oscillate", "gauss points"]),
    ],
)
def test_what_elastic_contact_does_not_resolve_is_said(settings: str, words: list[str]) -> None:
    warnings = first_step("compression30", f"numerics.contact={settings}").warnings
    assert len(warnings) == len(words)
    assert all(any(word in warning for warning in warnings) for word in words)


def test_overlap_is_the_largest_anywhere_and_small_on_a_straight_crack() -> None:
    result = first_step("compression30")
    (faces,) = result.faces
    assert result.overlap == -faces.opening.min()
    assert 0.0 < result.overlap < 5e-3 * np.abs(faces.slip).max()
    assert first_step("tension0").overlap == 0.0  # open


def test_elastic_contact_explains_its_overlap() -> None:
    soft = first_step("compression30", "numerics.contact.stiffness=100")
    (faces,) = soft.faces
    assert -faces.opening.min() > 1e-7  # m: 74 MPa over 100 E / h
    assert soft.overlap < 5e-3 * np.abs(faces.slip).max()


def test_a_tip_without_room_for_the_integral_of_K_is_told_once() -> None:
    close = "cracks.flaw.path.center=[8, 0]"  # the end is 2.1 spacings from the side
    case = load_case(CASES / "compression30.yaml", [close, "growth.steps=2", "output.frames=none"])
    told = [[text for text in result.warnings if "the integral" in text] for result in grow(case)]
    assert told == [
        ["K at the end of crack 'flaw': the outline makes the disc of the integral small; see the columns K_*_error of "
         "tips.csv"],
        [],
        [],
    ]  # fmt: skip


def test_that_things_are_closer_than_a_spacing_is_told_once() -> None:
    close = ["cracks.flaw.path.center=[10, 0]", "cracks.flaw.tips=start", "growth.steps=2", "output.frames=none"]
    case = load_case(CASES / "compression30.yaml", close)  # the end is 1.2 mm from the side
    told = [[text for text in result.warnings if "closer than a spacing" in text] for result in grow(case)]
    assert [len(texts) for texts in told] == [1, 0, 0]
