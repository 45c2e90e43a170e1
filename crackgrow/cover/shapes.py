"""Bodies and cracks in lattice coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case.surface import SurfaceName
from crackgrow.geometry.polyline import tip_direction
from crackgrow.geometry.tolerance import SAME_PLACE

if TYPE_CHECKING:
    from crackgrow.case.model import Body


IN_LINE = -0.9999
"""Cosine between the outward directions of two lines that go on in each other, within 0.8 degrees."""


@dataclass(frozen=True, slots=True, eq=False)
class CrackGeometry:
    """A crack in lattice coordinates, or an interface or a foundation, which have no tips."""

    name: SurfaceName
    points: Floats  # (n, 2)
    tip_at_start: bool
    tip_at_end: bool
    joined: NDArray[np.bool_] | None = None  # (n,) which vertices are junctions with other lines; None: not known yet
    gathered: bool = False  # whether the functions of its tips are gathered where there is room

    @property
    def junctions(self) -> NDArray[np.bool_]:
        """Which vertices (n,) are junctions with other lines."""
        return np.zeros(len(self.points), dtype=bool) if self.joined is None else self.joined

    def tips(self) -> list[bool]:
        """The ends that are tips: False for the start, True for the end."""
        return [at_end for at_end, tip in ((False, self.tip_at_start), (True, self.tip_at_end)) if tip]

    def seen_from(self, at_end: bool) -> Floats:
        """Its vertices (n, 2) from the end, or from the start, on."""
        return np.asarray(self.points[::-1] if at_end else self.points)


def ends_at_bonds(lines: Sequence[CrackGeometry]) -> Iterator[tuple[int, bool]]:
    """The tips of cracked interfaces among lines: a line's number, and whether it is its end.

    They are the ends in line with what is bonded between the same bodies.
    """
    bonds = [line for line in lines if line.name.kind == "bond"]
    for number, line in enumerate(lines):
        for at_end in (False, True) if line.name.kind == "interface" else ():
            tip, outward = line.seen_from(at_end)[0], tip_direction(line.points, at_end)
            for bond, its_end in product(bonds, (False, True)):
                apart = np.abs(bond.seen_from(its_end)[0] - tip).max()
                in_line = outward @ tip_direction(bond.points, its_end) < IN_LINE
                if bond.name.of == line.name.of and apart < SAME_PLACE and in_line:
                    yield number, at_end


def body_index(bodies: Sequence[BodyGeometry | Body], name: str) -> int:
    """Number of the body of that name."""
    return next(index for index, body in enumerate(bodies) if body.name == name)


Roots = tuple[complex, complex]
"""Of the characteristic equation of plane elasticity, with positive imaginary parts: Lekhnitskii 1963, section 7."""


SAME_ROOT = 1e-7
"""Roots that differ by less are equal: of a double root round-off leaves as much."""


def is_isotropic(roots: Roots) -> bool:
    """Whether rock with these roots is isotropic in the plane."""
    return max(abs(root - 1j) for root in roots) < SAME_ROOT


def turned_roots(roots: Roots, axes: Floats) -> Roots:
    """The roots in other axes, whose directions are the rows of (2, 2)."""
    c, s = axes[0].tolist()
    first, last = ((root * c - s) / (c + root * s) for root in roots)
    return first, last


@dataclass(frozen=True, slots=True, eq=False)
class BodyGeometry:
    """A body in lattice coordinates: its outline counter-clockwise, its holes clockwise."""

    rings: tuple[Floats, ...]  # each (n, 2), not closed
    name: str = ""
    roots: Roots = (1j, 1j)  # of its rock: isotropic

    @property
    def sides(self) -> Floats:
        """Both ends (n, 2, 2) of all sides, ring by ring; the body lies on their left."""
        return np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in self.rings])

    @property
    def region(self) -> shapely.Polygon:
        """The body as a polygon."""
        return shapely.Polygon(self.rings[0], self.rings[1:])
