"""Outlines and cracks in files, in the length unit of the case.

A GeoJSON or WKT file holds one polygon, perhaps with holes, or the lines of many cracks; a CSV file such lines, as
paths.csv of a run has them; a mesh holds regions, names of their edges, and curves.
"""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case import mesh_file
from crackgrow.case.mesh_file import ContentError, PlaneMesh, checked_file, read_mesh
from crackgrow.case.reader import Node, Scalar
from crackgrow.case.report import Path, clean, quoted
from crackgrow.case.scalars import INVALID, Context, refuse
from crackgrow.case.units import UNITS, QuantityError, parse_number

MAX_BYTES = 2 * 2**20
MOST_CORNERS = 5000  # of an outline; a disk has 360
MOST_LINES = 1000  # of a set of cracks

Corners = list[list[float]]  # m, not closed

COLUMNS = ("crack", "x", "y")  # of a CSV file; others are passed over


def _from_csv(text: str) -> shapely.Geometry:
    """The lines of a table with a row for each vertex: rows in turn of one crack are a line."""
    rows = csv.DictReader(text.splitlines())
    missing = [name for name in COLUMNS if name not in (rows.fieldnames or ())]
    if missing:
        raise ContentError(
            f"has no column {' or '.join(missing)}; its columns are {', '.join(rows.fieldnames or ()) or 'none'}"
        )
    lines = []
    for name, vertices in groupby(rows, key=lambda row: row["crack"]):
        try:
            points = [(float(row["x"]), float(row["y"])) for row in vertices]
        except (TypeError, ValueError):
            raise ContentError(f"has a vertex of {quoted(str(name))} whose x or y is no number") from None
        if len(points) < 2:
            told = "and a line has two or more, in rows one after the other"
            raise ContentError(f"has one vertex of {quoted(str(name))}, {told}")
        lines.append(points)
    if not np.isfinite(np.concatenate([np.zeros((1, 2)), *lines])).all():
        raise ContentError("has a vertex whose x or y is not finite")
    return shapely.MultiLineString(lines)


def _from_geojson(text: str) -> shapely.Geometry:
    """The shapes of a GeoJSON text. Features without a place (RFC 7946, section 3.2) are none; shapely refuses them."""
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        return shapely.from_geojson(text)  # which raises, and says why
    features = content.get("features") if isinstance(content, dict) else None
    if not isinstance(features, list):
        return shapely.from_geojson(text)
    placed = [each for each in features if not (isinstance(each, dict) and each.get("geometry", each) is None)]
    return shapely.from_geojson(text if len(placed) == len(features) else json.dumps({**content, "features": placed}))


_READERS = {".geojson": _from_geojson, ".json": _from_geojson, ".wkt": shapely.from_wkt}
_TABLES = {".csv": _from_csv}


