"""Values that may be written in several ways, each stated here alone: places, outlines, paths, edges, vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from crackgrow.case.curves import with_curve_points
from crackgrow.case.formula import OrFormula
from crackgrow.case.outline_file import MOST_CORNERS, OutlineFile, with_file_holes, with_file_points, without_file
from crackgrow.case.reader import Listing, Node, Scalar
from crackgrow.case.regions import LengthOrAngle
from crackgrow.case.report import Path
from crackgrow.case.scalars import POSITIVE, Choice, Context, Number, Quantity, Text
from crackgrow.case.schema import OPTIONAL, Components, Converted, Field, ListOf, Mapping, Named, OneOf, OneOrList
from crackgrow.case.units import UNITS, parse_quantity


@dataclass(frozen=True, slots=True)
class Point(ListOf):
    """Both coordinates of a place, from the origin of the case."""

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return them in m."""
        values = ListOf.read(self, node, path, context)
        if context.units.origin is None or not isinstance(node, Listing) or not context.report.sound(*path):
            return values
        texts = (item.text for item in node.items if isinstance(item, Scalar))
        return [parse_quantity(text, "length", context.units, axis) for axis, text in enumerate(texts)]


SIZE: Final = Quantity("length", POSITIVE)
POINT: Final = Point(Quantity("length"), 2)
POINTS: Final = ListOf(POINT, at_most=MOST_CORNERS)
PAIR: Final = ListOf(Text(), 2)  # names of two bodies

_CENTER: Final = Field(POINT, "centre, [x, y]")

_RECTANGLE: Final = Mapping(
    {"center": _CENTER, "width": Field(SIZE, "size along x"), "height": Field(SIZE, "size along y")}
)

_DISK: Final = Mapping({"center": _CENTER, "radius": Field(SIZE, "radius")})

_BESIDE_FILE: Final = {
    "units": Field(
        Choice(tuple(UNITS["length"])), "unit of its coordinates; left out: the file's or the case's", OPTIONAL
    ),
    "origin": Field(ListOf(Number(), 2), "what is [0, 0] of the case, in its coordinates", OPTIONAL),
}

_SIMPLE_SHAPES: Final = (
    {"rectangle": Field(_RECTANGLE, "a rectangle along the axes")},
    {"polygon": Field(POINTS, "corners in drawing order, [[x, y], ...]")},
    {"disk": Field(_DISK, "a disk")},
    {
        "file": Field(OutlineFile(), "a file with a polygon, or a mesh"),
        "region": Field(Text(), "group of the mesh's cells; left out: all", OPTIONAL),
        **_BESIDE_FILE,
    },
)

HOLE: Final = Converted(OneOf(tuple(Mapping(form) for form in _SIMPLE_SHAPES)), without_file)

_HOLES: Final = Field(ListOf(HOLE, at_most=300), "holes: shapes inside of the outline", OPTIONAL)

SHAPE: Final = Converted(OneOf(tuple(Mapping({**form, "holes": _HOLES}) for form in _SIMPLE_SHAPES)), with_file_holes)

_PAIR_OF_COLUMNS: Final = ListOf(Text(), 2)

_COLUMNS: Final = OneOf(
    (
        Mapping(
            {
                "crack": Field(Text(), "column of the crack's name; its rows follow each other"),
                "x": Field(Text(), "column of x of a vertex"),
                "y": Field(Text(), "column of y of a vertex"),
            }
        ),
        Mapping(
            {
                "start": Field(_PAIR_OF_COLUMNS, "columns of x and y of the start of a row's crack"),
                "end": Field(_PAIR_OF_COLUMNS, "columns of x and y of its end"),
            }
        ),
    )
)

_ARC: Final = Mapping(
    {
        "center": _CENTER,
        "radius": Field(SIZE, "radius"),
        "from": Field(Quantity("angle"), "where the crack starts, counter-clockwise from x as seen from the centre"),
        "to": Field(Quantity("angle"), "where it ends; less than `from`: clockwise"),
    }
)

_PATHS: Final = OneOf(
    (
        Mapping(
            {
                "center": Field(POINT, "midpoint of a straight crack, [x, y]"),
                "length": Field(SIZE, "length of a straight crack"),
                "angle": Field(Quantity("angle"), "direction from start to end, counter-clockwise from x"),
            }
        ),
        Mapping({"points": Field(POINTS, "vertices from start to end, [[x, y], ...]")}, short="points"),
        Mapping({"arc": Field(_ARC, "a part of a circle")}),
        Mapping({"spline": Field(POINTS, "places from start to end that a smooth curve goes through, [[x, y], ...]")}),
        Mapping(
            {
                "file": Field(OutlineFile(of_cracks=True), "a file with lines, each a crack, or a mesh"),
                "curve": Field(Text(), "group of the mesh's lines", OPTIONAL),
                **_BESIDE_FILE,
                "tolerance": Field(SIZE, "distance at which ends meet lines; left out: 1e-5 of the scene", OPTIONAL),
                "where": Field(
                    Named("attribute", OneOrList(Text()), any_name=True),
                    "attributes that lines must have; left out: all lines",
                    OPTIONAL,
                ),
                "names": Field(Text(), "attribute that cracks are named by; left out: their number", OPTIONAL),
                "layer": Field(Text(), "layer of a .gpkg file with several", OPTIONAL),
                "columns": Field(
                    _COLUMNS, "columns of a table; left out: crack, x, y, or x_mm, y_mm and so on", OPTIONAL
                ),
            }
        ),
    )
)

PATH: Final = Converted(Converted(_PATHS, with_curve_points), with_file_points)

REGION: Final = Mapping(
    {
        "body": Field(Text(), "name of a body; may be left out where there is one", OPTIONAL),
        "edge": Field(Text(), "name of one of its edges"),
        "from": Field(LengthOrAngle(), "where the part of the edge begins", OPTIONAL),
        "to": Field(LengthOrAngle(), "where the part of the edge ends", OPTIONAL),
    }
)

DISPLACEMENT: Final = Components(
    Mapping(
        {
            "x": Field(OrFormula(), "displacement along x; left out: free", OPTIONAL),
            "y": Field(OrFormula(), "displacement along y; left out: free", OPTIONAL),
        },
        at_least_one=True,
    ),
    as_list=False,
)

TRACTION: Final = Components(
    Mapping(
        {
            "x": Field(OrFormula("stress"), "force per area along x"),
            "y": Field(OrFormula("stress"), "force per area along y"),
        }
    ),
    as_list=True,
)
