"""The cracked part of an interface that has a toughness, and its growth along the interface.

Its criticality is sqrt(G / G_c), with G the energy release rate along the interface (`fracture.interface_tips`): as K
over K_c it is in proportion to loads.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.ops import substring

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Case
from crackgrow.case.segments import STRAIGHT
from crackgrow.case.surface import SurfaceName, numbered
from crackgrow.fracture.advance import CLEARANCE, GrowingCrack
from crackgrow.geometry.polyline import arc_lengths, kink_angles
from crackgrow.geometry.tolerance import SAME_PART

TOUCHES = 1e-6
"""Increments: what is so close to the interface lies on it, but for round-off."""

FROM_CORNERS = 0.5
"""Increments: closer to a corner of the interface a tip does not stop: G needs a disc in which that is straight."""


@dataclass(frozen=True, slots=True, eq=False)
class Debond:
    """A cracked part of an interface."""

    bodies: tuple[str, str]
    line: Floats  # (n, 2) m, the first body on its left
    toughness: float  # J/m^2
    at: Floats  # (k,) m, rising: arc lengths on the line to which its ends have come
    steps: Ints  # (k,) in these steps; 0: as it was given

    @property
    def is_as_given(self) -> bool:
        """Whether it has not grown."""
        return not self.steps.any()

    @property
    def points(self) -> Floats:
        """Its vertices (m, 2) m, from start to end."""
        return _part(self.line, self.at[0], self.at[-1])

    @property
    def path(self) -> tuple[Floats, Ints]:
        """Its vertices (m, 2) m with the ends to which it came, and the step (m,) whose advance has made each."""
        line, along = shapely.LineString(self.line), arc_lengths(self.line)
        corners = along[np.abs(along[:, None] - self.at).min(axis=1) > SAME_PART * along[-1]]
        s = np.union1d(self.at, corners[(corners > self.at[0]) & (corners < self.at[-1])])
        places = shapely.get_coordinates(shapely.line_interpolate_point(line, s))
        after, before = np.searchsorted(self.at, s), np.searchsorted(self.at, s, side="right") - 1
        return places, np.maximum(self.steps[before], self.steps[after])

    @property
    def given(self) -> Floats:
        """Where (2,) m from its start the ends of what was given lie."""
        return np.asarray(self.at[np.flatnonzero(self.steps == 0)[[0, -1]]] - self.at[0])

    def n_advances(self, at_end: bool) -> int:
        """How often it has grown at its end (or start)."""
        first, last = np.flatnonzero(self.steps == 0)[[0, -1]]
        return int(len(self.steps) - 1 - last if at_end else first)

    def advanced(self, at_end: bool, increment: float, step: int, ends: shapely.Geometry) -> tuple[Debond, bool]:
        """It after it has grown at its end (or start) by some increment (m), and whether it has reached something.

        It ends with the line, and on the next of the `ends` (m) of others that lie on this. Within half an increment of
        a corner the length is another one by at most that.
        """
        line, sign = shapely.LineString(self.line), 1.0 if at_end else -1.0
        turns = np.flatnonzero(np.abs(kink_angles(self.line)) > STRAIGHT) + 1
        others = shapely.points(shapely.get_coordinates(ends))
        touching = others[shapely.distance(line, others) < TOUCHES * increment]
        stops = np.append(shapely.line_locate_point(line, touching), [0.0, line.length])
        tip = float(self.at[-1 if at_end else 0])
        ahead = stops[(stops - tip) * sign > CLEARANCE * increment]
        to = tip + sign * increment
        stop = float(ahead[np.argmin(np.abs(ahead - tip))]) if len(ahead) else tip
        if (stop - to) * sign < CLEARANCE * increment:
            return self._reaching(at_end, stop, step), True
        corners = np.sort([*arc_lengths(self.line)[turns], *stops])
        first, last = corners[corners <= to].max(), corners[corners >= to].min()
        away = FROM_CORNERS * min(increment, last - first)
        return self._reaching(at_end, float(np.clip(to, first + away, last - away)), step), False

    def _reaching(self, at_end: bool, to: float, step: int) -> Debond:
        """It with its end (or start) at an arc length."""
        place = len(self.at) if at_end else 0
        return replace(self, at=np.insert(self.at, place, to), steps=np.insert(self.steps, place, step))


def debonds_of(case: Case) -> Iterator[Debond]:
    """The cracked parts of interfaces with a toughness, as they are given."""
    for number, interface in enumerate(case.interfaces):
        for part in () if interface.toughness is None or interface.beside_crack else interface.lines:
            lines, ends = [shapely.LineString(line) for line in interface.boundary], shapely.points(part[[0, -1]])
            nearest = int(np.argmin([float(shapely.distance(line, ends).max()) for line in lines]))
            at = shapely.line_locate_point(lines[nearest], ends)
            yield debond_on(case, (number, nearest), at, np.zeros(2, dtype=np.int64))


def ends_of(cracks: Sequence[GrowingCrack], debonds: Sequence[Debond]) -> shapely.Geometry:
    """The ends (m) of cracks and debonds, on which others end."""
    lines = (*(growing.crack.points for growing in cracks), *(debond.points for debond in debonds))
    return shapely.MultiPoint([point for line in lines for point in line[[0, -1]]])


def debond_on(case: Case, place: tuple[int, int], at: Floats, steps: Ints) -> Debond:
    """A debond on a line: the numbers of its interface, and of the line in the boundary of that."""
    interface = case.interfaces[place[0]]
    assert interface.toughness is not None
    return Debond(interface.bodies, interface.boundary[place[1]], interface.toughness, at, steps)


def place_of(case: Case, debond: Debond) -> tuple[int, int]:
    """The numbers of its interface, and of the line that it lies on."""
    number = next(n for n, interface in enumerate(case.interfaces) if interface.bodies == debond.bodies)
    return number, next(n for n, line in enumerate(case.interfaces[number].boundary) if line is debond.line)


def names_of(debonds: Sequence[Debond]) -> list[SurfaceName]:
    """Their names: those of one interface have numbers."""
    return numbered([SurfaceName("interface", debond.bodies) for debond in debonds])


def debond_number(debonds: Sequence[Debond], name: SurfaceName) -> int | None:
    """The number of the debond that a surface is; None: it is none."""
    mine = [number for number, debond in enumerate(debonds) if debond.bodies == name.of]
    return mine[name.number or 0] if mine and name.kind == "interface" else None


def bonds(boundary: Sequence[Floats], debonds: Sequence[Debond]) -> Iterator[Floats]:
    """What is bonded (m, 2) m of the lines of a boundary."""
    for line in boundary:
        mine = sorted((each.at[[0, -1]] for each in debonds if each.line is line), key=lambda at: float(at[0]))
        ends = [0.0, *np.concatenate([np.zeros(0), *mine]).tolist(), float(arc_lengths(line)[-1])]
        for first, last in zip(ends[::2], ends[1::2], strict=True):
            if last > first:
                yield line if first == 0.0 and last == ends[-1] else _part(line, first, last)


def _part(line: Floats, first: float, last: float) -> Floats:
    return np.asarray(shapely.get_coordinates(substring(shapely.LineString(line), first, last)))
