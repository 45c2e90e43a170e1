"""What faces and tips do on the way of the loads: their energies are the step's, and what begins first is first."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.fracture.opening import kinked_release
from crackgrow.run.result import StepResult
from crackgrow.solid.elasticity import plane_elasticity
from tests.scenes import shipped_case
from tests.solving import whole_run
from tests.verification.solutions import QUIET

FLAW = "cracks.flaw.contact"
DRAFT = ("numerics.accuracy=draft", *QUIET)


def energy(step: StepResult, kind: str) -> float:
    """Of all emissions of a kind, J/m."""
    return sum(event.energy for event in step.emissions if event.kind == kind)


@pytest.mark.parametrize(
    ("scene", "settings"),
    [
        ("cyclic_friction", ("numerics.spacing=5",)),  # slips to and fro
        ("vein_in_tension", ()),  # breaks
        ("09_wear", ()),  # wears by slip
        ("interface_friction04", ()),
        (
            "confined30",
            (f"{FLAW}.cohesion=5", "growth.steps=1", "numerics.spacing=3"),
        ),  # slips, breaks and opens from rest, then grows
    ],
)
def test_emissions_of_a_step_add_up_to_its_energies(scene: str, settings: tuple[str, ...]) -> None:
    case = shipped_case(scene, (*DRAFT, *settings))
    steps, _ = whole_run(case)
    energies = np.array([(step.energy.dissipated, step.energy.released) for step in steps])
    if case.growth is None:
        energies = np.diff(energies, axis=0, prepend=np.zeros((1, 2)))
    told = [(energy(step, "slip"), energy(step, "break")) for step in steps]
    assert np.abs(energies).max() > 0.0
    np.testing.assert_allclose(told, energies, rtol=0, atol=1e-12 * np.abs(energies).max())


def flaw(y: float, angle: float) -> str:
    """With cohesion and friction, at a height and an angle to x."""
    return f"{{path: {{center: [0, {y}], length: 8, angle: {angle}}}, contact: {{friction: 0.2, cohesion: 3}}}}"


def test_faces_slip_at_the_load_at_which_the_plane_through_them_would_and_the_first_is_told_first() -> None:
    """Stress in the plate under 100 MPa is uniform until one slips: p sin cos = c + mu p cos^2."""
    cracks = f"cracks={{flat: {flaw(14, 30)}, steep: {flaw(-14, 50)}}}"
    (step,), _ = whole_run(shipped_case("compression30", (*DRAFT, cracks, "growth.steps=0")))
    assert [event.kind for event in step.emissions if event.crack == "steep"][:2] == ["break", "slip"]
    slips = {event.crack: event.load_factor for event in step.emissions if event.kind == "slip"}
    assert list(slips) == ["steep", "flat"]
    s, c = np.sin(np.deg2rad(50.0)), np.cos(np.deg2rad(50.0))
    assert slips["steep"] == pytest.approx(3.0 / (s * c - 0.2 * c**2) / 100.0, rel=1e-7)


def test_faces_open_where_they_were_pressed_and_the_load_takes_that_back() -> None:
    """A plate is pressed by 6 MPa and pulled by as much as 10: its crack opens at 0.6 of that, and told it is once."""
    loads = "loads=[{far_field: [0, -6, 0], held: true}, {far_field: [0, 10, 0]}]"
    case = shipped_case("tension0", (*DRAFT, loads, f"{FLAW}={{friction: 0.3, cohesion: 0}}", "growth.steps=0"))
    (step,), _ = whole_run(case)
    (opening,) = (event for event in step.emissions if event.kind == "opening")
    assert opening.load_factor == pytest.approx(0.6, rel=1e-6)


def test_growth_under_load_releases_what_its_events_say() -> None:
    """G rises by some percent along an increment of a fiftieth of the crack, and is told of its beginning."""
    settings = ("growth.steps=2", "growth.increment=0.2", "growth.unload_between_steps=false", "loading={history: [1]}")
    first, second, third = whole_run(shipped_case("tension0", (*DRAFT, *settings, "numerics.accuracy=fine")))[0]
    for before, after in ((first, second), (second, third)):
        released = after.energy.released - before.energy.released
        assert 0.97 * released < energy(before, "growth") < released


def test_a_tip_releases_what_Irwin_says_and_beside_it_what_a_kink_does() -> None:
    """By the series of Amestoy and Leblond 1992 at 20 degrees, where the first order is 2 % low."""
    rock = plane_elasticity(1.0, 0.3, "stress")
    assert kinked_release((3.0, 4.0), 0.0, rock) == pytest.approx(25.0, rel=1e-15)
    assert kinked_release((-3.0, 0.0), 0.0, rock) == 0.0  # faces that overlap
    m = 1.0 / 9.0
    k_1 = 1.5 * np.pi * m - (10.0 * np.pi / 3.0 + np.pi**3 / 16.0) * m**3
    k_2 = 1.0 - (4.0 + 3.0 * np.pi**2 / 8.0) * m**2 + (8 / 3 + 29 * np.pi**2 / 18 - 5 * np.pi**4 / 128) * m**4
    assert kinked_release((0.0, 1.0), -m * np.pi, rock) == pytest.approx(k_1**2 + k_2**2, rel=0.025)
