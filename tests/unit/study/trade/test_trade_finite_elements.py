"""Points of finite elements beside a trade's front: on the scale of the row with about as many unknowns."""

from __future__ import annotations

import csv
from importlib.resources import files

import numpy as np
import pytest

from crackgrow.study.trade.columns import COLUMNS
from crackgrow.study.trade.picture import TABLE, finite_elements
from crackgrow.study.trade.row import Row
from tests.benchmarks.paths import REFERENCES


def row(n_dofs: int, seconds: float) -> Row:
    return Row({**dict.fromkeys(COLUMNS, ""), "n_dofs": str(n_dofs), "cpu_seconds": str(seconds)})


def test_the_scale_is_that_of_the_row_with_about_as_many_unknowns() -> None:
    """A row that takes ten times as long as the solve beside them makes their seconds ten times as many."""
    points = finite_elements([row(900, 5.0), row(2600, 1.755), row(9000, 70.0)])
    with (REFERENCES / "fe_cost.csv").open(newline="") as file:
        table = [row for row in csv.DictReader(file) if "triangles" in row["elements"]]
    assert len(points) == len(table) == 12
    np.testing.assert_allclose(points[:, 0], [10.0 * float(row["cpu_seconds"]) for row in table])
    np.testing.assert_allclose(points[:, 1], [0.01 * float(row["error_K_percent"]) for row in table])


@pytest.mark.parametrize("rows", [[], [row(900, 1.0), row(9000, 9.0)]])
def test_without_such_a_row_there_are_no_points(rows: list[Row]) -> None:
    assert len(finite_elements(rows)) == 0


def test_the_table_is_that_of_the_references() -> None:
    own = files("crackgrow.study.trade").joinpath(TABLE).read_text(encoding="utf-8")
    assert own == (REFERENCES / "fe_cost.csv").read_text(encoding="utf-8")
