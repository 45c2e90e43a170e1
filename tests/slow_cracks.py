"""A plate under tension whose edge cracks grow below their toughness."""

from __future__ import annotations

from crackgrow.case.model import Case
from tests.scenes import shipped_case

PLATE = "edge_tension"
STRENGTH = "{tension: 5, cohesion: 20, friction_angle: 40, toughness: 0.5 MPa sqrt(m)}"
GROWTH = "steps: 4, increment: 1, advance: all, criterion: max_hoop_stress, direction: explicit"
LAW = "law: subcritical, subcritical: {velocity: 10 mm/s, exponent: 10}"
CYCLES = (
    "growth={steps: 4, increment: 1, advance: all, criterion: max_hoop_stress, direction: explicit, law: fatigue,"
    " fatigue: {rate: 1e-6 mm, at: 1 MPa sqrt(m), exponent: 3}}",
    "loading={history: [-0.5, 0.25, 1]}",
)
SHORTER = "cracks.shorter={path: {points: [[-15, 40], [-11, 40]]}, tips: end, contact: none}"  # than the notch, 6 mm
SLOWLY = (f"bodies.rock.strength={STRENGTH}", f"growth={{{GROWTH}, {LAW}}}", "numerics.spacing=3")


def slow_cracks(*settings: str) -> Case:
    """The plate with the edge crack `notch`, of 6 mm, at 0.39 of its toughness."""
    return shipped_case(PLATE, [*SLOWLY, "output.frames=none", "output.figures=false", *settings])
