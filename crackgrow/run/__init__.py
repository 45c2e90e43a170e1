"""Running a case: one step, the growth loop, and what they hand out."""

from crackgrow.run.loop import grow

__all__ = ["grow"]
