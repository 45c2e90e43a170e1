"""What files and curves draw, outlines and cracks, brought to the unit and the origin of the case.

A file of a map holds one polygon, perhaps with holes, or the lines of many cracks; a mesh holds regions, names of their
edges, and curves.

Arcs and splines become vertices of a path, between which a crack is straight. K of a tip goes by the direction of the
last segment: one that is off by 1.4 degrees, as that of a half circle of 64 equal segments, puts K_I off by 3.6 %. So
the last segments are tangents of the curve, and those beside them shorter than in the middle. Segments there turn by so
little that what ends on the curve ends on them within the tolerance of a scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np
import shapely

from crackgrow.arrays import Floats, Ints
from crackgrow.case import map_file, mesh_file
from crackgrow.case.layout import named
from crackgrow.case.map_file import Feature, attribute, features_of
from crackgrow.case.mesh_file import ContentError, PlaneMesh, read_mesh
from crackgrow.case.reader import Node, Scalar
from crackgrow.case.report import Path, clean, listed, quoted
from crackgrow.case.scalars import Context, refuse
from crackgrow.case.shapes import Resolved
from crackgrow.case.units import UNITS, QuantityError

MOST_CORNERS: Final = 5000  # of an outline; a disk has 360
MOST_LINES: Final = 1000  # of a set of cracks

MOST_TURN: Final = np.deg2rad(1.0)  # rad, from one segment to the next in the middle of a curve
LEAST_TURN: Final = np.deg2rad(0.5)  # rad, at its ends: K of a half circle is within 1e-3
NEAR_END: Final = 0.1  # of its length: so near to an end segments turn by less, in proportion to the distance from it
STRAIGHT: Final = 0.01  # segments that a part of a curve would have: with less it is straight
FEWEST: Final = 3  # segments of an arc, or between two places of a spline
SAMPLES: Final = 4000  # steps along a curve at which its direction is taken
FEWEST_SAMPLES: Final = 20  # the same between two places of a spline

Corners = list[list[float]]  # m, not closed

TEXTS: Final = (".geojson", ".json", ".wkt")


@dataclass(frozen=True, slots=True)
class File:
    """The name of a file with an outline, or with the lines of cracks, relative to the folder of the case file."""

    of_cracks: bool = False

    @property
    def endings(self) -> tuple[str, ...]:
        """How the names of such files end."""
        return (*TEXTS, *((".csv",) if self.of_cracks else ()), *map_file.GDAL, *mesh_file.ENDINGS)

    def describe(self) -> str:
        content = "lines" if self.of_cracks else "one polygon"
        maps = ", ".join(ending for ending in self.endings if ending not in (".json", *mesh_file.ENDINGS))
        return f"the name of a file with {content} ({maps}), or of a mesh ({', '.join(mesh_file.ENDINGS)})"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the file; what it holds is read together with the keys beside it."""
        if not isinstance(node, Scalar) or node.is_null or not node.text.strip():
            return refuse(node, self.describe(), path, context)
        file = context.folders.get(node.place.source, context.folder) / node.text
        try:
            if file.suffix.lower() not in self.endings:
                raise ContentError(f"ends in {quoted(file.suffix)}")
            return GivenFile(file, node.text, read_mesh(file) if file.suffix.lower() in mesh_file.ENDINGS else None)
        except ContentError as error:
            return context.refused(path, f"{quoted(node.text)} {error}; wanted: {self.describe()}")


@dataclass(frozen=True, slots=True)
class GivenFile:
    """A file of a case, with what the keys beside it say of it."""

    path: FilePath
    text: str  # its name as it is given
    mesh: PlaneMesh | None


def _corners(points: Floats, unit: str | None, given: Mapping[str, Any], context: Context) -> Corners:
    """Points (n, 2) of a file in m of the case, whose unit it has if None is told; raises QuantityError.

    given: the file with the keys beside it
    """
    metres = UNITS["length"][unit or context.units.length]
    own = [Fraction(repr(along)) * metres for along in given.get("origin", (0.0, 0.0))]
    return [
        [context.units.along(repr(value), metres, axis, own[axis]) for axis, value in enumerate(point)]
        for point in points.tolist()
    ]


