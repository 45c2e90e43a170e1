"""Numbers and units: what is read, in SI, to the last bit; what is refused."""

from __future__ import annotations

import pytest

from crackgrow.case.units import Metres, QuantityError, Units, parse_number, parse_quantity, place_text

MM = Units("mm", "MPa")


@pytest.mark.parametrize(
    ("text", "value"),
    [("10", 10.0), ("1e10", 1e10), ("1.e10", 1e10), (".5", 0.5), ("-3.25E-2", -0.0325), ("+7", 7.0), ("010", 10.0)],
)
def test_numbers(text: str, value: float):
    assert parse_number(text) == value


@pytest.mark.parametrize(
    "text", ["", "x", "1_000", "0x10", "1:30", "1e", "--1", "1,5", "٣", "1 2", "nan", "-.inf", "1e61"]
)
def test_not_a_number(text: str):
    with pytest.raises(QuantityError):
        parse_number(text)


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("31", "length", 0.031),
        ("31 mm", "length", 0.031),
        ("0", "force", 0.0),  # in every unit
        ("-2 kN/mm", "force", -2e6),
        ("31mm", "length", 0.031),
        (" 3.1 cm ", "length", 0.031),
        ("0.1 um", "length", 1e-7),
        ("10 GPa", "stress", 1e10),
        ("1e1GPa", "stress", 1e10),
        ("0.7", "stress", 700000.0),
        ("2500", "density", 2500.0),
        ("2.7 g/cm^3", "density", 2700.0),
        ("30 deg", "angle", 30.0),
    ],
)
def test_quantities_are_the_nearest_floats(text: str, kind: str, value: float):
    assert parse_quantity(text, kind, MM) == value


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("31 MPa", "unit of stress"),
        ("31 furlong", "unknown unit"),
        ("31 MM", "unknown unit"),
        ("mm", "neither"),
        ("31 mm mm", "unknown unit"),
        ("3 1 mm", "neither"),
        ("inf mm", "neither"),
        ("1e999 mm", "too large"),
        ("1e60 km", "too large"),
        ("1e-59 mm", "too small"),
    ],
)
def test_refused_quantities(text: str, words: str):
    with pytest.raises(QuantityError, match=words):
        parse_quantity(text, "length", MM)


def test_no_negative_zero():
    assert repr(parse_number("-0.0")) == "0.0"


@pytest.mark.parametrize(
    ("metres", "words"),
    [
        (12.0, "12 m"),
        (0.25, "0.25 m"),
        (0.0999, "99.9 mm"),
        (-7.75e-4, "-0.775 mm"),
        (2.6e-8, "0.026 um"),
        (0.0, "0 m"),
    ],
)
def test_a_length_has_the_unit_that_suits_its_size(metres: float, words: str) -> None:
    assert f"{Metres(metres):.3g}" == words
    assert parse_quantity(words, "length", Units()) == pytest.approx(metres)


def test_a_place_has_no_round_off_of_zeros() -> None:
    assert place_text([-1e-17, -0.02]) == "(0 m, -20 mm)"
