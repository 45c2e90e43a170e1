"""Results are those of the golden table: to round-off, which other processors and BLAS change in the last digits."""

from __future__ import annotations

import pytest

from tests.regression.golden import MAKERS, differences, table

ROUND_OFF = 1e-8
"""Of the size of a quantity: growth carries the last digits of one step on to the next."""


@pytest.mark.parametrize("scene", MAKERS)
def test_results_are_those_of_the_table(scene: str) -> None:
    assert [words for size, words in differences(table()[scene], MAKERS[scene]()) if size > ROUND_OFF] == []
