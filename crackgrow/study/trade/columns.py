"""The columns of a study of accuracy and time, and its files."""

from __future__ import annotations

from typing import Final

from crackgrow.results.declarations import PHASES, Column, File

_SETTINGS: Final = (
    Column("setting", "", "the setting in words, or `reference`"),
    Column("preset", "", "the preset; empty where the setting is none"),
    Column("accuracy", "", "`numerics.accuracy` of the run"),
    Column("spacing", "m", "lattice spacing"),
    Column("support", "", "half width of a patch, in spacings"),
    Column("quadrature", "", "Gauss points per direction"),
    Column("contact_spacing", "", "least distance of contact nodes, in spacings"),
    Column("stiffness", "", "`rigid`, or kappa of the contact"),
    Column("solver", "", "of the contact"),
    Column("tip_radius", "m", "averaging radius of the tip stress"),
    Column("increment", "m", "growth increment"),
    Column("tips", "", "halvings of cells at tips, or `auto`"),
    Column("kinks", "", "halvings of cells at kinks, meetings and ends of cracks, or `auto`"),
    Column("corners", "", "halvings of cells at corners, or `auto`"),
    Column("tip_functions", "", "`numerics.tip_functions` of the run"),
    Column("status", "", "as in `summary.json`, or `refused`, `unsolved`, `timeout`, `crashed`: a setting that fails "
           "is a row, and the rest goes on"),
    Column("reason", "", "why the run ended"),
    Column("steps", "", "number of the last step"),
    Column("n_dofs", "", "unknowns of the first step"),
)  # fmt: skip
_ERRORS: Final = (
    Column("K_error", "", "largest difference of (K_I, K_II) at a tip, over the largest K of the reference"),
    Column("K_II_error", "", "largest difference of K_II at a tip, over the largest K_II of the reference"),
    Column("pressure_error", "", "L2 norm of the difference along the faces, at the run's own contact points, over "
           "that of all tractions"),
    Column("shear_error", "", "the same for the shear traction"),
    Column("slip_error", "", "the same for the slip, over the L2 norm of the slip"),
    Column("energy_error", "", "relative difference of the strain energy"),
    Column("path_hausdorff", "m", "Hausdorff distance of what both have grown, as `crackgrow compare` measures it"),
    Column("path_frechet", "m", "Frechet distance, the same way"),
    Column("length_error", "m", "largest difference of what has grown at a tip"),
)  # fmt: skip
_ENERGY: Final = (
    Column("true_energy_error", "", "energy norm of the difference of the stresses, over that of the reference"),
    Column("error_estimate", "", "what the run itself estimates of it"),
)
_COSTS: Final = (
    Column("cpu_seconds", "s", "CPU time from reading the case to the last table"),
    Column("wall_seconds", "s", "wall time, the same way"),
    Column("cpu_first_step", "s", "CPU time of the first step, without writing"),
    Column("cpu_step", "s", "CPU time of a later step, their mean, without writing"),
    Column("wall_first_step", "s", "wall time of the first step, without writing"),
    Column("wall_step", "s", "wall time of a later step, their mean, without writing"),
    *(Column(f"wall_{phase}", "s", f"wall time: seconds_{phase} of all steps") for phase in PHASES),
    Column("peak_memory_mb", "MB", "memory of the run's own process"),
    Column("repeats", "", "runs, of whose times this is the median"),
)

ERRORS: Final = tuple(column.name for column in _ERRORS)
ENERGY: Final = tuple(column.name for column in _ENERGY)  # of the same norm, by the reference and by the run itself

FILES: Final = (
    File(
        "trade.csv",
        "a row for each setting, SI. Errors are those before growth, or at the last load factor of a scene without "
        "growth; empty where the scene does not have what is measured",
        (*_SETTINGS, *_ERRORS, *_ENERGY, *_COSTS),
    ),
    File("trade.png", "a panel for each error over the seconds that it costs, with the Pareto front and the presets"),
)
"""Files of a study of accuracy and time."""

COLUMNS: Final = FILES[0].header
