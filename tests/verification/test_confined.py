"""Lateral pressure stops wings: confined30 on a small plate and a coarse lattice."""

from __future__ import annotations

from functools import cache

import pytest

from crackgrow.case import load_case
from crackgrow.run.result import RunEnd, StepResult
from tests.verification.rows.confined import wing_of
from tests.verification.solutions import CASES
from tests.whole_run import whole_run

COARSE = (
    "bodies.rock.shape.rectangle.width=80", "bodies.rock.shape.rectangle.height=60", "numerics.spacing=2.5",
    "supports.0.at=[-40, -30]", "supports.1.at=[40, -30]", "supports.2.at=[0, -30]",
    "growth.increment=1.5", "growth.steps=6", "output.frames=none", "output.figures=false",
)  # fmt: skip
FRICTION = 0.3
EXPLICIT = ("growth.criterion=directional_strength", "growth.direction=explicit", "growth.increment=2")


@cache
def run(pressure: float, *settings: str) -> tuple[list[StepResult], RunEnd]:
    """The case under a lateral pressure in MPa; the axial one is 100 MPa."""
    confined = (f"loads.2.traction=[{pressure}, 0]", f"loads.3.traction=[{-pressure}, 0]")
    return whole_run(load_case(CASES / "confined30.yaml", [*COARSE, *confined, *settings]))


def test_wings_stop_where_K_falls_through_the_toughness() -> None:
    results, end = run(5.0)
    wing = wing_of(results)
    assert end.status == "arrested"
    assert wing.K_I[-1] < wing.toughness < wing.K_I[-2]
    assert wing.toughness == pytest.approx(0.5e6, rel=2e-3)  # what the case says of itself
    # in an infinite plate the formula has 4.95 mm; half of the case's width has 6.5 mm, measured
    assert 5.0e-3 < wing.arrest_length(wing.toughness) < 7.0e-3
    start, finish = results[-1].tips
    assert pytest.approx(finish.K_I, rel=1e-2) == start.K_I  # both wings are the same but for the lattice


def test_the_more_lateral_pressure_the_shorter_the_wings() -> None:
    """At the same increments of the criterion that needs no search."""
    grown = []
    for pressure, status in ((0.0, "completed"), (5.0, "arrested"), (10.0, "arrested")):
        results, end = run(pressure, *EXPLICIT)
        assert end.status == status
        grown.append(wing_of(results).length[-1])
    assert grown[0] >= grown[1] + 1.9e-3  # an increment; without pressure it would grow on
    assert grown[1] >= grown[2] + 1.9e-3
    free, _ = run(0.0, *EXPLICIT)
    assert min(tip.criticality for tip in free[-1].tips) > 2.0  # nowhere near arrest


def test_faces_of_the_stopped_wings_obey_friction() -> None:
    contact = run(5.0)[0][-1].contact
    pressed = contact.normal_traction < 0.0
    assert contact.normal_traction.max() <= 0.0
    assert pressed.any()
    assert not pressed.all()  # the flaw is closed, the wings stand open
    shear, limit = abs(contact.tangential_traction), FRICTION * -contact.normal_traction
    assert (shear <= limit + 1e-6 * limit.max()).all()
    assert shear[pressed] == pytest.approx(limit[pressed], rel=1e-6)  # sliding all along
