"""The case format: the parts that `format.yaml` declares, and what no text says of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any, Final

from crackgrow.case.declared import Format, format_of
from crackgrow.case.formula import OrFormula
from crackgrow.case.outline_file import File
from crackgrow.case.overrides import OfFile
from crackgrow.case.reader import Listing, Node, Scalar, Table
from crackgrow.case.regions import PlaceOnEdge
from crackgrow.case.report import Path
from crackgrow.case.scalars import Context, Measured
from crackgrow.case.schema import ListOf, Mapping
from crackgrow.case.units import Units, parse_quantity

MINIMAL: Final = "minimal"
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


@dataclass(frozen=True, slots=True)
class UnitsOfCase(Mapping):
    """What bare numbers mean in what is read after it."""

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the units of lengths and stresses, and the origin in m."""
        values: Any = Mapping.read(self, node, path, context)
        if context.report.sound(*path) and isinstance(node, Table):
            context.units = Units(values["length"], values["stress"])
            if "origin" in values:  # its bare numbers are in the unit that stands beside it
                key = (*path, "origin")
                values["origin"] = self.fields["origin"].spec.read(node.entries["origin"].node, key, context)
                if context.report.sound(*key):
                    context.units = replace(context.units, origin=tuple(values["origin"]))
        return values


FORMAT: Final[Format] = format_of(
    FilePath(__file__).with_name("format.yaml").read_text(encoding="utf-8"),
    kinds={
        "point": Point(Measured("length"), 2),
        "place on an edge": PlaceOnEdge(),
        "file": File(),
        "file of cracks": File(of_cracks=True),
        "formula of length": OrFormula("length"),
        "formula of stress": OrFormula("stress"),
        "base file": OfFile("a case file"),
        "settings of the base": OfFile("a mapping"),
    },
    wrapped={
        "Units": lambda mapping: UnitsOfCase(mapping.fields, part=mapping.part),
        "Displacement": lambda mapping: replace(mapping, at_least_one=True, read_as=dict),
        "Traction": lambda mapping: replace(mapping, read_as=list),
    },
)

CASE: Final[Mapping] = FORMAT.part("Case")
