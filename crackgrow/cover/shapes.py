"""Bodies and cracks in lattice coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case.surface import SurfaceName

if TYPE_CHECKING:
    from crackgrow.case.model import Body


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


def body_index(bodies: Sequence[BodyGeometry | Body], name: str) -> int:
    """Number of the body of that name."""
    return next(index for index, body in enumerate(bodies) if body.name == name)


@dataclass(frozen=True, slots=True, eq=False)
class BodyGeometry:
    """A body in lattice coordinates: its outline counter-clockwise, its holes clockwise."""

    rings: tuple[Floats, ...]  # each (n, 2), not closed
    name: str = ""

    @property
    def sides(self) -> Floats:
        """Both ends (n, 2, 2) of all sides, ring by ring; the body lies on their left."""
        return np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in self.rings])

    @property
    def region(self) -> shapely.Polygon:
        """The body as a polygon."""
        return shapely.Polygon(self.rings[0], self.rings[1:])
