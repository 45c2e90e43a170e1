"""Cracks as they are given: cut where they leave the rock; lines of maps become cracks that meet as they mean to."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Final

import numpy as np
import shapely
from shapely import LineString
from shapely.ops import substring

from crackgrow.case.joining import Thing, crack_thing, joined, rims_of, unstacked
from crackgrow.case.layout import ENDS_WITH_TIP, Scene, named, points_of
from crackgrow.case.map_file import Feature, attribute
from crackgrow.case.mesh_file import LONGEST_NAME, ContentError
from crackgrow.case.model import Cut, Move
from crackgrow.case.report import Place, did_you_mean, quoted
from crackgrow.case.schema import MOST_ITEMS
from crackgrow.case.shapes import Resolved, without_repeats

LONGEST: Final = 50  # name of a set: with a number or an attribute and another number it is still that of a crack
OUTSIDE: Final = "outside of the rock"
MOST_ROUNDS: Final = 5  # of taking out what runs along and joining the rest; two do nearly always
NO_NAME: Final = re.compile(r"[^\w-]")  # signs of an attribute that a name has not


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """A part of a line of a map."""

    crack: Resolved  # of its set
    name: str  # of its line
    trace: Feature
    line: LineString
    tolerance: float  # m


def place_ends_and_sets(scene: Scene) -> None:
    """Cut cracks where they end outside of the rock, and put the cracks NAME-1, NAME-2, ... in the place of each set.

    Ends that lie on something are no tips. What is changed goes into the lists of the scene.
    """
    cracks = named(scene.resolved, "cracks")
    sound = [name for name in cracks if scene.report.sound("cracks", name)]
    sets = [name for name in sound if "traces" in cracks[name]["path"]]
    single = [name for name in sound if name not in sets]
    for name in single:
        if "contact_by" in cracks[name]:
            message = "is for lines of a map; one crack has its law in `contact`"
            scene.report.fault(("cracks", name, "contact_by"), message)
    if not scene.complete:  # the faults of its bodies are told
        for name in sets:
            del cracks[name]
        return
    rock = shapely.union_all([body.polygon for body in scene.bodies.values()])
    for name in single:
        _cut_ends(scene, name, cracks[name], rock)
    given = {name: points_of(cracks[name]["path"]) for name in single}
    fixed = [crack_thing(name, line) for name, line in given.items() if len(line) > 1]
    pieces = [piece for name in sets for piece in _pieces(scene, name, cracks[name], rock)]
    made = _cracks_of(scene, pieces, [*rims_of(scene.bodies.values()), *fixed])
    every: dict[str, Any] = {}
    for name, crack in cracks.items():
        every.update(_made_of_set(scene, name, made) if name in sets else {name: crack})
    if len(every) > max(MOST_ITEMS, len(cracks)):
        scene.report.fault(("cracks",), f"sets make {len(every)} cracks of it; wanted: {MOST_ITEMS} at most")
    cracks.clear()
    cracks.update(every)


def _made_of_set(scene: Scene, name: str, made: dict[str, tuple[_Piece, Resolved]]) -> dict[str, Resolved]:
    """The cracks that a set has become, and in the report their places; reports what is wrong with them."""
    cracks, places = named(scene.resolved, "cracks"), scene.report.places
    _check_laws(scene, name, cracks[name])
    found, file = {}, cracks[name]["path"]["file"].text
    for new, (piece, crack) in made.items():
        if piece.crack is not cracks[name]:
            continue
        if new in cracks:
            scene.report.fault(("cracks", new), f"is the name of a crack of the set '{name}'; choose another")
        places["cracks", new] = places.get(("cracks", name), Place(scene.report.source, 1))
        line = piece.trace.line
        places["cracks", new, "path"] = Place(file if line else f"{file}, {piece.trace.where}", line)
        found[new] = crack
    if not found:
        scene.report.fault(("cracks", name, "path", "file"), "none of its lines lies in the rock")
    return found


def _cut_ends(scene: Scene, name: str, crack: Resolved, rock: shapely.Geometry) -> None:
    """Cut a crack where it ends in a hole or outside of the outline, if all the rest of it lies in the rock."""
    points = points_of(crack["path"])
    if len(points) < 2:
        return
    line, outside = LineString(points), ~shapely.dwithin(shapely.points(points[[0, -1]]), rock, scene.reach)
    parts = _inside(line, rock, scene.reach)
    if not outside.any() or len(parts) != 1:
        return
    inside = shapely.get_coordinates(parts[0])
    first, last = (line.project(shapely.Point(inside[k])) for k in (0, -1))
    lost = {"start": (0.0, first), "end": (last, line.length)}
    off = [end for end, is_off in zip(lost, outside, strict=True) if is_off]
    scene.cuts.extend(_cut(name, substring(line, *lost[end]), OUTSIDE) for end in off)
    tips = [end for end in ENDS_WITH_TIP[crack["tips"]] if end not in off]
    crack |= {"path": {"points": list(map(scene.units.coordinates, inside.tolist()))}, "tips": _word(tips)}


def _pieces(scene: Scene, name: str, crack: Resolved, rock: shapely.Geometry) -> Iterator[_Piece]:
    """The lines of a map, in parts that lie in one body and do not cross themselves; lists what of them is left out."""
    path, key = crack["path"], ("cracks", name)
    traces, tolerance = path["traces"], path.get("tolerance", scene.reach)
    if len(name) > LONGEST:
        scene.report.fault(key, f"the name of a set has {LONGEST} letters at most")
    labels = [str(number) for number in range(1, len(traces) + 1)]
    if "names" in path:
        try:
            labels = [NO_NAME.sub("_", word)[:LONGEST] for word in attribute(traces, path["names"])]
        except ContentError as error:
            scene.report.fault((*key, "path", "names"), f"{quoted(path['file'].text)} {error}")
    for trace, label in zip(traces, labels, strict=True):
        full = f"{name}-{label}"[:LONGEST_NAME]
        given = shapely.get_coordinates(trace.shape)
        points = given[without_repeats(given, closed=False)]
        repeats = len(given) - len(points)
        line = LineString(points if len(points) > 1 else [points[0], points[0]])
        if line.length <= tolerance:
            why = "is shorter than the tolerance" if line.length else "has no length"
            scene.cuts.append(_cut(full, line, why, trace.where, whole=True))
            continue
        simple = _simple(line)
        start = LineString([points[0], points[0]])  # nothing of its length is lost
        if repeats:
            scene.cuts.append(_cut(full, start, f"{repeats} of its vertices repeat others", trace.where))
        if len(simple) > 1:
            scene.cuts.append(_cut(full, start, "meets itself, and is divided there", trace.where))
        inside = [_inside(part, body.polygon, tolerance) for part in simple for body in scene.bodies.values()]
        found = [part for parts in inside for part in parts]
        lost = line.length - sum(part.length for part in found)
        if lost > scene.tolerance:
            longest = max(shapely.get_parts(line.difference(rock)), key=shapely.length, default=line)
            cut = _cut(full, longest, OUTSIDE, trace.where, whole=not found)
            scene.cuts.append(replace(cut, length=float(lost)))
        found.sort(key=lambda part: float(line.project(shapely.Point(part.coords[0]))))
        yield from (_Piece(crack, full, trace, part, tolerance) for part in found)


def _simple(line: LineString) -> list[LineString]:
    """A line in parts that do not meet themselves."""
    if line.is_simple and not line.is_ring:
        return [line]
    parts = shapely.get_parts(shapely.node(line))
    halves = [(part, (0.0, 0.5, 1.0) if part.is_ring else (0.0, 1.0)) for part in parts]
    return [substring(part, *ends, normalized=True) for part, places in halves for ends in pairwise(places)]


def _inside(line: LineString, rock: shapely.Geometry, least: float) -> list[LineString]:
    """The parts of a line in the rock that are longer than `least` (m), in the direction of the line."""
    parts = [part for part in shapely.get_parts(line.intersection(rock)) if part.length > least]
    return sorted(parts, key=lambda part: float(line.project(shapely.Point(part.coords[0]))))


def _cracks_of(scene: Scene, pieces: list[_Piece], fixed: Sequence[Thing]) -> dict[str, tuple[_Piece, Resolved]]:
    """The cracks that lines of maps become, with their names, without what runs along others, and joined to them."""
    named_pieces: dict[str, _Piece] = {}
    moves: list[Move] = []
    for rounds in range(MOST_ROUNDS):  # what is joined may run along
        left = _unstacked(scene, pieces, fixed)
        if rounds > 0 and left is pieces:
            break
        by_name: dict[str, list[_Piece]] = defaultdict(list)
        for piece in left:
            by_name[piece.name].append(piece)
        named_pieces = {
            name if len(parts) == 1 else f"{name}-{k}": part
            for name, parts in by_name.items()
            for k, part in enumerate(parts, 1)
        }
        lines = {name: points_of({"points": its.line.coords}, its.tolerance) for name, its in named_pieces.items()}
        reach = {name: (its.tolerance, its.tolerance) for name, its in named_pieces.items()}
        lines, moves = joined(lines, reach, fixed, scene.tolerance)
        scene.moves.extend(moves)
        named_pieces = {name: replace(its, line=LineString(lines[name])) for name, its in named_pieces.items()}
        pieces = list(named_pieces.values())
    found, on_something = {}, {move.end for move in moves}
    for name, piece in named_pieces.items():
        tips = [end for end in ENDS_WITH_TIP[piece.crack["tips"]] if (name, end) not in on_something]
        rest = {key: value for key, value in piece.crack.items() if key != "contact_by"}
        path = {"points": list(map(scene.units.coordinates, piece.line.coords))}
        found[name] = piece, {**rest, "path": path, "tips": _word(tips), "contact": _law(piece)}
    return found


def _unstacked(scene: Scene, pieces: list[_Piece], fixed: Sequence[Thing]) -> list[_Piece]:
    """The pieces without what runs along rims, given cracks and longer pieces; they themselves if nothing does."""
    tree = shapely.STRtree([piece.line for piece in pieces])
    left: dict[int, list[LineString]] = {}
    for number in sorted(range(len(pieces)), key=lambda number: (-pieces[number].line.length, number)):
        piece = pieces[number]
        near = {*tree.query(piece.line, predicate="dwithin", distance=piece.tolerance).tolist()}
        longer = [other for other in left if other in near]  # the longest first
        things = [crack_thing(pieces[k].name, np.array(part.coords)) for k in longer for part in left[k]]
        left[number], gone = unstacked(piece.line, [*fixed, *things], piece.tolerance)
        for part, words in gone:
            whole = len(gone) == 1 and not left[number]
            scene.cuts.append(_cut(piece.name, part, f"runs along {words}", piece.trace.where, whole=whole))
    if all(lines == [piece.line] for piece, lines in zip(pieces, map(left.get, range(len(pieces))), strict=True)):
        return pieces
    return [replace(piece, line=line) for number, piece in enumerate(pieces) for line in left[number]]


def _law(piece: _Piece) -> object:
    """The law of contact of a crack by an attribute of its line, else that of its set."""
    for name, laws in piece.crack.get("contact_by", {}).items():
        value = piece.trace.attributes.get(name, "")
        if value in laws:
            return laws[value]
    return piece.crack["contact"]


def _check_laws(scene: Scene, name: str, crack: Resolved) -> None:
    """Report laws by an attribute, or for values of one, that no line has."""
    traces = crack["path"]["traces"]
    for key, laws in crack.get("contact_by", {}).items():
        where = ("cracks", name, "contact_by", key)
        try:
            words = attribute(traces, key)
        except ContentError as error:
            scene.report.fault(where, f"{quoted(crack['path']['file'].text)} {error}")
            continue
        for value in [value for value in laws if value not in words]:
            scene.report.fault((*where, value), f"no line has the {key} {quoted(value)}{did_you_mean(value, words)}")


def _cut(name: str, part: LineString, why: str, where: str = "", *, whole: bool = False) -> Cut:
    """That a part of a crack is left out."""
    x, y = part.interpolate(0.5, normalized=True).coords[0]
    return Cut(name, float(part.length), whole, (float(x), float(y)), why, where)


def _word(tips: Sequence[str]) -> str:
    """How ends with a tip are written."""
    return "both" if len(tips) == 2 else tips[0] if tips else "none"