def read_drawings(case: Resolved, context: Context) -> None:
    """Put what files and curves draw in the place of their names: outlines and edges of bodies, paths of cracks."""
    sound = context.report.sound
    for name, body in named(case, "bodies").items():
        key = ("bodies", name, "shape")
        if sound(*key):
            _read_outline(body, key, context)
    for name, crack in named(case, "cracks").items():
        key = ("cracks", name, "path")
        if sound(*key) and crack["path"].keys() & {"arc", "spline"}:
            crack["path"] = curve_points(crack["path"], key, context)
        elif sound(*key) and "file" in crack["path"]:
            crack["path"] = _file_points(crack["path"], key, context)


def _read_outline(body: Resolved, key: Path, context: Context) -> None:
    """Put polygons in the place of files in a shape; holes and names of edges come with them, before its own."""
    shape, report = body["shape"], context.report
    holes = shape.get("holes", [])
    for index, hole in enumerate(holes):
        where = (*key, "holes", index)
        if "file" in hole and (found := _outline_of(hole, where, context)):
            holes[index] = {"polygon": found[0][0]}
            if len(found[0]) > 1:
                report.fault((*where, "file"), "the polygon has holes; wanted for a hole: a polygon without any")
    if "file" in shape and (found := _outline_of(shape, key, context)):
        (outline, *inner), edges = found
        every = [*({"polygon": ring} for ring in inner), *holes]
        body["shape"] = {"polygon": outline} | ({"holes": every} if every else {})
        if edges and report.sound(*key[:2], "edges"):
            body["edges"] = {**edges, **body.get("edges", {})}


def _file_points(value: Resolved, path: Path, context: Context) -> object:
    """The path with the points of a curve of a mesh, or with the traces of a map, in the place of the file."""
    file, curve = value["file"], value.get("curve")
    if file.mesh is None:
        try:
            traces = _traces(file, value, context)
            if curve is None:
                return {**value, "traces": traces}
            return context.refused((*path, "curve"), "the file has lines and no curves; a mesh has some")
        except (ContentError, QuantityError) as error:
            return context.refused((*path, "file"), f"{quoted(file.text)} {error}")
    others = [key for key in value if key not in ("file", "curve", "units", "origin")]
    if others:
        return context.refused((*path, others[0]), "is for lines of a map; a curve of a mesh is one crack")
    if curve is None:
        return context.refused((*path, "curve"), "missing: name or number of a group of the mesh's lines (a text)")
    try:
        return {"points": _corners(file.mesh.path(curve), value.get("units"), value, context)}
    except (ContentError, QuantityError) as error:
        return context.refused((*path, "curve"), f"the mesh {error}")


def _traces(file: GivenFile, value: Mapping[str, Any], context: Context) -> list[Feature]:
    """The lines of a map that `where` wants, in its order, in m of the case; raises ContentError and QuantityError."""
    features, unit = features_of(file.path, value.get("units"), value.get("layer"), value.get("columns"))
    for name, words in value.get("where", {}).items():
        there = attribute(features, name)
        features = [feature for feature, word in zip(features, there, strict=True) if word in words]
        if not features:
            raise ContentError(f"has no {name} {' or '.join(map(quoted, words))}; it has: {listed(there)}")
    if not features:
        raise ContentError("holds nothing")
    for feature in features:
        if feature.shape.geom_type != "LineString" or feature.shape.is_empty:
            odd = "an empty line" if feature.shape.is_empty else feature.shape.geom_type
            raise ContentError(f"holds {odd} in {feature.where}; wanted: lines")
    if len(features) > MOST_LINES:
        raise ContentError(f"holds {len(features)} lines, more than {MOST_LINES}; `where` chooses some")
    lines = [_corners(shapely.get_coordinates(feature.shape), unit, value, context) for feature in features]
    return [replace(each, shape=shapely.LineString(line)) for each, line in zip(features, lines, strict=True)]


