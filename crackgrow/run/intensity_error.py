"""A bound of what K_I and K_II of a tip are off by, from what was measured to drive it.

The spread over discs of different radii tells of the integral alone; the displacement that it integrates is the larger
part of the error. With the K of two displacements,

    K_slip    = E' w sqrt(pi / a) / 4      of a straight crack as long as this one, a = L/2, with its largest jump w
    K_overlap = E' o sqrt(pi / h) / 4      of a crack as long as two cells that opens by what the faces overlap, o

the bound is

    spread + q K_overlap + (0.005 + max(k h / l) + 0.02 (h / L)^2) max(K_slip, K) + 0.03 sqrt(h / d) K + P

q: 6, and 1 at a tip that is well open, K_I > 8 K_overlap, where what overlaps lies beside the kink behind it.
h: side of the cells there: round the tip, at a kink, where the faces overlap.
o: overlap of the faces where it is worst, that s > 5 h from the tip times (5 h / s)^2: there contact, which holds on
average, is not resolved (short closed stretches, kinks, faces that stick).
l: at each kink of more than 20 degrees the longer of the two stretches that meet there; k: 0.25 where one of them is
pressed, else 0.05. Kinks have no functions of their own.

The square is of cracks below three cells. The term with d is there where something lies closer than a cell, d, to the
tip. P is what K_II alone is off by, by cohesion, where faces part between contact points (`run.parting`).

Fitted and checked in tests/verification/test_intensity_error.py: it holds for 95 % of tips; the median of bound over
error is 3 there, and 12 on random scenes. It is no estimate for one tip.
"""

from __future__ import annotations

import numpy as np

from crackgrow.contact.coulomb import OPEN
from crackgrow.cover.tips import Tip
from crackgrow.fracture.tip_disc import KEPT_CLEAR, SHARP
from crackgrow.geometry.polyline import arc_lengths, kink_angles
from crackgrow.run.judging import StepSolution
from crackgrow.run.misfit import unexplained
from crackgrow.run.parting import partings
from crackgrow.run.result import CrackFaces
from crackgrow.run.scene import Scene

AT_CLOSED_TIP, AT_OPEN_TIP, WELL_OPEN = 6.0, 1.0, 8.0
CLOSED_KINK, OPEN_KINK = 0.25, 0.05
LEAST, OF_LENGTH, OF_CROWDING = 0.005, 0.02, 0.03
NEAR = 5.0
"""Cells from the tip along the crack from which on overlap is felt less."""


def intensity_errors(solution: StepSolution, faces: tuple[CrackFaces, ...]) -> list[tuple[float, float]]:
    """Bounds (Pa sqrt(m)) of the errors of K_I and K_II, tip by tip; nan where K is."""
    scene, cover = solution.scene, solution.cover
    found, missed = [], partings(solution.state, solution.tips)
    for state, tip, end in zip(solution.tips, cover.tips, cover.tip_ends, strict=True):
        intensity, face = state.intensity, faces[tip.crack]
        h = tip.size * scene.lattice.spacing
        length = float(arc_lengths(tip.points)[-1])
        stiff = scene.materials[scene.crack_bodies[tip.crack]].young_prime
        jump = float(np.hypot(face.opening, face.slip).max())
        slip = 0.25 * stiff * jump * np.sqrt(np.pi / (0.5 * length * scene.lattice.spacing))
        largest = max(abs(intensity.K_I), abs(intensity.K_II))
        share = LEAST + largest_kink(solution, tip) + OF_LENGTH * (tip.size / length) ** 2
        of_overlap = 0.25 * stiff * _overlap(scene, face, tip)
        weight = AT_OPEN_TIP if WELL_OPEN * of_overlap < intensity.K_I else AT_CLOSED_TIP
        bound = weight * of_overlap + share * max(slip, largest)
        clear = intensity.radius / (KEPT_CLEAR * h)
        if intensity.small and clear < 1.0:
            bound += OF_CROWDING * largest / np.sqrt(clear)
        found.append((float(intensity.K_I_spread + bound), float(intensity.K_II_spread + bound + missed[end].lost)))
    return found


def _overlap(scene: Scene, face: CrackFaces, tip: Tip) -> float:
    """o sqrt(pi / h), root of m, where it is worst for a tip."""
    law, h = scene.laws[tip.crack], face.cell_size
    if law.contact is None:
        return 0.0
    spacing = scene.lattice.spacing
    cells = tip.from_start(face.s / spacing) * spacing / h
    felt = np.minimum(1.0, NEAR / np.maximum(cells, NEAR)) ** 2
    return -float((felt * unexplained(law, face) * np.sqrt(np.pi / h)).min(initial=0.0))


def largest_kink(solution: StepSolution, tip: Tip) -> float:
    """Largest weight of a kink of a tip's crack, times h / l.

    A kink with closed faces on either side is a pressed corner; an open one bends faces that are free.
    """
    sharp = np.abs(kink_angles(tip.points)) > SHARP
    if not sharp.any():
        return 0.0
    lengths = arc_lengths(tip.points)
    closed = (solution.faces.surface == tip.crack) & (solution.outcome.points.state != OPEN)
    pressed = tip.from_start(solution.faces.s[closed])  # from the tip: each of the two lengths gives the other so
    ends = np.concatenate([[0.0], lengths[1:-1][sharp], lengths[-1:]])
    sizes = solution.cover.surfaces[tip.crack].in_cells.size(tip.from_start(ends))
    worst = 0.0
    for k in range(1, len(ends) - 1):
        any_closed = bool(np.any((pressed >= ends[k - 1]) & (pressed <= ends[k + 1])))
        longer = max(ends[k] - ends[k - 1], ends[k + 1] - ends[k])
        worst = max(worst, (CLOSED_KINK if any_closed else OPEN_KINK) * float(sizes[k] / longer))
    return worst
