"""confined30: where lateral pressure stops the wings, against the sliding-crack model.

Lengths are measured along a wing. K_I falls as a wing grows; the length at arrest is where it falls through the
toughness, on the straight line between the tips of two steps: increments do not limit it.

The case itself arrests. The curves K_I(l) at other pressures come from wings that are made to grow on, along the path
of `directional_strength` with a tenth of the strength, which needs one solve a step: K_I there is within 4 % of that on
the path of K_II = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from crackgrow import grow, load_case
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.result import CrackPath, StepResult
from tests.verification.row import Row
from tests.verification.solutions import CASES, Floats
from tests.verification.wing_elements import wing_K
from tests.verification.wing_model import WingModel

QUIET = ("output.frames=none", "output.figures=false")
ON_AND_ON = ("growth.criterion=directional_strength", "growth.direction=explicit", "bodies.rock.strength.tension=0.6")

AXIAL = 100.0
"""MPa."""

FRICTION = 0.3

STEPS = {0.0: (2.6, 5), 2.0: (2.6, 5), 5.0: (1.3, 5), 10.0: (0.6, 5)}
"""Lateral pressure (% of the axial stress): increment in mm and number of steps, past arrest but for 0 %."""

N_ELEMENTS = 80
"""On the flaw and on each wing; see the tests of the elements for what that is worth."""


@dataclass(frozen=True, slots=True, eq=False)
class Wing:
    """K_I of a growing wing."""

    length: Floats  # (steps,) m, along the wing; not the flaw itself, whose K_I is zero
    K_I: Floats  # (steps,) Pa sqrt(m)
    toughness: float  # Pa sqrt(m), of the case
    path: Floats  # (steps + 1, 2) m, from the tip of the flaw

    def arrest_length(self, toughness: float) -> float:
        """Length (m) at which K_I falls through a toughness; nan where it has not."""
        below = np.flatnonzero(toughness > self.K_I)
        if len(below) == 0 or below[0] == 0:
            return float("nan")
        span = slice(below[0] - 1, below[0] + 1)
        return float(np.interp(-toughness, -self.K_I[span], self.length[span]))


@cache
def as_shipped(*settings: str) -> Wing:
    """The case, up to its arrest."""
    return wing_of(list(grow(load_case(CASES / "confined30.yaml", [*QUIET, *settings]))))


@cache
def wing_at(percent: float) -> Wing:
    """A wing that is made to grow on, under a lateral pressure in % of the axial stress."""
    increment, n_steps = STEPS[percent]
    pressure = percent / 100.0 * AXIAL
    confined = (f"loads.2.traction=[{pressure}, 0]", f"loads.3.traction=[{-pressure}, 0]")
    return as_shipped(*ON_AND_ON, *confined, f"growth.increment={increment}", f"growth.steps={n_steps}")


def wing_of(results: Sequence[StepResult]) -> Wing:
    """The wing at the end of the only crack, step by step."""
    grown = results[1:]
    lengths = [wing_length(result.cracks[0]) for result in grown]
    K_I = [next(tip.K_I for tip in result.tips if tip.tip == "end") for result in grown]
    crack = results[-1].cracks[0]
    path = crack.points[np.flatnonzero(crack.steps == 0)[-1] :]
    return Wing(np.array(lengths), np.array(K_I), results[0].tips[0].K_growth, path)


def in_infinite_plate(wing: Wing, percent: float) -> Wing:
    """The same wing with the K_I that it would have in an infinite plate, by elements that know no lattice."""
    flaw = np.stack([-wing.path[0], wing.path[0]])
    lateral = -percent / 100.0 * AXIAL * 1e6
    paths = (wing.path[: n + 1] for n in range(1, len(wing.path)))
    K_I = [wing_K(flaw, path, N_ELEMENTS, -AXIAL * 1e6, lateral, FRICTION)[0] for path in paths]
    return replace(wing, K_I=np.array(K_I))


def wing_length(crack: CrackPath) -> float:
    """Length (m) of what has grown at the end of a crack, along the path."""
    return float(arc_lengths(crack.points[np.flatnonzero(crack.steps == 0)[-1] :])[-1])


def model(percent: float) -> WingModel:
    """The sliding-crack model of the case."""
    return WingModel(5e-3, 30.0, FRICTION, AXIAL * 1e6, percent / 100.0 * AXIAL * 1e6)


TOUGHNESS = 6.3e6 * np.sqrt(2.0 * np.pi * 1e-3)
"""Pa sqrt(m): what the strength and the radius of the case stand for."""


def arrest(percent: float) -> float:
    """Length at arrest (mm) of a wing that is made to grow on."""
    return 1e3 * wing_at(percent).arrest_length(TOUGHNESS)


def arrest_as_shipped() -> float:
    """Length at arrest (mm) of the case."""
    wing = as_shipped()
    return 1e3 * wing.arrest_length(wing.toughness)


def off_elements(wing: Wing, percent: float) -> float:
    """Relative difference of the length at arrest from that in an infinite plate, along the same path."""
    reference = in_infinite_plate(wing, percent).arrest_length(TOUGHNESS)
    return abs(wing.arrest_length(TOUGHNESS) / reference - 1.0)


def largest_ratio() -> float:
    """Largest ratio of the lengths at arrest from one pressure to the next larger."""
    lengths = np.array([arrest(percent) for percent in (2.0, 5.0, 10.0)])
    return float((lengths[1:] / lengths[:-1]).max())


def least_K_unconfined() -> float:
    """Least K_I/K_c of a wing without lateral pressure."""
    return float(wing_at(0.0).K_I.min() / TOUGHNESS)


FORMULA = "K_I = 2 a tau_eff sin(theta)/sqrt(pi (l + 0.27 a)) - sigma_w sqrt(pi l), Horii, Nemat-Nasser 1986"
SHORT = (
    "the formula is an estimate between l = 0 and l >> a; for wings of half of a its K_I is low, by 10 % even without "
    "lateral pressure: the row by elements below tells what is the program's"
)
ELEMENTS = "same path in an infinite plate, tests/verification/wing_elements.py; the case has 160 x 120 mm"


def _elements_row(percent: float, tolerance: float) -> Row:
    return Row(
        "confined30",
        f"length at arrest, lateral pressure {percent:g} %: relative difference",
        0.0,
        "independent code",
        ELEMENTS,
        tolerance,
        lambda: off_elements(wing_at(percent), percent),
        "at most",
    )


def _arrest_row(percent: float, known: str = "") -> Row:
    return Row(
        "confined30",
        f"length at arrest, lateral pressure {percent:g} % [mm]",
        1e3 * model(percent).arrest_length(TOUGHNESS),
        "published",
        FORMULA,
        0.2,
        partial(arrest, percent),
        known=known,
    )


ROWS = [
    Row(
        "confined30",
        "length at arrest, as it is, lateral pressure 5 % [mm]",
        1e3 * model(5.0).arrest_length(TOUGHNESS),
        "published",
        FORMULA,
        0.2,
        arrest_as_shipped,
    ),
    _arrest_row(2.0),
    _arrest_row(5.0),
    _arrest_row(10.0, SHORT),
    Row(
        "confined30",
        "length at arrest, as it is, lateral pressure 5 %: relative difference",
        0.0,
        "independent code",
        ELEMENTS,
        0.08,
        lambda: off_elements(as_shipped(), 5.0),
        "at most",
    ),
    _elements_row(2.0, 0.2),
    _elements_row(5.0, 0.08),
    _elements_row(10.0, 0.08),
    Row(
        "confined30",
        "largest ratio of the lengths at arrest from one pressure to the next of 2, 5, 10 %",
        1.0,
        "published",
        "more pressure, shorter wings",
        0.0,
        largest_ratio,
        "at most",
    ),
    Row(
        "confined30",
        "least K_I/K_c without lateral pressure, up to wings longer than at 2 %",
        1.0,
        "published",
        "no arrest before 44 mm in an infinite plate",
        0.0,
        least_K_unconfined,
        "at least",
    ),
]
