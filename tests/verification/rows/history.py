"""A closed crack under shear that goes back and forth: friction remembers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from crackgrow.case import load_case
from crackgrow.quadrature.rules import gauss
from crackgrow.run.increments import LoadState
from crackgrow.run.loading import load_history
from crackgrow.run.scene import make_scene
from tests.verification.reversed_shear import ShearedCrack
from tests.verification.row import Row
from tests.verification.solutions import CASES, Floats, before_growth, jump_of

CRACK = ShearedCrack(half_length=0.01, young_prime=1e10 / (1.0 - 0.25**2), friction=0.5, pressure=20e6)
AMPLITUDE = 30e6  # Pa, shear at load factor 1
FORMULA = "closed form of the infinite plate: a plate of 15 crack lengths slips 0.2 % more"
SAMPLES = 40


@dataclass(frozen=True, slots=True, eq=False)
class Cycle:
    """The states of a history; `shear` (n,) Pa."""

    shear: Floats
    states: tuple[LoadState, ...]
    K_II: Floats  # (n,) Pa sqrt(m), at the end

    @property
    def mean_slip(self) -> Floats:
        """Slip (n,) m averaged over the crack."""
        t, weights = gauss(SAMPLES)  # x = -a cos(theta): smooth at the tips
        theta = np.pi * t
        s, weights = CRACK.half_length * (1.0 - np.cos(theta)), 0.5 * np.pi * weights * np.sin(theta)
        return np.array([weights @ jump_of(state.configuration, state.outcome.u, s)[1] for state in self.states])

    @property
    def dissipated(self) -> Floats:
        """Energy (n,) J/m taken by friction since the start."""
        return np.array([state.energy.dissipated for state in self.states])


@cache
def cycle(*factors: float) -> Cycle:
    """cyclic_friction under a history of factors, its own if none are given."""
    settings = [f"loading.history={list(factors)}"] if factors else []
    scene = make_scene(load_case(CASES / "cyclic_friction.yaml", settings))
    solutions = list(load_history(scene, before_growth(scene.case)))
    shear = AMPLITUDE * np.array([solution.state.factor for solution in solutions])
    K_II = np.array([solution.tips[1].K[1] for solution in solutions])
    return Cycle(shear, tuple(solution.state for solution in solutions), K_II)


def worst_slip() -> float:
    """Largest difference of the mean slip from the closed form, relative to the largest slip."""
    wanted = CRACK.mean_slip(cycle().shear)
    return float(np.abs(cycle().mean_slip - wanted).max() / np.abs(wanted).max())


def slip_at(shear: float, occurrence: int) -> float:
    """Mean slip (micrometres) where the shear (Pa) is reached for the n-th time."""
    return float(1e6 * cycle().mean_slip[np.flatnonzero(np.isclose(cycle().shear, shear, atol=1.0))[occurrence]])


def wanted_at(shear: float, occurrence: int) -> float:
    found = np.flatnonzero(np.isclose(HISTORY, shear, atol=1.0))[occurrence]
    return float(1e6 * CRACK.mean_slip(HISTORY)[found])


def per_cycle() -> float:
    """Energy (J/m) dissipated between the two times that the shear is largest."""
    first, *_, last = np.flatnonzero(np.isclose(cycle().shear, AMPLITUDE))
    return float(cycle().dissipated[last] - cycle().dissipated[first])


def worst_K() -> float:
    """Largest difference of K_II from the closed form, relative to the largest."""
    wanted = CRACK.K_II(cycle().shear)
    return float(np.abs(cycle().K_II - wanted).max() / np.abs(wanted).max())


def one_or_twenty() -> float:
    """Relative difference of the end states that one increment and twenty lead to."""
    once, often = (
        cycle(*factors).states[-1].outcome.u for factors in ((1.0,), tuple(np.linspace(0.05, 1.0, 20).tolist()))
    )
    return float(np.abs(once - often).max() / np.abs(once).max())


def worst_balance() -> float:
    """Largest relative error of the energy balance of any step."""
    return max(state.energy.error for state in cycle().states)


HISTORY = AMPLITUDE * 0.2 * np.concatenate([np.arange(1, 6), np.arange(4, -6, -1), np.arange(-4, 6)])
NAME = "cyclic_friction"


def _row(quantity: str, reference: float, source: str, tolerance: float, value: Callable[[], float]) -> Row:
    """A row; where the reference is zero the value is an error itself."""
    return Row(NAME, quantity, reference, "exact", source, tolerance, value, "relative" if reference else "at most")


ROWS = [
    _row("mean slip in all steps: largest difference, of the largest", 0.0, FORMULA, 1e-2, worst_slip),
    *(
        _row(f"mean slip {words} [micrometre]", wanted_at(shear, n), FORMULA, 1e-2, partial(slip_at, shear, n))
        for words, shear, n in (
            ("at 30 MPa", 30e6, 0),
            ("left at 0 MPa after 30", 0.0, 0),
            ("at -30 MPa", -30e6, 0),
            ("left at 0 MPa after -30", 0.0, 1),
        )
    ),
    _row("energy dissipated in a cycle [J/m]", CRACK.dissipated_per_cycle(AMPLITUDE), FORMULA, 1e-2, per_cycle),
    _row("K_II in all steps: largest difference, of the largest", 0.0, FORMULA, 1e-2, worst_K),
    _row("displacement after one increment and after 20: difference", 0.0, "nothing turns back", 1e-9, one_or_twenty),
    _row("energy balance: largest relative error", 0.0, "work = strain energy + dissipation", 1e-3, worst_balance),
]
