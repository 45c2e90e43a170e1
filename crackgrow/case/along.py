"""Where a part of an edge begins or ends: a length on most edges, an angle on arcs. Only the edge tells which."""

from __future__ import annotations

from dataclasses import dataclass

from crackgrow.case.reader import Node, Scalar
from crackgrow.case.report import Path, quoted
from crackgrow.case.scalars import INVALID, Context, refuse
from crackgrow.case.units import UNITS, QuantityError, is_number, parse_quantity


@dataclass(frozen=True, slots=True)
class Along:
    """A place on an edge that is not known yet; a bare number can be either, the other one is None."""

    length: float | None  # m
    angle: float | None  # degrees


@dataclass(frozen=True, slots=True)
class LengthOrAngle:
    """A length or an angle, a bare number in the length unit of the case or in degrees."""

    def describe(self) -> str:
        return "a length, or an angle on an arc"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return an Along."""
        units = f"{' | '.join((*UNITS['length'], *UNITS['angle']))}; a bare number means {context.units.length} or deg"
        wanted = f"{self.describe()} ({units})"
        if not isinstance(node, Scalar) or node.is_null:
            return refuse(node, wanted, path, context)
        text = node.text.strip()
        if not node.plain and is_number(text):
            context.report.fault(path, f'"{text}" in quotes is a text; write {self.describe()} without quotes')
            return INVALID
        values: dict[str, float | None] = {}
        for kind in ("length", "angle"):
            try:
                values[kind] = parse_quantity(text, kind, context.units)
            except QuantityError as error:
                values[kind], reason = None, error
        if values["length"] is None and values["angle"] is None:
            context.report.fault(path, f"{quoted(text)} {reason}; wanted: {wanted}")
            return INVALID
        return Along(values["length"], values["angle"])
