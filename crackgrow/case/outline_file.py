"""Outlines in GeoJSON and WKT files: one polygon, perhaps with holes, in the length unit of the case."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath

import shapely

from crackgrow.case.reader import Node, Scalar
from crackgrow.case.report import Path, clean, quoted
from crackgrow.case.scalars import INVALID, Context, refuse
from crackgrow.case.units import UNITS, QuantityError, parse_number

MAX_BYTES = 2 * 2**20
MOST_CORNERS = 5000  # of an outline; a disk has 360

Corners = list[list[float]]  # m, not closed

_READERS = {".geojson": shapely.from_geojson, ".json": shapely.from_geojson, ".wkt": shapely.from_wkt}
ENDINGS = tuple(_READERS)


class OutlineError(ValueError):
    """A file that holds no outline; the message says why."""


@dataclass(frozen=True, slots=True)
class OutlineFile:
    """The name of a file with an outline, relative to the folder of the case file."""

    def describe(self) -> str:
        """Say in a few words what is allowed."""
        return "the name of a .geojson or .wkt file with one polygon"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the corners of the outline and then of each hole, in m."""
        if not isinstance(node, Scalar) or node.is_null or not node.text.strip():
            return refuse(node, self.describe(), path, context)
        try:
            polygon = _polygon_of(context.folder_of(node) / node.text)
            rings = [polygon.exterior, *polygon.interiors]
            return [_corners(ring, context) for ring in rings]
        except (OutlineError, QuantityError) as error:
            context.report.fault(path, f"{quoted(node.text)} {error}; wanted: {self.describe()}")
            return INVALID


def _polygon_of(file: FilePath) -> shapely.Polygon:
    """Return the one polygon of a file."""
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        raise OutlineError(f"ends in {quoted(file.suffix)}")
    try:
        geometry = reader(_text_of(file))
    except (shapely.errors.ShapelyError, NotImplementedError) as error:  # NotImplementedError: curves
        raise OutlineError(f"cannot be read as {file.suffix.lower()[1:]}: {clean(str(error))}") from None
    parts = list(shapely.get_parts(geometry)) if geometry is not None else []
    if len(parts) != 1 or parts[0].geom_type != "Polygon" or parts[0].is_empty:
        kinds = [part.geom_type for part in parts]
        found = f"{len(kinds)} shapes" if len(kinds) > 1 else kinds[0] if kinds and not parts[0].is_empty else "nothing"
        raise OutlineError(f"holds {found}")
    if len(shapely.get_coordinates(parts[0])) > MOST_CORNERS:
        raise OutlineError(f"has {len(shapely.get_coordinates(parts[0]))} corners, more than {MOST_CORNERS}")
    if not parts[0].is_valid:
        raise OutlineError(f"holds a polygon that is not valid: {clean(shapely.is_valid_reason(parts[0]))}")
    return parts[0]


def _text_of(file: FilePath) -> str:
    try:
        if not file.is_file():
            raise OutlineError("is no file" if file.exists() else f"does not exist in {file.parent}")
        if file.stat().st_size > MAX_BYTES:
            raise OutlineError(f"is larger than {MAX_BYTES // 2**20} MiB")
        return file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        raise OutlineError("is not a text in UTF-8") from None
    except OutlineError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise OutlineError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None


def _corners(ring: shapely.LinearRing, context: Context) -> Corners:
    unit = UNITS["length"][context.units.length]
    points = shapely.get_coordinates(ring)[:-1]
    return [[parse_number(repr(float(value)), unit) for value in point] for point in points]


def with_file_holes(value: object, path: Path, context: Context) -> object:
    """Return a shape with a polygon, and perhaps holes, in the place of the file they come from."""
    if not isinstance(value, dict) or "file" not in value:
        return value
    outline, *holes = value["file"]
    own = [{"polygon": hole} for hole in holes]
    every = [*own, *value.get("holes", [])]
    return {"polygon": outline} | ({"holes": every} if every else {})


def without_file(value: object, path: Path, context: Context) -> object:
    """Return a hole with a polygon in the place of the file it comes from, which must not have holes itself."""
    if not isinstance(value, dict) or "file" not in value:
        return value
    outline, *holes = value["file"]
    if holes:
        context.report.fault((*path, "file"), "the polygon has holes; wanted for a hole: a polygon without any")
        return INVALID
    return {"polygon": outline}