def _outline_of(shape: dict[str, Any], path: Path, context: Context) -> tuple[list[Corners], dict[str, object]] | None:
    """The outline of a file and its holes, and its named edges; None after reporting why there is none."""
    file, region, edges = shape["file"], shape.get("region"), {}
    if region is not None and file.mesh is None:
        context.report.fault((*path, "region"), "the file has one polygon and no regions; a mesh has some")
        return None
    try:
        if file.mesh is None:
            polygon = _polygon_of(file)
            rings = [shapely.get_coordinates(ring)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
        else:
            rings, edges = file.mesh.outline(region)
        n_corners = sum(map(len, rings))
        if n_corners > MOST_CORNERS:
            raise ContentError(f"has {n_corners} corners, more than {MOST_CORNERS}")
        return [_corners(ring, shape.get("units"), shape, context) for ring in rings], dict(edges)
    except (ContentError, QuantityError) as error:
        of_map = f"{quoted(file.text)} {error}; wanted: {File().describe()}"
        told = of_map if file.mesh is None else f"the mesh {error}"
        context.report.fault((*path, "region" if region is not None else "file"), told)
        return None


def _polygon_of(file: GivenFile) -> shapely.Polygon:
    """Return the one polygon of a file."""
    parts = [feature.shape for feature in features_of(file.path)[0]]
    if len(parts) != 1 or parts[0].geom_type != "Polygon" or parts[0].is_empty:
        kinds = [part.geom_type for part in parts]
        found = f"{len(kinds)} shapes" if len(kinds) > 1 else kinds[0] if kinds and not parts[0].is_empty else "nothing"
        raise ContentError(f"holds {found}")
    if not parts[0].is_valid:
        raise ContentError(f"holds a polygon that is not valid: {clean(shapely.is_valid_reason(parts[0]))}")
    return parts[0]


def curve_points(value: Resolved, path: Path, context: Context) -> object:
    """A path with vertices in the place of an arc or a spline."""
    if "arc" in value:
        key, arc = "arc", value["arc"]
        if not 0.0 < abs(arc["to"] - arc["from"]) < 360.0:
            message = f"from {arc['from']:g} to {arc['to']:g} deg given; wanted: angles that differ, by less than 360"
            return context.refused((*path, key), message)
        t = np.deg2rad(np.linspace(arc["from"], arc["to"], SAMPLES + 1))
        curve = np.array(arc["center"], dtype=float) + arc["radius"] * np.stack([np.cos(t), np.sin(t)], axis=1)
        places = np.array([0, SAMPLES])
    else:
        from scipy.interpolate import CubicSpline  # here: loading it takes a time that other cases save

        key, points = "spline", np.array(value["spline"], dtype=float).reshape(-1, 2)
        if len(points) < 3 or not np.hypot(*np.diff(points, axis=0).T).all():
            message = f"{len(points)} points given; wanted: three or more, no two of which in turn are the same"
            return context.refused((*path, key), message)
        along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))  # of chords
        steps = max(SAMPLES // (len(points) - 1), FEWEST_SAMPLES)
        at = np.linspace(along[:-1], along[1:], steps, endpoint=False).T.ravel()
        curve = np.asarray(CubicSpline(along, points)(np.append(at, along[-1])))  # not a knot
        places = np.arange(len(points)) * steps
    if not np.hypot(*np.diff(curve, axis=0).T).all():
        return context.refused((*path, key), "is too small for where it lies: its places are one after rounding")
    return {"points": [context.units.coordinates(point) for point in _vertices(curve, places).tolist()]}


def _vertices(curve: Floats, places: Ints) -> Floats:
    """Vertices (n, 2) on a densely sampled curve; the samples `places`, of which its ends are two, are among them."""
    steps = np.diff(curve, axis=0)
    along = np.append(0.0, np.cumsum(np.hypot(*steps.T)))
    middle = 0.5 * (along[1:] + along[:-1]) / along[-1]
    turn = MOST_TURN * np.minimum(np.minimum(middle, 1.0 - middle) / NEAR_END, 1.0)
    direction = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    turned = np.abs(np.gradient(direction))
    segments = np.append(0.0, np.cumsum(turned / np.maximum(turn, LEAST_TURN)))
    parts = []
    for first, last in pairwise(places.tolist()):
        span = segments[last] - segments[first]
        n = max(int(np.ceil(span)), FEWEST) if span > STRAIGHT else 1
        inner = np.linspace(segments[first], segments[last], n + 1)[1:-1]
        parts.append(np.append(along[first], np.interp(inner, segments, along)))
    at = np.append(np.concatenate(parts), along[-1])
    found = np.stack([np.interp(at, along, coordinate) for coordinate in curve.T], axis=1)
    for part, end, beside, tangent in ((parts[0], 0, 1, steps[0]), (parts[-1], -1, -2, -steps[-1])):
        if len(part) > 1:
            length = np.hypot(*(found[beside] - found[end]))
            found[beside] = found[end] + length * tangent / np.hypot(*tangent)
    return found
