"""Running a case: one step, the growth loop, and what they hand out."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from crackgrow.run.loop import grow as grow


def __getattr__(name: str) -> object:
    """`grow`, loaded when it is asked for: what a run hands out can be read without all that solves."""
    if name != "grow":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from crackgrow.run.loop import grow

    return grow
