"""The columns of a convergence study, and its files."""

from __future__ import annotations

from typing import Final

from crackgrow.results.declarations import Column, File

TABLE: Final = "converge.csv"
RANKS: Final = ("coarse", "middle", "fine", "own")
FILES: Final = (
    File(
        TABLE,
        "a row for each step that all runs have and each K of a tip, and for the load factor where it is critical; of "
        "a scene without tips for the displacement along the loads",
        (
            Column("step", "", "number of the step, in the run with the finest cells"),
            Column("crack", "", "name of the crack; empty for the whole scene"),
            Column("tip", "", "`start` or `end` of the crack"),
            Column("quantity", "", "`K_I`, `K_II` (Pa sqrt(m)), `load_factor`, `load_displacement` (m)"),
            *(Column(rank, "as the quantity", f"its value at the {rank} setting") for rank in RANKS[:3]),
            Column("own", "as the quantity", "its value at the case's own setting"),
            Column("order", "", "observed order in the side of the cells; empty where there is none"),
            Column("extrapolated", "as the quantity", "what the three values tend to"),
            *(Column(f"error_{rank}", "", f"what the {rank} setting is off by, over the largest K of the step or over "
                     "the extrapolated value") for rank in RANKS),
        ),
    ),
    File("runs/", "a result folder for each setting"),
)  # fmt: skip
"""Files of a convergence study."""
