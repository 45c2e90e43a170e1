"""The columns of a study of accuracy and time, and its files."""

from __future__ import annotations

from typing import Final

from crackgrow.results.declarations import columns_of, declared

FILES: Final = declared(columns_of("study")["trade"])
"""Files of a study of accuracy and time."""

COLUMNS: Final = FILES[0].header
ENERGY: Final = ("true_energy_error", "error_estimate")  # of the same norm, by the reference and by the run itself
ERRORS: Final = COLUMNS[COLUMNS.index("K_error") : COLUMNS.index(ENERGY[0])]
