"""Case files: YAML text -> a checked, frozen Case in SI units, or every fault with its line.

A file goes through reader (nodes that know their line), overrides, scene (the format as a tree of specs, made of
schema and scalars), checks, build. `dump_case` writes a case that reads back to the same bits.
"""

from crackgrow.case.dump import dump_case
from crackgrow.case.load import load_case
from crackgrow.case.model import (
    Body,
    Case,
    ContactNumerics,
    CoulombContact,
    Crack,
    EdgeRegion,
    EdgeSupport,
    EdgeTraction,
    Floats,
    Growth,
    Material,
    Numerics,
    Output,
    PointSupport,
    Strength,
)

__all__ = [
    "Body",
    "Case",
    "ContactNumerics",
    "CoulombContact",
    "Crack",
    "EdgeRegion",
    "EdgeSupport",
    "EdgeTraction",
    "Floats",
    "Growth",
    "Material",
    "Numerics",
    "Output",
    "PointSupport",
    "Strength",
    "dump_case",
    "load_case",
]
