"""Stress intensity factors from the displacement of the crack faces.

Near a tip slip and opening are 8 H k sqrt(r / 2 pi) (1 + c r / L + ...), k = (K_II, K_I), with H that is 1/E' in
isotropic rock (`PlaneElasticity.release`); K is the limit of a least-squares fit over the last straight stretch.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.faces import FacePoints, joined, points_at, stretch_ends
from crackgrow.contact.jump import gap_and_slip
from crackgrow.cover.cover import Cover
from crackgrow.solid.elasticity import PlaneElasticity

FIT_CELLS = 3.0
"""The fit reaches this many cells back from the tip, to the end of the last stretch, or to half of the crack."""

FIT_TERMS = 3
"""Terms of the fit in powers of r: K and two corrections."""

FIT_POINTS = 24
"""Sample points of the fit."""


def from_face_displacements(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, tips: Sequence[int]
) -> list[tuple[float, float]]:
    """K_I and K_II (Pa sqrt(m)) of `tips` of the cover; `u` (n_dofs,) m.

    K_II is positive where the face on the left of the tip's outward direction moves outward: a positive slip at both
    ends of a crack. A negative K_II turns the crack counter-clockwise.
    """
    if not tips:
        return []
    x, weights = _fit()
    ends = {crack: stretch_ends(cover, crack) for crack in dict.fromkeys(cover.tips[tip].crack for tip in tips)}
    lengths, samples = zip(*(_samples(cover, tip, ends[cover.tips[tip].crack], x) for tip in tips), strict=True)
    jumps = np.split(np.stack(gap_and_slip(cover, joined(samples), u), axis=1), len(tips))
    found = []
    for number, length, jump in zip(tips, lengths, jumps, strict=True):
        tip = cover.tips[number]
        fit = weights @ jump[:, ::-1] / 8.0 * np.sqrt(2.0 * np.pi / (length * cover.lattice.spacing))
        K_II, K_I = np.linalg.solve(materials[tip.body].turned(tip.rotation).release, fit).tolist()
        found.append((K_I, K_II))
    return found


@cache
def _fit() -> tuple[Floats, Floats]:
    """Places x (n,) on a unit length, and weights (n,) of values there for the factor of sqrt(x) in their best fit."""
    x = (np.arange(FIT_POINTS) + 0.5) / FIT_POINTS
    return x, np.linalg.pinv((x[:, None] ** np.arange(FIT_TERMS)) * np.sqrt(x)[:, None])[0]


def _samples(cover: Cover, tip: int, ends: Floats, x: Floats) -> tuple[float, FacePoints]:
    """Length (spacings) of the fit of a tip, and points on the faces at fractions x (n,) of it from the tip.

    `ends` (m + 1,) are those of the stretches of its crack.
    """
    crack, at_end, total = cover.tips[tip].crack, cover.tips[tip].at_end, ends[-1]
    stretch = ends[-1] - ends[-2] if at_end else ends[1] - ends[0]
    length = float(min(stretch, FIT_CELLS * cover.tips[tip].size, 0.5 * total))
    r = length * x
    return length, points_at(cover, crack, total - r if at_end else r)
