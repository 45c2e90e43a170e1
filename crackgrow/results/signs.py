"""What holds and what loads a scene, as signs of structural drawings: places in metres, y upwards, for any drawing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case import model
from crackgrow.case.formula import CoordinateFormula, component_at
from crackgrow.case.model import Body, Case, Component
from crackgrow.case.segments import nearest_places
from crackgrow.results.places import component_text, length_unit, lines_of, size_of

ARROW, SIGN = 0.10, 0.035  # of the scene's size: lengths of the longest arrow of a load, of a support
GAP, SHEAR_GAP = 0.008, 0.03  # of the scene's size: from an edge to the arrows across and along it
APART, SHEAR_APART = 0.08, 0.14  # of the scene's size: from arrow to arrow
HOLE: Final = 3.0  # a hole is drawn on as if a scene were no larger than this times its width
MOST_ARROWS: Final = 14  # along an edge
SHEAR: Final = 0.5  # sine of the angle to an edge below which a traction runs along it
SEEN: Final = 0.2  # of the longest arrow of a load: shorter ones are left out
AWAY: Final = 1.35  # of an arrow's length: how far from an edge the words of its load stand

Kind = Literal["support", "ground", "hatch", "load", "given", "law"]
"""What is drawn alike: supports, their ground, loads, prescribed displacements, words of contact laws."""


@dataclass(frozen=True, slots=True, eq=False)
class Strokes:
    """Straight lines, ends (n, 2, 2) m."""

    ends: Floats
    kind: Kind


@dataclass(frozen=True, slots=True, eq=False)
class Polygon:
    """A closed shape, corners (n, 2) m."""

    corners: Floats
    kind: Kind


@dataclass(frozen=True, slots=True, eq=False)
class Circle:
    """A wheel."""

    center: Floats  # (2,) m
    radius: float  # m
    kind: Kind


@dataclass(frozen=True, slots=True, eq=False)
class Arrow:
    """A straight arrow."""

    tail: Floats  # (2,) m
    head: Floats  # (2,) m
    kind: Kind


@dataclass(frozen=True, slots=True, eq=False)
class Words:
    """What is written beside."""

    place: Floats  # (2,) m, their middle
    text: str
    kind: Kind
    upright: bool = False


Mark = Strokes | Polygon | Circle | Arrow


@dataclass(frozen=True, slots=True, eq=False)
class Sign:
    """A support or a load: its marks, what they are in a few words, and with which values."""

    title: str
    marks: tuple[Mark, ...]
    words: tuple[Words, ...] = ()


def support_signs(case: Case) -> Iterator[Sign]:
    """Triangles, wheels and ground of all supports, and the displacements that they prescribe."""
    size = size_of(case)
    for support in case.supports:
        if isinstance(support, model.PointSupport):
            roller = None in support.displacement
            marks = _triangle(support.point, _outward_at(case, support), SIGN * size, roller=roller)
            words = _given_words(case, support.displacement, support.point)
            yield Sign(f"held point of {support.body}", tuple(marks), words)
        else:
            yield _edge_sign(case, support, size)


def load_signs(case: Case) -> Iterator[Sign]:
    """Arrows and values of all loads but in-situ stresses, which fill a body: words tell them."""
    size = size_of(case)
    for load in case.loads:
        sign = _load_sign(case, load, size)
        if sign is not None:
            yield sign


def _edge_sign(case: Case, support: model.EdgeSupport | model.ContactSupport, size: float) -> Sign:
    """Ground or wheels along an edge."""
    stretches = _stretches(case, support.region, SIGN * size)
    marks: list[Mark] = []
    for line, outward in stretches:
        if isinstance(support, model.EdgeSupport) and None in support.displacement:
            marks += _rollers(line, outward, 0.6 * SIGN * size)
        else:
            marks += _ground(line + 0.004 * size * outward, outward, 0.7 * SIGN * size)
    line, outward = stretches[len(stretches) // 2]
    edge = f"{support.region.body}.{support.region.edge}"
    if isinstance(support, model.ContactSupport):
        place = line.mean(axis=0) + 0.075 * size * outward
        law = Words(place, f"rigid foundation, μ = {support.contact.friction:g}", "law")
        return Sign(f"rigid foundation under {edge}", tuple(marks), (law,))
    places = _spread(stretches, APART * size)
    moved = np.column_stack([_values(c, np.array([place for place, _ in places])) for c in support.displacement])
    longest = float(np.hypot(*moved.T).max())
    if longest > 0.0:
        arms = ARROW * size * moved / longest
        seen = np.hypot(*arms.T) > SEEN * ARROW * size
        tails = [place for place, _ in places]
        marks += [Arrow(tail, tail + arm, "given") for tail, arm, shown in zip(tails, arms, seen, strict=True) if shown]
    words = _given_words(case, support.displacement, line.mean(axis=0) + 0.05 * size * outward)
    return Sign(f"held: {edge}", tuple(marks), words)


def _load_sign(case: Case, load: model.Load, size: float) -> Sign | None:
    held = ", held" if load.held else ""
    reach = ARROW * size
    if isinstance(load, model.FarField):
        return _far_field(case, load, size)
    if isinstance(load, model.EdgeLoad):
        return _traction(case, load, size, held)
    if isinstance(load, model.Gravity) and any(load.acceleration):
        outline = _body(case, load.body).outline
        middle, way = (outline.min(axis=0) + outline.max(axis=0)) / 2, _unit(load.acceleration)
        text = f"g = {np.hypot(*load.acceleration):g} m/s²{held}"
        words = Words(middle + 1.3 * reach * way, text, "load")
        return Sign(f"gravity on {load.body}", (Arrow(middle, middle + reach * way, "load"),), (words,))
    if isinstance(load, model.PointForce) and any(load.force):
        way = reach * _unit(load.force)
        words = Words(load.point - 1.3 * way, f"F = {np.hypot(*load.force):g} N/m{held}", "load")
        return Sign(f"force on {load.body}", (Arrow(load.point - way, load.point, "load"),), (words,))
    if isinstance(load, model.FluidPressure):
        return _pressure(case, load, size, held)
    return None


def _pressure(case: Case, load: model.FluidPressure, size: float, held: str) -> Sign:
    """Arrows off both faces of a crack or an interface."""
    marks: list[Mark] = []
    lines = lines_of(case, load.surface)
    for points in lines:
        chord = points[-1] - points[0] if np.any(points[-1] != points[0]) else points[1] - points[0]
        across = 0.4 * ARROW * size * np.array([-1.0, 1.0]) * _unit(chord[::-1])
        places = _spread(_straight(points), APART * size)
        marks += [Arrow(place, place + side, "load") for place, _ in places for side in (-across, across)]
    place = np.concatenate(lines).mean(axis=0) - [0.0, 0.06 * size]
    words = Words(place, f"p = {component_text(load.pressure)}{held}", "load")
    return Sign(f"pressure in {load.surface}", tuple(marks), (words,))


def _far_field(case: Case, load: model.FarField, size: float) -> Sign:
    """Arrows all round a body; words tell the stress."""
    places = _spread(_stretches(case, load.region, APART * size), APART * size, most=None)
    return Sign(f"far field round {load.body}", _traction_arrows(load, places, GAP * size, ARROW * size))


def _traction(case: Case, load: model.EdgeTraction | model.EdgePressure, size: float, held: str) -> Sign | None:
    """Arrows along an edge that push on it or pull at it, or, where they only shear it, run beside it."""
    hole, below = _hole_of(case, load.region), 0.05 * size
    if hole is not None:
        size = min(size, HOLE * float(np.ptp(hole, axis=0).min()))
    stretches = _stretches(case, load.region, APART * size)
    _, middle = stretches[len(stretches) // 2]
    ends = np.concatenate([line for line, _ in stretches])
    mean = np.array([_typical(along) for along in load.traction_at(ends, np.tile(middle, (len(ends), 1))).T])
    if not mean.any():
        return None
    shears = abs(float(_unit(mean) @ middle)) < SHEAR
    places = _spread(stretches, (SHEAR_APART if shears else APART) * size)
    points = [support for support in case.supports if isinstance(support, model.PointSupport)]
    taken = [support.point + 0.8 * SIGN * size * _outward_at(case, support) for support in points]
    free = [(p, o) for p, o in places if all(np.hypot(*(p - sign)) > 1.1 * SIGN * size for sign in taken)]
    gap = size * (SHEAR_GAP if shears else GAP if free else 1.7 * SIGN)  # where signs leave no room: outside of them
    marks = _traction_arrows(load, free or places, gap, ARROW * size)
    line, outward = stretches[len(stretches) // 2]  # two loads on an edge are mostly one across and one along it
    away = AWAY * ARROW * size + (0.0 if free else gap)
    place = line[0] + (0.25 if shears else 0.5) * (line[1] - line[0]) + away * outward
    if isinstance(load, model.EdgePressure):
        what, given, values = "pressure", "p", component_text(load.pressure)
    else:
        what, given = "traction", ", ".join(f"t{axis}" for axis, value in zip("xy", mean, strict=True) if value)
        values = ", ".join(component_text(of) for of, value in zip(load.traction, mean, strict=True) if value)
    if hole is not None:
        place = np.array([np.mean(hole[:, 0]), hole[:, 1].min() - below])
    words = Words(place, f"{given} = {values}{held}", "load", upright=hole is None and abs(outward[0]) > SHEAR)
    return Sign(f"{what} on {load.region.body}.{load.region.edge}", marks, (words,))


def _traction_arrows(
    load: model.EdgeLoad, places: Sequence[tuple[Floats, Floats]], gap: float, reach: float
) -> tuple[Arrow, ...]:
    """An arrow for each place and its outward direction, as long as the traction there is large."""
    points, outwards = (np.array(of) for of in zip(*places, strict=True))
    traction = load.traction_at(points, outwards)
    strength = np.hypot(*traction.T)
    if not strength.any():
        return ()
    arrows = []
    for (place, outward), way in zip(places, reach * traction / strength.max(), strict=True):
        length = float(np.hypot(*way))
        if length < SEEN * reach:
            continue
        across, tail = float(way @ outward) / length, place + gap * outward
        tail = tail - way / 2 if abs(across) < SHEAR else tail - way if across < 0 else tail
        arrows.append(Arrow(tail, tail + way, "load"))
    return tuple(arrows)


def _triangle(point: Floats, outward: Floats, size: float, *, roller: bool) -> list[Mark]:
    """A support at a point: a triangle towards `outward`, on ground or, as a roller, on wheels."""
    along = np.array([-outward[1], outward[0]])
    base = point + size * outward
    marks: list[Mark] = [Polygon(np.array([point, base + 0.6 * size * along, base - 0.6 * size * along]), "support")]
    if roller:
        wheels = [base + 0.18 * size * outward + place * size * along for place in (-0.35, 0.35)]
        marks += [Circle(center, 0.17 * size, "support") for center in wheels]
        base = base + 0.36 * size * outward
    return [*marks, *_ground(np.array([base - 0.9 * size * along, base + 0.9 * size * along]), outward, 0.35 * size)]


def _ground(line: Floats, outward: Floats, size: float) -> list[Mark]:
    """Solid ground: a line (2, 2) with strokes on its outer side."""
    along = line[1] - line[0]
    length = float(np.hypot(*along))
    n = max(2, round(length / (0.9 * size)))
    feet = line[0] + ((np.arange(n) + 0.75) / n)[:, None] * along
    slant = (outward - along / max(length, 1e-300)) * size
    return [Strokes(line[None], "ground"), Strokes(np.stack([feet, feet + slant], axis=1), "hatch")]


def _rollers(line: Floats, outward: Floats, size: float) -> list[Mark]:
    """An edge (2, 2) that slides along rigid ground: wheels between the two."""
    places = _spread([(line, outward)], 2.0 * size, most=None)
    wheels = [Circle(place + 0.5 * size * outward, 0.4 * size, "support") for place, _ in places]
    return [*wheels, *_ground(line + size * outward, outward, 0.8 * size)]


def _given_words(
    case: Case, displacement: tuple[Component | None, Component | None], place: Floats
) -> tuple[Words, ...]:
    """Displacements other than zero, as numbers or formulas."""
    scale, unit = length_unit(case)
    words = []
    for axis, value in zip("xy", displacement, strict=True):
        if isinstance(value, float | int) and value:
            words.append(f"u{axis} = {value * scale:.4g} {unit}")
        elif isinstance(value, CoordinateFormula):
            words.append(f"u{axis} = {value.text[:40]} [m]")
    above = place + np.array([0.0, 0.04 * size_of(case)])
    return (Words(above, ", ".join(words), "given"),) if words else ()


def _values(component: Component | None, places: Floats) -> Floats:
    """A component (n,) of a displacement at places (n, 2); 0 where it is free."""
    return np.zeros(len(places)) if component is None else component_at(component, places)


def _typical(values: Floats) -> float:
    """The mean; what it has no sign of is told by the largest value."""
    return float(values.mean() if values.mean() != 0.0 else values[np.argmax(np.abs(values))])


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
    """The parts of a line (n, 2) with their right-hand normals."""
    parts = np.stack([points[:-1], points[1:]], axis=1)
    return [(part, _unit((part[1] - part[0])[::-1] * [1.0, -1.0])) for part in parts]


def _hole_of(case: Case, region: model.EdgeRegion) -> Floats | None:
    """The ring (n, 2) m of the hole that an edge bounds; none on an outline."""
    outline, *holes = [ring.points for ring in _body(case, region.body).rings]
    last = len(outline) + np.cumsum([len(hole) for hole in holes])
    number = int(np.searchsorted(last, region.sides[0], side="right"))
    return holes[number] if holes and region.sides[0] >= len(outline) else None


def _stretches(case: Case, region: model.EdgeRegion, shortest: float) -> list[tuple[Floats, Floats]]:
    """Straight parts of an edge, ends (2, 2) m, with their unit normals (2,) out of the rock.

    Sides of an arc or another smooth edge are taken together until they are no shorter than `shortest`.
    """
    body = _body(case, region.body)
    starts = np.concatenate([ring.points for ring in body.rings])
    stops = np.concatenate([np.roll(ring.points, -1, axis=0) for ring in body.rings])
    found, waiting = [], np.empty((0, 2))
    for side, (first, last) in zip(region.sides, region.limits, strict=True):
        a, b = starts[side], stops[side]
        waiting = np.vstack([waiting[:1], [a + first * (b - a), a + last * (b - a)]])
        line = waiting[[0, -1]]
        length = float(np.hypot(*(line[1] - line[0])))
        if length >= shortest or (side == region.sides[-1] and length > 0.0):
            found += [(part, outward) for part, outward in _straight(line)]  # rock is on the left of an outline
            waiting = np.empty((0, 2))
    return found


def _outward_at(case: Case, support: model.PointSupport) -> Floats:
    """Where the ground of a support at a point is: across what it holds, outside of the rock where that has a side."""
    outward = _outside(_body(case, support.body), support.point)
    held = np.array([component is not None for component in support.displacement], dtype=float)
    direction = outward if held.all() else held
    along = float(direction @ outward)
    return -direction if along < 0.0 or abs(along) < SHEAR else direction  # along the edge: from left, or from below


def _outside(body: Body, point: Floats) -> Floats:
    """Outward direction (2,) of the side of a body that is next to a point.

    At a corner the side that is nearest to horizontal counts: supports stand below or above rather than beside.
    """
    best: list[tuple[float, float, Floats]] = []
    extent = float(np.ptp(body.outline, axis=0).max())
    for ring in body.rings:
        sides = np.stack([ring.points, np.roll(ring.points, -1, axis=0)], axis=1)
        along = sides[:, 1] - sides[:, 0]
        along /= np.hypot(*along.T)[:, None]
        distance = np.hypot(*(nearest_places(point, sides) - point).T)
        best.extend(zip(np.round(distance / extent, 6), np.round(np.abs(along[:, 1]), 6), along, strict=True))
    _, _, side = min(best, key=lambda item: item[:2])
    return np.array([side[1], -side[0]])


def _body(case: Case, name: str) -> Body:
    return next(body for body in case.bodies if body.name == name)
