"""Every row of the table that `make verify` writes: a value of the program within the tolerance of its reference."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.verification.row import Row, evaluate
from tests.verification.verify import SUBJECTS, rows_of


def rows() -> Iterator[object]:
    """The rows of all subjects."""
    for subject in SUBJECTS:
        for row in rows_of(subject):
            marks = [pytest.mark.slow] if row.slow else []
            yield pytest.param(row, id=f"{subject}: {row.scene}, {row.quantity}", marks=marks)


@pytest.mark.parametrize("row", [*rows()])
def test_value_is_within_its_tolerance(row: Row) -> None:
    found = evaluate(row)
    assert found.within, f"{found.value} in place of {row.reference}: {found.failure or row.source}"