@dataclass(frozen=True, slots=True)
class OutlineFile:
    """The name of a file with an outline, or with the lines of cracks, relative to the folder of the case file."""

    of_cracks: bool = False

    @property
    def endings(self) -> tuple[str, ...]:
        """How the names of such files end."""
        return (*_READERS, *(_TABLES if self.of_cracks else ()), *mesh_file.ENDINGS)

    def describe(self) -> str:
        content = "lines" if self.of_cracks else "one polygon"
        kinds = ".geojson, .wkt or .csv" if self.of_cracks else ".geojson or .wkt"
        return f"the name of a {kinds} file with {content}, or a mesh ({', '.join(mesh_file.ENDINGS)})"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the corners of the outline and then of each hole, or the lines, in m; of a mesh the mesh itself."""
        if not isinstance(node, Scalar) or node.is_null or not node.text.strip():
            return refuse(node, self.describe(), path, context)
        file = context.folder_of(node) / node.text
        try:
            if file.suffix.lower() not in self.endings:
                raise ContentError(f"ends in {quoted(file.suffix)}")
            if file.suffix.lower() in mesh_file.ENDINGS:
                return read_mesh(file)
            if self.of_cracks:
                return [_corners(shapely.get_coordinates(line), context) for line in _lines_of(file)]
            polygon = _polygon_of(file)
            rings = [polygon.exterior, *polygon.interiors]
            return [_corners(shapely.get_coordinates(ring)[:-1], context) for ring in rings]
        except (ContentError, QuantityError) as error:
            return context.refused(path, f"{quoted(node.text)} {error}; wanted: {self.describe()}")


def _parts_of(file: FilePath) -> list[shapely.Geometry]:
    """Return the shapes of a file, one by one."""
    try:
        geometry = {**_READERS, **_TABLES}[file.suffix.lower()](_text_of(file))
    except (shapely.errors.ShapelyError, NotImplementedError) as error:  # NotImplementedError: curves
        raise ContentError(f"cannot be read as {file.suffix.lower()[1:]}: {clean(str(error))}") from None
    return list(shapely.get_parts(shapely.get_parts(geometry))) if geometry is not None else []


def _lines_of(file: FilePath) -> list[shapely.LineString]:
    """Return the lines of a file, in its order."""
    parts = _parts_of(file)
    strange = sorted({part.geom_type for part in parts} - {"LineString"})
    if strange or not parts:
        raise ContentError(f"holds {', '.join(strange) or 'nothing'}")
    if len(parts) > MOST_LINES:
        raise ContentError(f"holds {len(parts)} lines, more than {MOST_LINES}")
    return parts


def _polygon_of(file: FilePath) -> shapely.Polygon:
    """Return the one polygon of a file."""
    parts = _parts_of(file)
    if len(parts) != 1 or parts[0].geom_type != "Polygon" or parts[0].is_empty:
        kinds = [part.geom_type for part in parts]
        found = f"{len(kinds)} shapes" if len(kinds) > 1 else kinds[0] if kinds and not parts[0].is_empty else "nothing"
        raise ContentError(f"holds {found}")
    if len(shapely.get_coordinates(parts[0])) > MOST_CORNERS:
        raise ContentError(f"has {len(shapely.get_coordinates(parts[0]))} corners, more than {MOST_CORNERS}")
    if not parts[0].is_valid:
        raise ContentError(f"holds a polygon that is not valid: {clean(shapely.is_valid_reason(parts[0]))}")
    return parts[0]


def _text_of(file: FilePath) -> str:
    checked_file(file, MAX_BYTES)
    try:
        return file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ContentError("is not a text in UTF-8") from None
    except OSError as error:
        raise ContentError(f"cannot be read: {error.strerror or error}") from None


def _corners(points: Floats, context: Context) -> Corners:
    unit = UNITS["length"][context.units.length]
    return [[parse_number(repr(float(value)), unit) for value in point] for point in points]


def with_file_holes(value: object, path: Path, context: Context) -> object:
    """Return a shape with a polygon, and perhaps holes, in the place of the file they come from.

    Names of its edges come with it, under `edges`, for `with_file_edges`.
    """
    if not isinstance(value, dict) or "file" not in value:
        return value
    found = _outline_of(value, path, context)
    if found is None:
        return INVALID
    (outline, *holes), edges = found
    own = [{"polygon": hole} for hole in holes]
    every = [*own, *value.get("holes", [])]
    return {"polygon": outline} | ({"holes": every} if every else {}) | ({"edges": edges} if edges else {})


def with_file_edges(value: object, path: Path, context: Context) -> object:
    """Return a body with the names of edges that its shape has brought from a file, and its own."""
    if not isinstance(value, dict) or not isinstance(value.get("shape"), dict) or "edges" not in value["shape"]:
        return value
    shape = {key: part for key, part in value["shape"].items() if key != "edges"}
    return {**value, "shape": shape, "edges": {**value["shape"]["edges"], **value.get("edges", {})}}


def without_file(value: object, path: Path, context: Context) -> object:
    """Return a hole with a polygon in the place of the file it comes from, which must not have holes itself."""
    if not isinstance(value, dict) or "file" not in value:
        return value
    found = _outline_of(value, path, context)
    if found is None:
        return INVALID
    outline, *holes = found[0]
    if holes:
        return context.refused((*path, "file"), "the polygon has holes; wanted for a hole: a polygon without any")
    return {"polygon": outline}


def with_file_points(value: object, path: Path, context: Context) -> object:
    """Return a path with the points of a curve of a mesh, or with the lines of a file, in the place of the file."""
    if not isinstance(value, dict) or "file" not in value:
        return value
    source, curve = value["file"], value.get("curve")
    if not isinstance(source, PlaneMesh):
        if curve is not None:
            return context.refused((*path, "curve"), "the file has lines and no curves; a mesh has some")
        return {"lines": source}
    if curve is None:
        return context.refused((*path, "curve"), "missing: name or number of a group of the mesh's lines (a text)")
    try:
        return {"points": _corners(source.path(curve), context)}
    except (ContentError, QuantityError) as error:
        return context.refused((*path, "curve"), f"the mesh {error}")


def _outline_of(shape: dict[str, Any], path: Path, context: Context) -> tuple[list[Corners], dict[str, object]] | None:
    """The outline of a file and its holes, and its named edges; None after reporting why there is none."""
    source, region = shape["file"], shape.get("region")
    if not isinstance(source, PlaneMesh):
        if region is not None:
            message = "the file has one polygon and no regions; a mesh has some"
            context.report.fault((*path, "region"), message)
            return None
        return source, {}
    try:
        rings, edges = source.outline(region)
        corners = [_corners(ring, context) for ring in rings]
    except (ContentError, QuantityError) as error:
        context.report.fault((*path, "region" if region is not None else "file"), f"the mesh {error}")
        return None
    n_corners = sum(map(len, corners))
    if n_corners > MOST_CORNERS:
        context.report.fault((*path, "file"), f"the outline has {n_corners} corners, more than {MOST_CORNERS}")
        return None
    return corners, dict(edges)
