"""Every row of the table that `make verify` prints: a value of the program within the tolerance of its reference."""

from __future__ import annotations

import importlib
from collections.abc import Iterator

import pytest

from tests.verification.row import Row, evaluate
from tests.verification.verify import SUBJECTS

SLOW = ("confined", "path")
"""Subjects whose rows take minutes; and fifty flaws one."""


def rows() -> Iterator[object]:
    """The rows of all subjects."""
    for subject in SUBJECTS:
        for row in importlib.import_module(f"tests.verification.rows.{subject}").ROWS:
            marks = [pytest.mark.slow] if subject in SLOW or row.case == "random_flaws" else []
            yield pytest.param(row, id=f"{subject}: {row.case}, {row.quantity}", marks=marks)


@pytest.mark.parametrize("row", [*rows()])
def test_value_is_within_its_tolerance_or_misses_it_for_a_known_reason(row: Row) -> None:
    found = evaluate(row)
    assert not found.failed, f"{found.value} in place of {found.reference}: {found.failure or found.source}"
    assert not (found.within and found.known), "passes by now: take its `known` away"
