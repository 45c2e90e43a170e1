"""Stress intensity factors from the displacement of the crack faces.

Near a tip the opening is 8 K_I / E' sqrt(r / 2 pi) (1 + c r / L + ...), the slip likewise with K_II; K is the limit of
a least-squares fit over the last straight stretch.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crackgrow.contact.faces import points_at, stretch_ends
from crackgrow.contact.jump import gap_and_slip
from crackgrow.cover.cover import Cover

Floats = NDArray[np.float64]

FIT_SPACINGS = 3.0
"""The fit reaches this many spacings back from the tip, to the end of the last stretch, or to half of the crack."""

FIT_TERMS = 3
"""Terms of the fit in powers of r: K and two corrections."""

FIT_POINTS = 24
"""Sample points of the fit."""


def from_face_displacement(cover: Cover, young_prime: float, u: Floats, tip: int) -> tuple[float, float]:
    """K_I and K_II (Pa sqrt(m)) of tip number `tip`; `young_prime` is E' (Pa), `u` (n_dofs,) m.

    K_II is positive where the face on the left of the tip's outward direction moves outward: a positive slip at both
    ends of a crack. A negative K_II turns the crack counter-clockwise.
    """
    crack, at_end = cover.tip_ends[tip]
    ends = stretch_ends(cover.surfaces[crack])
    total = ends[-1]
    length = float(min(ends[-1] - ends[-2] if at_end else ends[1] - ends[0], FIT_SPACINGS, 0.5 * total))
    x = (np.arange(FIT_POINTS) + 0.5) / FIT_POINTS
    r = length * x
    points = points_at(cover, crack, total - r if at_end else r)
    gap, slip = gap_and_slip(cover, points, u)
    powers = (x[:, None] ** np.arange(FIT_TERMS)) * np.sqrt(r)[:, None]
    opening_fit, slip_fit = np.linalg.lstsq(powers, np.stack([gap, slip], axis=1))[0][0]
    factor = young_prime / 8.0 * np.sqrt(2.0 * np.pi / cover.lattice.spacing)
    return float(opening_fit * factor), float(slip_fit * factor)
