"""Numbers and units: exact decimal arithmetic, rounded once, so that a case read again has the same bits."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction

INCH = Fraction("0.0254")  # m
POUND = Fraction("0.45359237") * Fraction("9.80665")  # N, of force
PSI = POUND / INCH**2

# One unit of each name in SI (angles in degrees). The first unit of a kind is what the program computes in.
_LENGTHS: dict[str, str | Fraction] = {
    "m": "1", "cm": "1e-2", "mm": "1e-3", "um": "1e-6", "km": "1e3", "in": INCH, "ft": 12 * INCH,
}  # fmt: skip
_STRESSES: dict[str, str | Fraction] = {"Pa": "1", "kPa": "1e3", "MPa": "1e6", "GPa": "1e9"}
_TABLE: dict[str, dict[str, str | Fraction]] = {
    "length": _LENGTHS,
    "stress": {**_STRESSES, "psi": PSI, "ksi": 1000 * PSI},
    "density": {"kg/m^3": "1", "g/cm^3": "1e3", "t/m^3": "1e3"},
    "acceleration": {"m/s^2": "1", "mm/s^2": "1e-3"},
    "angle": {"deg": "1"},
    "toughness": {
        **{f"{stress} sqrt(m)": one for stress, one in _STRESSES.items()},
        "MPa sqrt(mm)": Fraction(math.sqrt(1e9)),
        "psi sqrt(in)": PSI * Fraction(math.sqrt(INCH)),
        "ksi sqrt(in)": 1000 * PSI * Fraction(math.sqrt(INCH)),
    },
    "energy per area": {"J/m^2": "1", "kJ/m^2": "1e3"},
    "force": {"N/m": "1", "kN/m": "1e3", "MN/m": "1e6", "N/mm": "1e3", "kN/mm": "1e6"},
    "area": {f"{length}^2": Fraction(one) ** 2 for length, one in _LENGTHS.items()},
    "velocity": {
        **{f"{length}/s": one for length, one in _LENGTHS.items()},
        "nm/s": "1e-9",
        "mm/day": Fraction(1, 86_400_000),
        "mm/year": Fraction(1, 31_557_600_000),  # of 365.25 days
    },
}
UNITS = {kind: {name: Fraction(one) for name, one in units.items()} for kind, units in _TABLE.items()}
UNITS["stiffness"] = {
    f"{stress}/{length}": one / other
    for length, other in UNITS["length"].items()
    for stress, one in UNITS["stress"].items()
}

IMPERIAL = ("psi", "ksi")  # stresses whose toughness goes by inches

# No number of a rock-mechanics case comes near these; their squares and products stay finite.
LARGEST = 1e60
SMALLEST = 1e-60

OF_A_MAP = 1e5  # m: coordinates as large as that are those of a map, whose places are told to the mm

EXACT = 15  # digits that a float has

LONGEST_EXACT = 64  # characters; a longer number is rounded before its unit is applied

_NUMBER = r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_NUMBER_ONLY = re.compile(_NUMBER)
_QUANTITY = re.compile(rf"({_NUMBER})\s*([^\W\d_].*)", re.DOTALL)
_NOT_FINITE = re.compile(r"[-+]?\.?(?:nan|inf|infinity)", re.IGNORECASE)


class QuantityError(ValueError):
    """A text that is not the number or quantity wanted; the message says why."""


class Coordinate(float):
    """A number that stands in case files as the exact sum of itself and another one.

    So stand coordinates in m from the origin of a case on a map, as on the map; and those of the map, of which a float
    has not all digits.
    """

    def __new__(cls, value: float, other: float = 0.0) -> Coordinate:
        """A coordinate `value` with the one that it is written with (m)."""
        found = super().__new__(cls, value)
        found.other = other
        return found

    other: float  # m

    @classmethod
    def of_text(cls, text: str) -> float:
        """The number of a decimal, from which it is written again with all its digits."""
        value = float(text)
        rest = float(Decimal(text) - Decimal(repr(value)))
        return cls(value, rest) if rest else value

    @property
    def text(self) -> str:
        """The sum as an exact decimal, from which the same coordinate is read back."""
        with localcontext(prec=LONGEST_EXACT):
            return f"{Decimal(repr(float(self))) + Decimal(repr(self.other)):f}"


@dataclass(frozen=True, slots=True)
class Units:
    """What bare numbers mean."""

    length: str = "m"
    stress: str = "Pa"
    origin: tuple[float, float] | None = None  # m, the place on a map that is the origin of what is computed

    def along(self, text: str, factor: Fraction, axis: int, less: Fraction = Fraction(0)) -> float:
        """A coordinate in m from the origin, of a decimal number times `factor` of which `less` is taken off.

        Raises QuantityError.
        """
        if self.origin is None:
            return parse_number(text, factor, less)
        origin = self.origin[axis]
        return Coordinate(parse_number(text, factor, less + Fraction(repr(origin))), origin)

    def coordinates(self, point: Iterable[float]) -> list[float]:
        """Both coordinates of a point, in m from the origin, for a case."""
        return [
            Coordinate(along, off) if self.origin else float(along)
            for along, off in zip(point, self.origin or (0.0, 0.0), strict=True)
        ]

    def of(self, kind: str) -> str:
        """Return the unit of a bare number of this kind, as far as it has one (`bare`)."""
        chosen = {
            "length": self.length,
            "stress": self.stress,
            "toughness": f"{self.stress} sqrt({'in' if self.stress in IMPERIAL else 'm'})",
            "stiffness": f"{self.stress}/{self.length}",
            "area": f"{self.length}^2",
        }
        return chosen.get(kind) or next(iter(UNITS[kind]))

    def bare(self, kind: str) -> bool:
        """Whether a bare number says all: of a toughness in a case in mm it might be MPa sqrt(m) or MPa sqrt(mm)."""
        if kind == "force":  # in N/m in SI alone
            return (self.length, self.stress) == ("m", "Pa")
        return kind != "toughness" or (self.length == "m" and self.stress not in IMPERIAL)

    def show(self, value: float, kind: str, digits: int = 6) -> str:
        """Write an SI value in the units of the case, for messages."""
        unit = self.of(kind)
        return f"{value / float(UNITS[kind][unit]):.{digits}g} {unit}"

    def coordinate(self, value: float, axis: int, digits: int = 6) -> str:
        """Write a coordinate, in m from the origin, as the case has it: on a map with as many digits more."""
        origin = self.origin[axis] if self.origin else 0.0
        more = len(f"{abs(origin):.0f}") if self.origin else 0
        return self.show(value + origin, "length", min(digits + more, EXACT))

    def place(self, point: Iterable[float], digits: int = 6) -> str:
        """Write a point in the same way."""
        shown = (self.coordinate(float(along), axis, digits) for axis, along in enumerate(point))
        return f"({', '.join(shown)})"


class Metres(float):
    """A length or a coordinate in m, written in the unit that suits its size: 0.775 mm, 12 m."""

    def __format__(self, digits: str) -> str:
        names = ("m", "mm", "um")
        sizes = {name: float(UNITS["length"][name]) for name in names}
        unit = next((name for name in names if abs(self) >= 0.1 * sizes[name]), "um" if self else "m")
        return f"{float(self) / sizes[unit]:{digits}} {unit}"


def place_text(point: Iterable[float], digits: int = 6) -> str:
    """A point (m) with so many digits, without the round-off of zeros: (4.33 mm, -2.5 mm); of a map to mm."""
    rounded = [round(float(along), 12) + 0.0 for along in point]
    if max(map(abs, rounded)) >= OF_A_MAP:
        digits = max(digits, len(f"{max(map(abs, rounded)):.0f}") + 3)
    return f"({', '.join(f'{Metres(along):.{digits}g}' for along in rounded)})"


def is_number(text: str) -> bool:
    """Whether a plain text is meant as a number, finite or not."""
    return bool(_NUMBER_ONLY.fullmatch(text) or _NOT_FINITE.fullmatch(text))


def parse_number(text: str, factor: Fraction = Fraction(1), less: Fraction = Fraction(0)) -> float:
    """Return the float nearest to the decimal number `text` times `factor`, `less` taken off.

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
    value = float(exact * factor - less)
    if abs(value) > LARGEST:
        raise QuantityError(f"is too large (limit {LARGEST:g} in SI)")
    if 0 < abs(value) < SMALLEST:
        raise QuantityError(f"is too small (limit {SMALLEST:g} in SI, or 0)")
    return value


def parse_quantity(text: str, kind: str, units: Units, axis: int | None = None) -> float:
    """Return the SI value of "31", "31 mm", "10GPa" as a quantity of this kind (angles in degrees). 0 needs no unit.

    axis: of a coordinate, which is one from the origin of `units`

    Raises QuantityError for a text that is none, for a unit of another kind and for one that is unknown.
    """
    text = text.strip()

    def read(number: str, factor: Fraction) -> float:
        return parse_number(number, factor) if axis is None else units.along(number, factor, axis)

    if is_number(text):
        value = read(text, UNITS[kind][units.of(kind)])
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
    return read(number, UNITS[kind][unit])
