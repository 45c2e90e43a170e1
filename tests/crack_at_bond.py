"""A crack that ends at right angles on the bond of two equal bodies, under equal tension both ways: T is nothing."""

from __future__ import annotations

from crackgrow.case.model import Case
from tests.verification.solutions import case_of

TOUGHNESS = 1e12 / (20e9 / (1.0 - 0.25**2))
"""J/m^2, G_c of the rock."""


def crack_at_bond(*settings: str, pressed: float = 0.0) -> Case:
    """It grows at its end alone, by an increment of a 20th of its half length of 20 mm, at its critical load.

    All of it may be `pressed` (MPa) all the time: then its faces touch, without friction.
    """
    width, rock = 200.0, {"young": "20 GPa", "poisson": 0.25}
    strength = {"tension": 5, "cohesion": 20, "friction_angle": 40, "toughness": "1 MPa sqrt(m)"}
    law = {"friction": 0, "cohesion": 0}
    sides = {"left": (-width, 0.0), "right": (0.0, width)}
    edges = [("left", 0, [0, -1]), ("right", 0, [0, -1]), ("left", 2, [0, 1]), ("right", 2, [0, 1])]
    return case_of(
        {
            "title": "a crack at a bond",
            "units": {"length": "mm", "stress": "MPa"},
            "plane": "strain",
            "bodies": {
                name: {
                    "shape": {"polygon": [[low, -width], [high, -width], [high, width], [low, width]]},
                    "material": rock,
                    "strength": strength,
                }
                for name, (low, high) in sides.items()
            },
            "cracks": {"flaw": {"path": [[-40, 0], [0, 0]], "contact": law if pressed else "none", "tips": "none"}},
            "interfaces": [{"between": [*sides], "contact": law, "toughness": "10 J/m^2"}],
            "supports": "minimal",
            "loads": [
                {"on": {"body": body, "edge": edge}, "traction": [size * x, size * y], "held": size != 1.0}
                for size in ((1.0, -pressed) if pressed else (1.0,))
                for body, edge, (x, y) in (*edges, ("left", 3, [-1, 0]), ("right", 1, [1, 0]))
            ],
            "loading": "critical",
            "growth": {"steps": 2, "increment": 1, "criterion": "max_hoop_stress"},
            "numerics": {"accuracy": "standard"},
        },
        *settings,
    )
