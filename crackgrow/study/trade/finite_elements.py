"""What graded finite elements cost: K of the flaw of compression30, straight and with wings, by another program.

Its seconds are those of another machine. Beside them a solve of this program was measured, on cells of one size with
some 2,500 unknowns: so the row of a trade that has about as many gives the scale.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from importlib.resources import files
from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.study.trade.row import Row

TABLE: Final = "fe_cost.csv"
BESIDE: Final = "grown30 at 1.5 mm"
"""The scene of the row that was measured beside the others begins so."""

ABOUT_AS_MANY: Final = 2.0
"""Times as many unknowns, or as few."""


def finite_elements(rows: Sequence[Row]) -> Floats:
    """CPU seconds on the scale of some rows, and relative errors of K (n, 2); none where no row gives the scale."""
    with files("crackgrow.study.trade").joinpath(TABLE).open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    (beside,) = (row for row in table if row["scene"].startswith(BESIDE))
    unlike = {abs(math.log(row.number("n_dofs") / float(beside["unknowns"]))): row for row in rows}
    if not unlike or not min(unlike) <= math.log(ABOUT_AS_MANY):
        return np.zeros((0, 2))
    scale = unlike[min(unlike)].number("cpu_seconds") / float(beside["cpu_seconds"])
    triangles = [row for row in table if "triangles" in row["elements"]]
    return np.array([(scale * float(row["cpu_seconds"]), 0.01 * float(row["error_K_percent"])) for row in triangles])
