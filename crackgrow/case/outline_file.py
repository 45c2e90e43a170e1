"""Outlines and cracks in files, brought to the unit and the origin of the case.

A file of a map holds one polygon, perhaps with holes, or the lines of many cracks; a mesh holds regions, names of their
edges, and curves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path as FilePath
from typing import Any, Final

import shapely

from crackgrow.arrays import Floats
from crackgrow.case import map_file, mesh_file
from crackgrow.case.map_file import Feature, attribute, features_of
from crackgrow.case.mesh_file import ContentError, PlaneMesh, listed, read_mesh
from crackgrow.case.reader import Node, Scalar
from crackgrow.case.report import Path, clean, quoted
from crackgrow.case.scalars import INVALID, Context, refuse
from crackgrow.case.units import UNITS, QuantityError

MOST_CORNERS: Final = 5000  # of an outline; a disk has 360
MOST_LINES: Final = 1000  # of a set of cracks

Corners = list[list[float]]  # m, not closed

TEXTS: Final = (".geojson", ".json", ".wkt")


@dataclass(frozen=True, slots=True)
class OutlineFile:
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
        file = context.folder_of(node) / node.text
        if file.suffix.lower() not in self.endings:
            return context.refused(
                path, f"{quoted(node.text)} ends in {quoted(file.suffix)}; wanted: {self.describe()}"
            )
        try:
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
    """Return a path with the points of a curve of a mesh, or with the traces of a map, in the place of the file."""
    if not isinstance(value, dict) or "file" not in value:
        return value
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
    for name, wanted in value.get("where", {}).items():
        words = wanted if isinstance(wanted, list) else [wanted]
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
        of_map = f"{quoted(file.text)} {error}; wanted: {OutlineFile().describe()}"
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
