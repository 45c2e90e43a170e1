"""The columns of a convergence study, and its files."""

from __future__ import annotations

from typing import Final

from crackgrow.results.declarations import columns_of, declared

FILES: Final = declared(columns_of("study")["converge"])
"""Files of a convergence study."""

TABLE: Final = FILES[0].name
RANKS: Final = ("coarse", "middle", "fine", "own")
