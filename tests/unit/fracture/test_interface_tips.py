"""G at the tips of cracked interfaces: of one material that of a crack, whatever acts on it; invariance between two."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crackgrow.run.result import InterfaceTipResult
from tests.verification.solutions import case_of, solve_case

pytestmark = pytest.mark.physics

E_PRIME = 20e9 / (1.0 - 0.25**2)
ENDS = np.array([[-8.0, -2.0], [8.0, 4.0]])  # mm
RISE = 0.375  # of the line through them


def traction(x: float, y: float) -> dict[str, Any]:
    """A load on the top edge."""
    return {"on": {"body": "upper", "edge": 2}, "traction": [x, y]}


def scene(loads: list[dict[str, Any]], friction: float = 0.0, *, young: float = 20.0, pair: str = "upper lower") -> Any:
    """Two halves of a square of 120 mm, the upper one of another Young's modulus (GPa), cracked between ENDS."""
    left, right = 1.0 - 60.0 * RISE, 1.0 + 60.0 * RISE
    shapes = {
        "upper": [[-60, left], [60, right], [60, 60], [-60, 60]],
        "lower": [[-60, -60], [60, -60], [60, right], [-60, left]],
    }
    rock = {"young": "20 GPa", "poisson": 0.25, "density": "2500 kg/m^3"}
    law = {"friction": friction, "cohesion": 0}
    return {
        "title": "a cracked interface",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "upper": {"shape": {"polygon": shapes["upper"]}, "material": {**rock, "young": f"{young} GPa"}},
            "lower": {"shape": {"polygon": shapes["lower"]}, "material": rock},
        },
        "interfaces": [{"between": pair.split(), "contact": law, "cracked": ENDS.tolist()}],
        "supports": [
            {"on": {"body": "lower", "edge": 0}, "displacement": {"y": 0}},
            {"at": [-60, -60], "displacement": {"x": 0}},
        ],
        "loads": loads,
        "numerics": {"accuracy": "standard"},
    }


def whole(loads: list[dict[str, Any]], friction: float) -> Any:
    """The same crack in one body."""
    given = scene([], friction)
    (interface,) = given.pop("interfaces")
    square = {"polygon": [[-60, -60], [60, -60], [60, 60], [-60, 60]]}
    bodies = {"lower": {**given["bodies"]["lower"], "shape": square}}
    crack = {"path": {"points": ENDS.tolist()}, "contact": interface["contact"]}
    told = [{**load, "on": {"body": "lower", "edge": 2}} if "on" in load else load for load in loads]
    told = [{"crack": "crack", "pressure": load["pressure"]} if "pressure" in load else load for load in told]
    return {
        **given,
        "bodies": bodies,
        "cracks": {"crack": crack},
        "loads": [x for x in told if x.get("body") != "upper"],
    }


def tips_of(given: Any) -> list[InterfaceTipResult]:
    """The tips of the cracked interface, from left to right."""
    tips = solve_case(case_of(given)).result.interface_tips
    return sorted(tips, key=lambda tip: float(tip.point[0]))


@pytest.mark.parametrize(
    ("loads", "friction"),
    [
        ([traction(0, 1)], 0.0),
        ([traction(0, -4)], 0.2),
        ([{"interface": ["lower", "upper"], "pressure": 1}], 0.0),
        ([traction(0, 1e-4), *({"body": body, "gravity": [0, 9.81]} for body in ("upper", "lower"))], 0.0),
    ],
    ids=["pulled", "slides with friction", "fluid", "weight"],
)
def test_between_equal_bodies_it_is_that_of_a_crack(loads: list[dict[str, Any]], friction: float) -> None:
    """By Irwin's relation G = (K_I^2 + K_II^2) / E', K by the interaction integral in one body."""
    cracks = sorted(solve_case(case_of(whole(loads, friction))).result.tips, key=lambda tip: float(tip.point[0]))
    K = np.array([np.hypot(tip.K_I, tip.K_II) for tip in cracks])
    tips = tips_of(scene(loads, friction))
    np.testing.assert_allclose([tip.G for tip in tips], K**2 / E_PRIME, rtol=5e-3)
    np.testing.assert_allclose([tip.K for tip in tips], K, rtol=2.5e-3)
    assert max(tip.G_spread / tip.G for tip in tips) < 5e-3


def test_it_does_not_matter_which_body_is_named_first() -> None:
    one, other = (tips_of(scene([traction(0, 1)], young=80.0, pair=pair)) for pair in ("upper lower", "lower upper"))
    np.testing.assert_allclose([tip.G for tip in one], [tip.G for tip in other], rtol=1e-6)
    assert [tip.tip for tip in one] == ["start", "end"]
    assert [tip.tip for tip in other] == ["end", "start"]
