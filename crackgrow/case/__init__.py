"""Case files: YAML text -> a checked, frozen Case in SI units, or every fault with its line.

A file goes through reader (nodes that know their line), base, overrides, format (a tree of specs, made of format.yaml),
drawings (files and curves), layout (the geometry), sizing, checks, which yield faults, and becomes the model, which is
frozen. `dump_case` writes a case that reads back to the same bits; `from_dict` and `to_dict` do the same in
Python.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from crackgrow.case.dump import dump_case
    from crackgrow.case.load import load_case
    from crackgrow.case.model import Case

__all__ = ["Case", "dump_case", "load_case"]


def __getattr__(name: str) -> object:
    """Load a name on first use: who needs units alone, as `crackgrow --version` does, loads no numpy."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = {"Case": "model", "dump_case": "dump", "load_case": "load"}[name]
    return getattr(import_module(f"crackgrow.case.{home}"), name)
