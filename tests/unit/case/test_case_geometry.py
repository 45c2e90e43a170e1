"""Cracks inside their body, and supports that hold it: what is refused and what is allowed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import Case, load_case
from crackgrow.errors import CaseError

FILE = Path(__file__).parent / "compression30.yaml"


def load(*overrides: str) -> Case:
    return load_case(FILE, overrides)


def message(*overrides: str) -> str:
    """Return the message of the only fault."""
    with pytest.raises(CaseError) as caught:
        load(*overrides)
    (fault,) = caught.value.faults
    return fault.message


@pytest.mark.parametrize(
    ("points", "tips"),
    [
        ("[[0, 0], [15.5, 0]]", "start"),
        ("[[-15.5, 0], [1, 0]]", "end"),
        ("[[0, 0], [15.5, 0]]", "none"),
        ("[[0, 0], [0.002, 0]]", "both"),
        ("[[0, 0], [4, 0], [4, 4], [0, 4], [0, 1]]", "both"),
    ],
)
def test_crack_allowed(points: str, tips: str):
    crack = load(f"cracks.flaw.path={{points: {points}}}", f"cracks.flaw.tips={tips}").cracks[0]
    assert len(crack.points) == points.count("],") + 1


@pytest.mark.parametrize("angle", [0, 90, 180, 270, 360, -90, 450])
def test_right_angles_are_exact(angle: int):
    start, end = load(f"cracks.flaw.path.angle={angle}").cracks[0].points
    direction = (end - start) / 0.01
    assert direction.tolist() == [[1, 0], [0, 1], [-1, 0], [0, -1]][angle // 90 % 4]


@pytest.mark.parametrize(
    "supports",
    [
        "[{on: {body: rock, edge: bottom, from: -1, to: 1}, displacement: {x: 0, y: 0}}]",
        "[{at: [3, -9], displacement: {x: 0, y: 0}}, {at: [5, 9], displacement: {x: 0}}]",
        "[{on: {body: rock, edge: left}, displacement: {x: 0}}, {at: [15.5, -9], displacement: {y: 0}}]",
    ],
)
@pytest.mark.parametrize("unit", ["um", "mm", "km"])
def test_held_at_any_size(supports: str, unit: str):
    assert load(f"supports={supports}", f"units.length={unit}").supports


def test_two_supports_in_y_anywhere_leave_x():
    rng = np.random.default_rng(3)
    for _ in range(20):
        x, y = rng.uniform(-10, 10, (2, 2)).round(3)
        first, second = (f"{{at: [{a}, {b - 15}], displacement: {{y: 0}}}}" for a, b in zip(x, y, strict=True))
        assert "translation in x;" in message(f"supports=[{first}, {second}]")


def test_small_body_far_out_keeps_its_supports():
    """One kilometre off, corners are still recognised as lying on the outline."""
    case = load(
        "bodies.rock.shape.rectangle.center=[1 km, 1 km]",
        "cracks={}",
        "supports.0.at=[999984.5, 999972.5]",
        "supports.1.at=[1000015.5, 999972.5]",
        "supports.2.at=[1000 m, 999972.5]",
    )
    assert len(case.supports) == 3


def test_plane_stress_takes_poisson_one_half():
    assert load("plane=stress", "bodies.rock.material.poisson=0.5").bodies[0].material.poisson == 0.5


def test_gauss_with_a_finite_stiffness():
    contact = load("numerics.contact={discretization: gauss, stiffness: 100}").numerics.contact
    assert (contact.discretization, contact.stiffness) == ("gauss", 100.0)
