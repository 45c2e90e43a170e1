"""A bound of what K_I and K_II of a tip are off by, from what was measured to drive it.

The spread over discs of different radii tells of the integral alone; the displacement that it integrates is the larger
part of the error. With the K of two displacements,

    K_slip    = E' w sqrt(pi / a) / 4      of a straight crack as long as this one, a = L/2, with its largest jump w
    K_overlap = E' o sqrt(pi / h) / 4      of a crack as long as two spacings that opens by what the faces overlap, o

the bound is

    spread + 4 K_overlap + (0.005 + 0.25 max(h / l) + 0.02 (h / L)^2) max(K_slip, K) + 0.03 sqrt(h / d) K

o: largest overlap of the faces, that s > 5 spacings h from the tip times (5 h / s)^2: there contact, which holds on
average, is not resolved (short closed stretches, kinks, faces that stick). l: at each kink of more than 20 degrees the
longer of the two stretches that meet there: kinks have no functions of their own. The square is of cracks below three
spacings. The last term is there where something lies closer than a spacing, d, to the tip.

Fitted and checked in tests/verification/test_intensity_error.py: it holds for 95 % of tips; the median of bound over
error is 4 there, and 10 on random scenes. It is no estimate for one tip.
"""

from __future__ import annotations

import numpy as np

from crackgrow.fracture.tip_disc import KEPT_CLEAR
from crackgrow.geometry.polyline import arc_lengths, kink_angles
from crackgrow.run.result import CrackFaces
from crackgrow.run.scene import Scene
from crackgrow.run.step import StepSolution

OF_OVERLAP, LEAST, OF_KINKS, OF_LENGTH, OF_CROWDING = 4.0, 0.005, 0.25, 0.02, 0.03
NEAR = 5.0
"""Spacings from the tip along the crack from which on overlap is felt less."""

KINK = 20.0
"""Degrees."""


def intensity_errors(scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...]) -> list[tuple[float, float]]:
    """Bounds (Pa sqrt(m)) of the errors of K_I and K_II, tip by tip; nan where K is."""
    cover, h = solution.cover, scene.lattice.spacing
    found = []
    for state, (index, at_end) in zip(solution.tips, cover.tip_ends, strict=True):
        intensity, face = state.intensity, faces[index]
        points = cover.cracks[index].points[::-1] if at_end else cover.cracks[index].points
        length = float(arc_lengths(points)[-1])
        stiff = scene.materials[scene.crack_bodies[index]].young_prime
        jump = float(np.hypot(face.opening, face.slip).max())
        slip = 0.25 * stiff * jump * np.sqrt(np.pi / (0.5 * length * h))
        largest = max(abs(intensity.K_I), abs(intensity.K_II))
        from_tip = length - face.s / h if at_end else face.s / h
        closed = scene.laws[index].contact is not None
        gap = face.opening - scene.laws[index].compliance * face.normal_traction
        felt = np.minimum(1.0, NEAR / np.maximum(from_tip, NEAR)) ** 2
        overlap = -float((felt * gap).min(initial=0.0)) if closed else 0.0
        share = LEAST + OF_KINKS * _kinks(points) + OF_LENGTH / length**2
        bound = OF_OVERLAP * 0.25 * stiff * overlap * np.sqrt(np.pi / h) + share * max(slip, largest)
        clear = intensity.radius / (KEPT_CLEAR * h)
        if intensity.shrunk and clear < 1.0:
            bound += OF_CROWDING * largest / np.sqrt(clear)
        found.append((float(intensity.K_I_spread + bound), float(intensity.K_II_spread + bound)))
    return found


def _kinks(points: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> float:
    """Largest h / l of the kinks of a crack (n, 2), spacings; 0 where it has none."""
    sharp = np.abs(np.rad2deg(kink_angles(points))) > KINK
    if not sharp.any():
        return 0.0
    lengths = arc_lengths(points)
    stretches = np.diff(np.concatenate([[0.0], lengths[1:-1][sharp], lengths[-1:]]))
    return float((1.0 / np.maximum(stretches[:-1], stretches[1:])).max())
