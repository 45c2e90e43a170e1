"""A reservoir that a fault displaces is depleted: rock at rest on rollers, and slip on what nothing else moves.

The supports prescribe zero, and the in-situ stress balances: what displaces is round-off, or the depletion alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow.case import Case

LAYERS = {"l": (-2000.0, -75.0, 150.0, 2000.0), "r": (-2000.0, -150.0, 75.0, 2000.0)}
"""m: where layers begin and end, on either side of the fault at x = 0."""

CLOSED = {"friction": 0.2, "cohesion": 0}


def fault(unit: str, contact: Any, depletion: float) -> Case:
    """The scene with lengths in a unit; `depletion` in MPa."""
    bodies, supports, loads = {}, [], []
    for side, (direction, edge) in {"l": (-1, "left"), "r": (1, "right")}.items():
        for part, low, high in zip("bmt", LAYERS[side][:-1], LAYERS[side][1:], strict=True):
            name = side + part
            middle, height = 0.5 * (low + high), high - low
            shape = {"center": [1125 * direction, middle], "width": 2250, "height": height}
            bodies[name] = {"shape": {"rectangle": shape}, "material": {"young": 14950, "poisson": 0.15}}
            supports.append({"on": {"body": name, "edge": edge}, "displacement": {"x": 0}})
            loads.append({"body": name, "stress": [-20, -40, 0], "held": True})
        supports.append({"on": {"body": f"{side}b", "edge": "bottom"}, "displacement": {"y": 0}})
        supports.append({"on": {"body": f"{side}t", "edge": "top"}, "displacement": {"y": 0}})
        loads.append({"body": f"{side}m", "stress": [depletion, depletion, 0]})
    pairs = [(f"{side}{a}", f"{side}{b}", "bonded") for side in "lr" for a, b in ("bm", "mt")]
    pairs += [(one, other, contact) for one, other in (("lb", "rb"), ("lb", "rm"), ("lm", "rm"), ("lm", "rt"))]
    pairs.append(("lt", "rt", contact))
    scene = {
        "title": "displaced fault",
        "units": {"length": unit, "stress": "MPa"},
        "plane": "strain",
        "bodies": bodies,
        "interfaces": [{"between": [one, other], "contact": law} for one, other, law in pairs],
        "supports": supports,
        "loads": loads,
        "numerics": {"accuracy": "draft"},
    }
    return Case.from_dict(scene)


def solved(unit: str, contact: Any, depletion: float) -> dict[str, float]:
    """Energies in J per metre of thickness."""
    step = crackgrow.run_case(fault(unit, contact, depletion)).steps.iloc[-1]
    return {name: float(step[name]) for name in ("work", "strain_energy", "dissipation")}


def test_a_depleted_reservoir_slips_on_the_fault_in_any_unit() -> None:
    """On the cells of `standard`, which told of no contradiction, the fault dissipates 51.85 MJ/m."""
    large, small = (solved(unit, CLOSED, 22.5) for unit in ("m", "mm"))
    assert large["dissipation"] == pytest.approx(51.85e6, rel=0.03)
    for name, energy in large.items():
        assert small[name] == pytest.approx(1e-6 * energy, rel=1e-9)


def test_a_bonded_fault_dissipates_nothing() -> None:
    energies = solved("m", "bonded", 22.5)
    assert energies["dissipation"] == 0.0
    assert energies["work"] == pytest.approx(energies["strain_energy"], rel=1e-12)


def test_rock_at_rest_on_rollers_moves_by_round_off() -> None:
    """Energies are 1e-9 of those of the depletion."""
    assert np.abs(list(solved("m", CLOSED, 0.0).values())).max() < 20.0
