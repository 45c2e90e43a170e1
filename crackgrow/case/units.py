"""Numbers and units: exact decimal arithmetic, rounded once, so that a case read again has the same bits."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

# One unit of each name in SI (angles in degrees). The first unit of a kind is what the program computes in.
UNITS: dict[str, dict[str, Fraction]] = {
    "length": {
        "m": Fraction(1),
        "cm": Fraction(1, 100),
        "mm": Fraction(1, 1000),
        "um": Fraction(1, 10**6),
        "km": Fraction(1000),
    },
    "stress": {"Pa": Fraction(1), "kPa": Fraction(10**3), "MPa": Fraction(10**6), "GPa": Fraction(10**9)},
    "density": {"kg/m^3": Fraction(1), "g/cm^3": Fraction(1000), "t/m^3": Fraction(1000)},
    "acceleration": {"m/s^2": Fraction(1), "mm/s^2": Fraction(1, 1000)},
    "angle": {"deg": Fraction(1)},
    "toughness": {
        "Pa sqrt(m)": Fraction(1),
        "kPa sqrt(m)": Fraction(10**3),
        "MPa sqrt(m)": Fraction(10**6),
        "GPa sqrt(m)": Fraction(10**9),
        "MPa sqrt(mm)": Fraction(math.sqrt(1e9)),
    },
}
UNITS["force"] = {
    "N/m": Fraction(1),
    "kN/m": Fraction(10**3),
    "MN/m": Fraction(10**6),
    "N/mm": Fraction(10**3),
    "kN/mm": Fraction(10**6),
}
UNITS["velocity"] = {
    **{f"{length}/s": one for length, one in UNITS["length"].items()},
    "nm/s": Fraction(1, 10**9),
    "mm/day": Fraction(1, 1000 * 86400),
    "mm/year": Fraction(1, 1000 * 31557600),  # of 365.25 days
}
UNITS["stiffness"] = {
    f"{stress}/{length}": one / other
    for length, other in UNITS["length"].items()
    for stress, one in UNITS["stress"].items()
}

# No number of a rock-mechanics case comes near these; their squares and products stay finite.
LARGEST = 1e60
SMALLEST = 1e-60

LONGEST_EXACT = 64  # characters; a longer number is rounded before its unit is applied

_NUMBER = r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_NUMBER_ONLY = re.compile(_NUMBER)
_QUANTITY = re.compile(rf"({_NUMBER})\s*([^\W\d_].*)", re.DOTALL)
_NOT_FINITE = re.compile(r"[-+]?\.?(?:nan|inf|infinity)", re.IGNORECASE)


class QuantityError(ValueError):
    """A text that is not the number or quantity wanted; the message says why."""


@dataclass(frozen=True, slots=True)
class Units:
    """What bare numbers mean."""

    length: str = "m"
    stress: str = "Pa"

    def of(self, kind: str) -> str:
        """Return the unit of a bare number of this kind, as far as it has one (`bare`)."""
        chosen = {
            "length": self.length,
            "stress": self.stress,
            "toughness": f"{self.stress} sqrt(m)",
            "stiffness": f"{self.stress}/{self.length}",
        }
        return chosen.get(kind) or next(iter(UNITS[kind]))

    def bare(self, kind: str) -> bool:
        """Whether a bare number says all: of a toughness in a case in mm it might be MPa sqrt(m) or MPa sqrt(mm)."""
        if kind == "force":  # in N/m in SI alone
            return (self.length, self.stress) == ("m", "Pa")
        return kind != "toughness" or self.length == "m"

    def show(self, value: float, kind: str, digits: int = 6) -> str:
        """Write an SI value in the units of the case, for messages."""
        unit = self.of(kind)
        return f"{value / float(UNITS[kind][unit]):.{digits}g} {unit}"


class Metres(float):
    """A length or a coordinate in m, written in the unit that suits its size: 0.775 mm, 12 m."""

    def __format__(self, digits: str) -> str:
        names = ("m", "mm", "um")
        sizes = {name: float(UNITS["length"][name]) for name in names}
        unit = next((name for name in names if abs(self) >= 0.1 * sizes[name]), "um" if self else "m")
        return f"{float(self) / sizes[unit]:{digits}} {unit}"


def place_text(point: Iterable[float], digits: int = 6) -> str:
    """A point (m) with so many digits, without the round-off of zeros: (4.33 mm, -2.5 mm)."""
    return f"({', '.join(f'{Metres(round(float(along), 12) + 0.0):.{digits}g}' for along in point)})"


def is_number(text: str) -> bool:
    """Whether a plain text is meant as a number, finite or not."""
    return bool(_NUMBER_ONLY.fullmatch(text) or _NOT_FINITE.fullmatch(text))


def parse_number(text: str, factor: Fraction = Fraction(1)) -> float:
    """Return the float nearest to the decimal number `text` times `factor`.

    Raises QuantityError if it is no number, not finite, or beyond any physical size.
    """
    if _NOT_FINITE.fullmatch(text):
        raise QuantityError("is not finite")
    if not _NUMBER_ONLY.fullmatch(text):
        raise QuantityError("is not a number")
    rounded = float(text)
    if abs(rounded) > LARGEST:
        raise QuantityError(f"is too large (limit {LARGEST:g} in SI)")
    exact = Fraction(text) if rounded and len(text) <= LONGEST_EXACT else Fraction(rounded)
    value = float(exact * factor)
    if abs(value) > LARGEST:
        raise QuantityError(f"is too large (limit {LARGEST:g} in SI)")
    if 0 < abs(value) < SMALLEST:
        raise QuantityError(f"is too small (limit {SMALLEST:g} in SI, or 0)")
    return value


def parse_quantity(text: str, kind: str, units: Units) -> float:
    """Return the SI value of "31", "31 mm", "10GPa" as a quantity of this kind (angles in degrees). 0 needs no unit.

    Raises QuantityError for a text that is none, for a unit of another kind and for one that is unknown.
    """
    text = text.strip()
    if is_number(text):
        value = parse_number(text, UNITS[kind][units.of(kind)])
        if value and not units.bare(kind):
            given = f"units.length is {units.length}" + (f" and units.stress {units.stress}" if kind == "force" else "")
            raise QuantityError(f"needs a unit, such as {units.of(kind)}, where {given}")
        return value
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise QuantityError("is neither a number nor a number with a unit")
    number, unit = match.groups()
    if unit not in UNITS[kind]:
        others = [other for other, names in UNITS.items() if unit in names]
        raise QuantityError(f"has a unit of {others[0]}" if others else "has an unknown unit")
    return parse_number(number, UNITS[kind][unit])
