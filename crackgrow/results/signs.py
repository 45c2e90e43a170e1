"""What holds and what loads a scene, drawn as signs of structural drawings; m, y upwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle, Patch, Polygon
from matplotlib.text import Text

from crackgrow.arrays import Floats
from crackgrow.case import model
from crackgrow.case.formula import CoordinateFormula, component_at
from crackgrow.case.model import Body, Case, Component
from crackgrow.case.on_map import length_unit
from crackgrow.results.units import component_text

ARROW, SIGN = 0.10, 0.035  # of the scene's size: lengths of the longest arrow of a load, of a support
GAP, SHEAR_GAP = 0.008, 0.03  # of the scene's size: from an edge to the arrows across and along it
APART, SHEAR_APART = 0.08, 0.14  # of the scene's size: from arrow to arrow
HOLE: Final = 3.0  # a hole is drawn on as if a scene were no larger than this times its width
MOST_ARROWS: Final = 14  # along an edge
SHEAR: Final = 0.5  # sine of the angle to an edge below which a traction runs along it
SEEN: Final = 0.2  # of the longest arrow of a load: shorter ones are left out
AWAY: Final = 1.35  # of an arrow's length: how far from an edge the words of its load stand

SUPPORT, LOAD, GIVEN, LAW = "0.25", "#b2182b", "#1b7837", "#762a83"
"""Colours of supports and their ground, of loads, of prescribed displacements, of words of contact laws."""


@dataclass(slots=True, eq=False)
class Sheet:
    """What a case is drawn on; places are (2,) m, lines (n, 2) m."""

    axes: Axes
    case: Case
    size: float  # m, of the scene
    title: str = ""  # of the sign that is drawn
    labels: list[Text] = field(default_factory=list)

    @property
    def titled(self) -> dict[str, Any]:
        """What marks an artist as one of the sign that is drawn."""
        return {"gid": f"title: {self.title}"} if self.title else {}

    def strokes(self, ends: Floats, width: float) -> None:
        """Straight lines (n, 2, 2) m of a support."""
        looks: dict[str, Any] = {"colors": SUPPORT, "linewidths": width, "capstyle": "butt", "zorder": 5, **self.titled}
        self.axes.add_collection(LineCollection(list(ends), **looks), autolim=False)

    def shape(self, patch: Patch) -> None:
        """A triangle or a wheel of a support."""
        patch.set(facecolor="white", edgecolor=SUPPORT, linewidth=1.0, zorder=5, **self.titled)
        self.axes.add_patch(patch)

    def arrow(self, tail: Floats, head: Floats, colour: str = LOAD) -> None:
        """A straight arrow."""
        style = {"shrinkA": 0.0, "shrinkB": 0.0, "arrowstyle": "-|>", "color": colour, "linewidth": 0.9}
        style |= {"mutation_scale": 7, **self.titled}
        self.axes.annotate("", head.tolist(), tail.tolist(), arrowprops=style, zorder=6, annotation_clip=False)

    def label(self, point: Floats, text: str, colour: str = "black", **looks: Any) -> None:
        """Small words on a white ground, centred unless `looks` say otherwise; they may be moved."""
        ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
        looks = {"ha": "center", "va": "center", "zorder": 8, "bbox": ground, **looks}
        self.labels.append(self.axes.text(point[0], point[1], text, fontsize=7.5, color=colour, **looks))

    def draw_support(self, support: model.Support) -> None:
        """Draw the triangle, wheels and ground of a support, and the displacement that it prescribes."""
        if isinstance(support, model.PointSupport):
            self.title = f"held point of {support.body}"
            roller = None in support.displacement
            self._triangle(support.point, self._outward_at(support), roller=roller)
            self._given_words(support.displacement, support.point)
            return
        edge, size = f"{support.region.body}.{support.region.edge}", self.size
        self.title = f"{'held:' if isinstance(support, model.EdgeSupport) else 'rigid foundation under'} {edge}"
        stretches = self._stretches(support.region, SIGN * size)
        for line, outward in stretches:
            if isinstance(support, model.EdgeSupport) and None in support.displacement:
                wheel = 0.6 * SIGN * size  # between the edge and rigid ground
                for place, _ in _spread([(line, outward)], 2.0 * wheel, most=None):
                    self.shape(Circle((place + 0.5 * wheel * outward).tolist(), 0.4 * wheel))
                self._ground(line + wheel * outward, outward, 0.8 * wheel)
            else:
                self._ground(line + 0.004 * size * outward, outward, 0.7 * SIGN * size)
        line, outward = stretches[len(stretches) // 2]
        if isinstance(support, model.ContactSupport):
            words = f"rigid foundation, μ = {support.contact.friction:g}"
            if any(support.moves):
                middle = line.mean(axis=0)
                self.arrow(middle - ARROW * size * _unit(support.moves), middle, GIVEN)
            self.label(line.mean(axis=0) + 0.075 * size * outward, words, LAW)
            return
        places = np.array([place for place, _ in _spread(stretches, APART * size)])
        free = np.zeros(len(places))
        moved = np.column_stack([free if of is None else component_at(of, places) for of in support.displacement])
        longest = float(np.hypot(*moved.T).max())
        for tail, way in zip(places, moved / (longest or 1.0), strict=True):
            if np.hypot(*way) > SEEN:
                self.arrow(tail, tail + ARROW * size * way, GIVEN)
        self._given_words(support.displacement, line.mean(axis=0) + 0.05 * size * outward)

    def draw_load(self, load: model.Load) -> None:
        """Draw the arrows and values of a load; of an in-situ stress, which fills a body, nothing."""
        case, size, reach = self.case, self.size, ARROW * self.size
        held = ", held" if load.held else ""
        if isinstance(load, model.FarField):  # words tell the stress
            self.title = f"far field round {load.body}"
            places = _spread(self._stretches(load.region, APART * size), APART * size, most=None)
            self._traction_arrows(load, places, GAP * size, reach)
        elif isinstance(load, model.EdgeLoad):
            self._traction(load, held)
        elif isinstance(load, model.Gravity) and any(load.acceleration):
            self.title = f"gravity on {load.body}"
            outline = self._body(load.body).outline
            middle, way = (outline.min(axis=0) + outline.max(axis=0)) / 2, _unit(load.acceleration)
            self.arrow(middle, middle + reach * way)
            self.label(middle + 1.3 * reach * way, f"g = {np.hypot(*load.acceleration):g} m/s²{held}", LOAD)
        elif isinstance(load, model.PointForce) and any(load.force):
            self.title = f"force on {load.body}"
            way = reach * _unit(load.force)
            self.arrow(load.point - way, load.point)
            self.label(load.point - 1.3 * way, f"F = {np.hypot(*load.force):g} N/m{held}", LOAD)
        elif isinstance(load, model.FluidPressure | model.FluidVolume):  # off both faces of a crack or an interface
            if isinstance(load, model.FluidVolume):
                self.title, words = f"volume in {load.surface}", f"V = {1e6 * load.volume:g} mm²"
            else:
                self.title, words = f"pressure in {load.surface}", f"p = {component_text(load.pressure)}{held}"
            lines = [crack.points for crack in case.cracks if crack.surface == load.surface]
            lines = lines or [
                line for pair in case.interfaces if pair.surface.is_of(load.surface) for line in pair.lines
            ]
            for points in lines:
                chord = points[-1] - points[0] if np.any(points[-1] != points[0]) else points[1] - points[0]
                across = 0.4 * reach * np.array([-1.0, 1.0]) * _unit(chord[::-1])
                for place, _ in _spread(_straight(points), APART * size):
                    self.arrow(place, place - across)
                    self.arrow(place, place + across)
            place = np.concatenate(lines).mean(axis=0) - [0.0, 0.06 * size]
            self.label(place, words, LOAD)

    def _traction(self, load: model.EdgeTraction | model.EdgePressure, held: str) -> None:
        """Arrows along an edge that push on it or pull at it, or, where they only shear it, run beside it."""
        case, size = self.case, self.size
        hole, below = self._hole_of(load.region), 0.05 * size
        if hole is not None:
            size = min(size, HOLE * float(np.ptp(hole, axis=0).min()))
        stretches = self._stretches(load.region, APART * size)
        line, outward = stretches[len(stretches) // 2]
        ends = np.concatenate([part for part, _ in stretches])
        along = load.traction_at(ends, np.tile(outward, (len(ends), 1)))
        mean = np.where(along.mean(axis=0) != 0.0, along.mean(axis=0), along[np.abs(along).argmax(axis=0), [0, 1]])
        if not mean.any():
            return
        shears = abs(float(_unit(mean) @ outward)) < SHEAR
        places = _spread(stretches, (SHEAR_APART if shears else APART) * size)
        points = [support for support in case.supports if isinstance(support, model.PointSupport)]
        taken = [support.point + 0.8 * SIGN * size * self._outward_at(support) for support in points]
        free = [(p, o) for p, o in places if all(np.hypot(*(p - sign)) > 1.1 * SIGN * size for sign in taken)]
        outside = 1.7 * SIGN  # of signs that leave no room
        gap = size * (SHEAR_GAP if shears else GAP if free else outside)
        self.title = f"traction on {load.region.body}.{load.region.edge}"
        if isinstance(load, model.EdgePressure):
            self.title, words = self.title.replace("traction", "pressure"), f"p = {component_text(load.pressure)}"
        else:
            acts = [(axis, of) for axis, of, value in zip("xy", load.traction, mean, strict=True) if value]
            words = f"{', '.join(f't{axis}' for axis, _ in acts)} = {', '.join(component_text(of) for _, of in acts)}"
        self._traction_arrows(load, free or places, gap, ARROW * size)
        # two loads on an edge are mostly one across and one along it
        place = line[0] + (0.25 if shears else 0.5) * (line[1] - line[0])
        place = place + (AWAY * ARROW * size + (0.0 if free else gap)) * outward
        if hole is not None:
            place = np.array([np.mean(hole[:, 0]), hole[:, 1].min() - below])
        upright = hole is None and abs(outward[0]) > SHEAR
        self.label(place, f"{words}{held}", LOAD, rotation=90.0 if upright else 0.0)

    def _traction_arrows(
        self, load: model.EdgeLoad, places: Sequence[tuple[Floats, Floats]], gap: float, reach: float
    ) -> None:
        """An arrow for each place and its outward direction, as long as the traction there is large."""
        points, outwards = (np.array(of) for of in zip(*places, strict=True))
        traction = load.traction_at(points, outwards)
        longest = float(np.hypot(*traction.T).max())
        for place, outward, way in zip(points, outwards, reach * traction / (longest or 1.0), strict=True):
            length = float(np.hypot(*way))
            if length < SEEN * reach:
                continue
            across, tail = float(way @ outward) / length, place + gap * outward
            tail = tail - way / 2 if abs(across) < SHEAR else tail - way if across < 0 else tail
            self.arrow(tail, tail + way)

    def _triangle(self, point: Floats, outward: Floats, *, roller: bool) -> None:
        """A support at a point: a triangle towards `outward`, on ground or, as a roller, on wheels."""
        size = SIGN * self.size
        along = np.array([-outward[1], outward[0]])
        base = point + size * outward
        self.shape(Polygon(np.array([point, base + 0.6 * size * along, base - 0.6 * size * along])))
        if roller:
            for place in (-0.35, 0.35):
                center = base + 0.18 * size * outward + place * size * along
                self.shape(Circle(center.tolist(), 0.17 * size))
            base = base + 0.36 * size * outward
        self._ground(np.array([base - 0.9 * size * along, base + 0.9 * size * along]), outward, 0.35 * size)

    def _ground(self, line: Floats, outward: Floats, size: float) -> None:
        """Solid ground: a line (2, 2) with strokes on its outer side."""
        along = line[1] - line[0]
        length = float(np.hypot(*along))
        n = max(2, round(length / (0.9 * size)))
        feet = line[0] + ((np.arange(n) + 0.75) / n)[:, None] * along
        slant = (outward - along / max(length, 1e-300)) * size
        self.strokes(line[None], 1.2)
        self.strokes(np.stack([feet, feet + slant], axis=1), 0.6)

    def _given_words(self, displacement: tuple[Component | None, Component | None], place: Floats) -> None:
        """Displacements other than zero, as numbers or formulas."""
        scale, unit = length_unit(self.case)
        words = []
        for axis, value in zip("xy", displacement, strict=True):
            if isinstance(value, float | int) and value:
                words.append(f"u{axis} = {value * scale:.4g} {unit}")
            elif isinstance(value, CoordinateFormula):
                words.append(f"u{axis} = {value.text[:40]} [m]")
        if words:
            self.label(place + np.array([0.0, 0.04 * self.size]), ", ".join(words), GIVEN)

    def _hole_of(self, region: model.EdgeRegion) -> Floats | None:
        """The ring (n, 2) m of the hole that an edge bounds; none on an outline."""
        rings = self._body(region.body).rings
        last = np.cumsum([len(ring.points) for ring in rings])
        number = int(np.searchsorted(last, region.sides[0], side="right"))
        return rings[number].points if number else None

    def _stretches(self, region: model.EdgeRegion, shortest: float) -> list[tuple[Floats, Floats]]:
        """Straight parts of an edge, ends (2, 2) m, with their unit normals (2,) out of the rock.

        Sides of an arc or another smooth edge are taken together until they are no shorter than `shortest`.
        """
        sides, found, waiting = self._body(region.body).sides, [], np.empty((0, 2))
        for side, limits in zip(region.sides, region.limits, strict=True):
            a, b = sides[side]
            waiting = np.vstack([waiting[:1], [a + share * (b - a) for share in limits]])
            line = waiting[[0, -1]]
            length = float(np.hypot(*(line[1] - line[0])))
            if length >= shortest or (side == region.sides[-1] and length > 0.0):
                found += _straight(line)
                waiting = np.empty((0, 2))
        return found

    def _outward_at(self, support: model.PointSupport) -> Floats:
        """Where the ground of a support at a point is: across what it holds, outside of the rock if that has a side."""
        outward = _outside(self._body(support.body), support.point)
        held = np.array([component is not None for component in support.displacement], dtype=float)
        direction = outward if held.all() else held
        along = float(direction @ outward)
        # along the edge: from left, or from below
        return -direction if along < 0.0 or abs(along) < SHEAR else direction

    def _body(self, name: str) -> Body:
        return next(body for body in self.case.bodies if body.name == name)


def _unit(vector: object) -> Floats:
    way = np.asarray(vector, dtype=float)
    return way / max(float(np.hypot(*way)), 1e-300)


def _spread(
    stretches: Sequence[tuple[Floats, Floats]], gap: float, most: int | None = MOST_ARROWS
) -> list[tuple[Floats, Floats]]:
    """Places (2,) along stretches, two at least and about `gap` apart, with the outward directions."""
    lengths = np.array([float(np.hypot(*(line[1] - line[0]))) for line, _ in stretches])
    ends = np.cumsum(lengths)
    n = max(2, round(ends[-1] / gap))
    n = n if most is None else min(n, most)
    places = []
    for place in (np.arange(n) + 0.5) / n * ends[-1]:
        number = min(int(np.searchsorted(ends, place)), len(stretches) - 1)
        line, outward = stretches[number]
        places.append((line[1] - (ends[number] - place) / lengths[number] * (line[1] - line[0]), outward))
    return places


def _straight(points: Floats) -> list[tuple[Floats, Floats]]:
    """The parts of a line (n, 2) with their right-hand normals: rock is on the left of an outline."""
    parts = np.stack([points[:-1], points[1:]], axis=1)
    return [(part, _unit((part[1] - part[0])[::-1] * [1.0, -1.0])) for part in parts]


def _outside(body: Body, point: Floats) -> Floats:
    """Outward direction (2,) of the side of a body that is next to a point.

    At a corner the side that is nearest to horizontal counts: supports stand below or above rather than beside.
    """
    sides = body.sides
    along = (sides[:, 1] - sides[:, 0]) / np.hypot(*(sides[:, 1] - sides[:, 0]).T)[:, None]
    distance = shapely.distance(shapely.linestrings(sides), shapely.Point(point)) / np.ptp(body.outline, axis=0).max()
    first = np.lexsort([np.round(np.abs(along[:, 1]), 6), np.round(distance, 6)])[0]
    return np.array([along[first, 1], -along[first, 0]])
