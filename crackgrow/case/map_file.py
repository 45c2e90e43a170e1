"""Files of maps: GeoJSON, WKT, tables of vertices, and what GDAL reads. Each shape keeps its attributes and its place.

Coordinates stay in the unit of the file; what is to be drawn of them is decided in `drawings` and `crack_sets`.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np
import shapely

from crackgrow.case.mesh_file import ContentError, checked_file
from crackgrow.case.report import clean, did_you_mean, listed, quoted
from crackgrow.case.units import UNITS

MAX_BYTES: Final = 20 * 2**20
SEPARATORS: Final = ",;\t"  # of tables; but for the first one, numbers may have a decimal comma
OF_A_RUN: Final = {"crack", "vertex", "x", "y", "step"}  # columns of paths.csv, which is in m
VERTICES: Final[Mapping[str, Any]] = {"crack": "crack", "x": "x", "y": "y"}  # the columns where none are given

GDAL: Final = (".gpkg", ".shp", ".dxf")
GEOGRAPHIC: Final = re.compile(
    r"GEOG|.*\b(CRS84|CRS83|CRS27|EPSG\D*(4167|4171|4258|4267|4269|4283|4326|4490|4612|4617|4619|4674|4979|6318|6668|7844))$",
    re.DOTALL,
)
"""Names of the usual coordinate systems in degrees, and the begin of a description of any in WKT."""


@dataclass(frozen=True, slots=True, eq=False)
class Feature:
    """A shape of a file, in the unit of the file."""

    shape: shapely.Geometry  # in the plane
    where: str  # such as "feature 12"
    line: int | None  # of a table, that it begins in
    attributes: Mapping[str, str]  # empty where there is no value


def attribute(features: Sequence[Feature], name: str) -> list[str]:
    """The values of an attribute, which some of the features have; raises ContentError."""
    known = list(dict.fromkeys(key for feature in features for key in feature.attributes))
    if name not in known:
        raise ContentError(f"has no attribute {quoted(name)}; it has: {listed(known)}{did_you_mean(name, known)}")
    return [feature.attributes.get(name, "") for feature in features]


def features_of(
    file: FilePath, unit: str | None = None, layer: str | None = None, columns: Mapping[str, Any] | None = None
) -> tuple[list[Feature], str | None]:
    """Return the shapes of a file in its order, collections part by part, and the unit of its coordinates.

    unit: that which is given; else it is what the columns of a table tell, None where they tell nothing
    layer: of a file that holds several
    columns: of a table, as the keys of `path.columns`

    Raises ContentError.
    """
    kind = file.suffix.lower()
    checked_file(file, MAX_BYTES)
    if layer is not None and kind != ".gpkg":
        raise ContentError(f"has no layers; `layer` is for files in .gpkg, a `where` for layers in {kind}")
    if columns is not None and kind != ".csv":
        raise ContentError("is no table; `columns` is for files in .csv")
    if kind == ".csv":
        found, unit = _table(_text_of(file), unit, columns)
    elif kind in GDAL:
        found = _by_gdal(file, layer)
    elif kind == ".wkt":
        system, _, text = _text_of(file).strip().rpartition(";")
        _check_system(system.upper().replace("SRID=", "EPSG:"))
        shapes = shapely.get_parts(_shape("wkt", text))
        found = [Feature(shape, f"shape {number}", None, {}) for number, shape in enumerate(shapes, 1)]
    else:
        found = _by_geojson(_text_of(file))
    return [part for feature in found for part in _parts(feature)], unit


def _parts(feature: Feature) -> Iterator[Feature]:
    """The shapes that a collection is made of."""
    parts = shapely.get_parts(shapely.get_parts(shapely.force_2d(feature.shape)))
    for number, part in enumerate(parts, 1):
        where = feature.where if len(parts) == 1 else f"{feature.where}, part {number}"
        if not np.isfinite(shapely.get_coordinates(part)).all():
            raise ContentError(f"has a vertex in {where} whose x or y is not finite")
        yield Feature(part, where, feature.line, feature.attributes)


def _text_of(file: FilePath) -> str:
    try:
        return file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ContentError("is not a text in UTF-8") from None
    except OSError as error:
        raise ContentError(f"cannot be read: {error.strerror or error}") from None


def _check_system(name: str) -> None:
    """Refuse a coordinate system in degrees."""
    if GEOGRAPHIC.match(name):
        degrees = f"is in degrees of longitude and latitude ({clean(name)})"
        raise ContentError(f"{degrees}, which are no lengths: project it, such as to UTM, and save it again")


def _word(value: object) -> str:
    """An attribute as a text: a whole number without a point, nothing for no value."""
    if value is None or value != value:
        return ""
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return json.dumps(value) if isinstance(value, dict | list) else str(value)


def _shape(kind: str, text: Any, where: str = "") -> shapely.Geometry:
    """What shapely reads of a text of this kind; raises ContentError that says where it stands."""
    try:
        return getattr(shapely, f"from_{kind}")(text)
    except (shapely.errors.ShapelyError, NotImplementedError, TypeError) as error:  # NotImplementedError: curves
        told = clean(str(error).removeprefix("ParseException: "))
        raise ContentError(f"cannot be read as {kind}{f' at {where}' if where else ''}: {told}") from None


def _by_geojson(text: str) -> list[Feature]:
    """The features that have a place: those without (RFC 7946, section 3.2) are none."""
    try:
        content = json.loads(text)
    except ValueError as error:
        told = f"line {error.lineno}: {error.msg}" if isinstance(error, json.JSONDecodeError) else clean(str(error))
        raise ContentError(f"cannot be read as geojson: {told}") from None
    except RecursionError:
        raise ContentError("cannot be read as geojson: it is nested too deeply") from None
    if not isinstance(content, dict):
        raise ContentError("cannot be read as geojson: it holds no mapping")
    system = content.get("crs")
    if isinstance(system, dict) and isinstance(system.get("properties"), dict):
        _check_system(str(system["properties"].get("name", "")).upper())
    features = content.get("features") if content.get("type") == "FeatureCollection" else [content]
    found = []
    for number, feature in enumerate(features if isinstance(features, list) else [], 1):
        given = feature if isinstance(feature, dict) else {}
        of_feature = given.get("type") == "Feature"
        place = given.get("geometry") if of_feature else given
        if place is None:
            continue
        if not (isinstance(place, dict) and isinstance(place.get("type"), str)):
            raise ContentError(f"cannot be read as geojson at feature {number}: it has no `type`")
        shape = _shape("geojson", json.dumps(place), f"feature {number}")
        properties = given.get("properties") if of_feature else None
        values = {"id": given.get("id", ""), **(properties if isinstance(properties, dict) else {})}
        where = f"feature {number}" if len(features or ()) > 1 or of_feature else "the shape"
        found.append(Feature(shape, where, None, {name: _word(value) for name, value in values.items()}))
    return found


def _by_gdal(file: FilePath, layer: str | None) -> list[Feature]:
    """The features of a file that GDAL reads."""
    try:
        import pyogrio  # only now: few cases have such a file
    except ImportError:
        raise ContentError("needs pyogrio to be read: pip install 'crackgrow[maps]'") from None
    try:
        layers = pyogrio.list_layers(file)[:, 0].tolist()
        if layer not in (layers if len(layers) > 1 else [*layers, None]):
            listed = f"it has {', '.join(layers)}{did_you_mean(layer or '', layers)}"
            given = "has several layers; `layer` says which: " if layer is None else f"has no layer {quoted(layer)}; "
            raise ContentError(given + listed)
        meta, numbers, shapes, values = pyogrio.raw.read(file, layer=layer, return_fids=True)
    except (RuntimeError, ValueError) as error:
        if isinstance(error, ContentError):
            raise
        raise ContentError(f"cannot be read as {file.suffix.lower()[1:]}: {clean(str(error))}") from None
    _check_system(str(meta["crs"] or ""))
    columns = dict(zip(meta["fields"].tolist(), (column.tolist() for column in values), strict=True))
    return [
        Feature(
            _shape("wkb", shape, f"feature {number}"),
            f"feature {number}",
            None,
            {"id": str(number), **{name: _word(column[row]) for name, column in columns.items()}},
        )
        for row, (number, shape) in enumerate(zip(numbers.tolist(), shapes, strict=True))
        if shape is not None
    ]


def _table(text: str, unit: str | None, columns: Mapping[str, Any] | None) -> tuple[list[Feature], str | None]:
    """The lines of a table with a row for each vertex, those of a crack in turn, or with a row for each line."""
    separator = max(SEPARATORS, key=text.partition("\n")[0].count)
    rows = csv.DictReader(text.splitlines(), delimiter=separator, skipinitialspace=True)
    header = [name.strip() for name in rows.fieldnames or ()]
    rows.fieldnames = header
    if columns is None:
        columns = VERTICES
        told = [name for name in UNITS["length"] if {f"x_{name}", f"y_{name}"} <= {*header} and "x" not in header]
        if told and unit not in (None, told[0]):
            raise ContentError(f"has the columns x_{told[0]} and y_{told[0]}, and `units` is {unit}")
        if told:
            unit, columns = told[0], {**VERTICES, "x": f"x_{told[0]}", "y": f"y_{told[0]}"}
        elif unit is None and {*header} >= OF_A_RUN:
            unit = "m"
    pairs = [columns["start"], columns["end"]] if "start" in columns else [[columns["x"], columns["y"]]]
    names = [*([columns["crack"]] if "crack" in columns else []), *(name for pair in pairs for name in pair)]
    missing = [name for name in names if name not in header]
    if missing:
        has = f"its columns are {', '.join(header) or 'none'}"
        remedy = "`columns` of the path tells which are which" if columns is VERTICES else ""
        raise ContentError(f"has no column {' or '.join(missing)}; {has}{f'; {remedy}' if remedy else ''}")
    lines = [(rows.line_num, row) for row in rows if any((value or "").strip() for value in row.values() if value)]
    found = []
    for _, group in groupby(lines, key=lambda line: line[1][columns["crack"]] if len(pairs) == 1 else line[0]):
        vertices = list(group)
        first, row = vertices[0]
        points = [[_number(line, its, name, separator) for name in pair] for line, its in vertices for pair in pairs]
        if len(points) < 2:
            name = quoted(str(row[columns["crack"]]))
            raise ContentError(f"has in line {first} one vertex of {name}, and a line has two or more, in rows in turn")
        where = f"line {first}" if len(vertices) == 1 else f"lines {first} to {vertices[-1][0]}"
        attributes = {str(name): (value or "").strip() for name, value in row.items() if isinstance(value, str)}
        found.append(Feature(shapely.LineString(points), where, first, attributes))
    return found, unit


def _number(line: int, row: Mapping[str, str | None], name: str, separator: str) -> float:
    """A coordinate in a row of a table."""
    text = (row[name] or "").strip()
    try:
        value = float(text if separator == SEPARATORS[0] else text.replace(",", "."))
    except ValueError:
        raise ContentError(f"has in line {line} a vertex whose {name} is no number: {quoted(text)}") from None
    if not np.isfinite(value):
        raise ContentError(f"has in line {line} a vertex whose {name} is not finite: {quoted(text)}")
    return value
