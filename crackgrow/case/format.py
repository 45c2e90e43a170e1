"""The case format: the parts that `format.yaml` declares, and what no text says of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any, Final

from crackgrow.case.composed import Converted
from crackgrow.case.curves import with_curve_points
from crackgrow.case.declared import Format, format_of
from crackgrow.case.formula import ALPHABET, ONE_VALUE, OrFormula
from crackgrow.case.outline_file import OutlineFile, with_file_edges, with_file_holes, with_file_points, without_file
from crackgrow.case.overrides import OfFile
from crackgrow.case.reader import Listing, Node, Scalar, Table
from crackgrow.case.regions import LengthOrAngle
from crackgrow.case.report import Path
from crackgrow.case.scalars import NUMBER, Context, Quantity, Schema, Schemas, Takes, units_of
from crackgrow.case.schema import ListOf, Mapping
from crackgrow.case.units import Units, parse_quantity

MINIMAL: Final = "minimal"
_NO_FORMULA: Final = rf"(?!.*\.[0-9]*\.)(?!.*({'|'.join(ONE_VALUE)})\s*\([^()]*,\s*[^)\s])"  # 1.2.3, sin(x, y)
DEFINITIONS: Final = ("materials", "laws")  # of the case; resolved cases hold none


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


class PlaceOnEdge(LengthOrAngle):
    """A place on an edge."""

    def takes(self) -> Takes:
        return Takes("length, or angle on an arc", f"{units_of('length')}; on an arc {units_of('angle')}")

    def schema(self, schemas: Schemas) -> Schema:
        return {"anyOf": [Quantity(kind).schema(schemas) for kind in ("length", "angle")]}


class File(OutlineFile):
    """The name of a file with what is drawn."""

    def takes(self) -> Takes:
        return Takes("file name", "", f"ends in {', '.join(self.endings)}")

    def schema(self, _: Schemas) -> Schema:
        letters = ["".join(f"[{c}{c.upper()}]" for c in ending.removeprefix(".")) for ending in self.endings]
        return {"title": self.describe(), "type": "string", "pattern": rf"\.({'|'.join(letters)})$"}


class QuantityOrFormula(OrFormula):
    """A quantity that may vary from place to place."""

    def takes(self) -> Takes:
        return Takes(self.describe(), units_of(self.kind))

    def schema(self, schemas: Schemas) -> Schema:
        pattern = rf"^(?!\s*{NUMBER}\s*$){_NO_FORMULA}({ALPHABET})+$"
        formula = {"title": "formula (in x and y, such as 0.09*x - 0.1)", "type": "string", "pattern": pattern}
        return {"anyOf": [Quantity(self.kind).schema(schemas), schemas.named("formula", lambda: formula)]}


@dataclass(frozen=True, slots=True)
class UnitsOfCase(Converted):
    """What bare numbers mean in what is read after it."""

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the units of lengths and stresses, and the origin in m."""
        values: Any = self.spec.read(node, path, context)
        if context.report.sound(*path) and isinstance(node, Table):
            context.units = Units(values["length"], values["stress"])
            if "origin" in values:  # its bare numbers are in the unit that stands beside it
                of_origin, key = self.spec.fields["origin"].spec, (*path, "origin")
                values["origin"] = of_origin.read(node.entries["origin"].node, key, context)
                if context.report.sound(*key):
                    context.units = replace(context.units, origin=tuple(values["origin"]))
        return values


FORMAT: Final[Format] = format_of(
    FilePath(__file__).with_name("format.yaml").read_text(encoding="utf-8"),
    kinds={
        "point": Point(Quantity("length"), 2),
        "place on an edge": PlaceOnEdge(),
        "file": File(),
        "file of cracks": File(of_cracks=True),
        "formula of length": QuantityOrFormula("length"),
        "formula of stress": QuantityOrFormula("stress"),
        "base file": OfFile("a case file"),
        "settings of the base": OfFile("a mapping"),
    },
    wrapped={
        "Units": UnitsOfCase,
        "Body": lambda spec: Converted(spec, with_file_edges),
        "Shape": lambda spec: Converted(spec, with_file_holes),
        "Hole": lambda spec: Converted(spec, without_file),
        "Path": lambda spec: Converted(Converted(spec, with_curve_points), with_file_points),
        "Displacement": lambda mapping: replace(mapping, at_least_one=True, read_as=dict),
        "Traction": lambda mapping: replace(mapping, read_as=list),
    },
)

CASE: Final[Mapping] = FORMAT.part("Case")
