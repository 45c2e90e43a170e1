"""What is going to be run to see whether a case has converged, checked before anything runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

from crackgrow.case import Case
from crackgrow.case.accuracy import TARGETS
from crackgrow.errors import CaseError, Fault
from crackgrow.study.setting import UNWRITTEN, CaseFile, Setting, accuracy_overrides, check_steps

OWN: Final = "own"
HALF: Final = "half increments"
THREE: Final = 3
TOLERANCE: Final = 0.01


@dataclass(frozen=True, slots=True)
class ConvergencePlan:
    """The runs, and what is asked of them."""

    file: CaseFile
    case: Case  # as it is given, with the number of steps that was asked for
    settings: tuple[Setting, ...]  # three, the coarsest cells first
    own: Setting  # one of them, or a run of its own
    half: Setting | None  # the own setting with half the increment and twice the steps
    half_asked: bool | None  # None: where it is not too expensive
    tolerance: float  # of K, over the largest of a step
    folder: Path

    @property
    def grows(self) -> bool:
        """Whether steps are of growth."""
        return self.case.growth is not None and self.case.growth.steps > 0


def plan_convergence(
    case: Path,
    folder: Path,
    *,
    overrides: Sequence[str] = (),
    settings: Sequence[str] = tuple(TARGETS),
    tolerance: str | float = TOLERANCE,
    increments: bool | None = None,
    steps: int | None = None,
) -> ConvergencePlan:
    """Check what is asked for and return the plan; raises CaseError with what is wrong.

    settings: three names or targets, the coarsest first
    tolerance: of K, a part of the largest of a step or a text such as "1 %"
    increments: whether the increment is halved as well; None: where that costs no more than the rest
    steps: growth steps (default: those of the case)
    """
    file = CaseFile(case, tuple(overrides))
    given = file.load()
    check_steps(given, steps)
    if steps is not None:
        file = CaseFile(case, (*overrides, f"growth.steps={steps}"))
        given = file.load()
    three = _three(file, settings)
    numerics = given.resolved["numerics"]
    same = (setting for setting in three if file.load(*setting.overrides).resolved["numerics"] == numerics)
    own = next(same, Setting(OWN, UNWRITTEN))
    grows = given.growth is not None and given.growth.steps > 0
    if increments and not grows:
        raise CaseError.at("--increments", "the case does not grow: it has no increments to halve")
    half = _halved(given, own) if grows and increments is not False else None
    return ConvergencePlan(file, given, three, own, half, increments, _tolerance(tolerance), folder)


def _three(file: CaseFile, names: Sequence[str]) -> tuple[Setting, ...]:
    """The three settings."""
    if len(names) != THREE or len(set(names)) != THREE:
        message = f"{', '.join(names)} given; wanted: three settings, the coarsest first, such as draft standard fine"
        raise CaseError.at("--at", message)
    found = []
    for name in names:
        try:
            accuracy = file.load(f"numerics.accuracy={name}").numerics.accuracy
        except CaseError as error:
            faults = [Fault("--at", None, "", f.message) if f.key == "numerics.accuracy" else f for f in error.faults]
            raise CaseError(faults) from error
        found.append(Setting(name, (*accuracy_overrides(accuracy), *UNWRITTEN)))
        file.load(*found[-1].overrides)
    targets = [file.load(*setting.overrides).numerics.target for setting in found]
    if any(a <= b for a, b in pairwise(targets)):
        message = f"{', '.join(names)} given; wanted: the largest error first"
        raise CaseError.at("--at", message)
    return tuple(found)


def _halved(case: Case, own: Setting) -> Setting:
    """A setting with half the increment and twice the steps; its cells follow the same rules."""
    growth = case.growth
    assert growth is not None
    more = (f"growth.increment={0.5 * growth.increment!r} m", f"growth.steps={2 * growth.steps}")
    return Setting(HALF, (*own.overrides, *more))


def _tolerance(given: str | float) -> float:
    """A part such as 0.01 or "1 %"."""
    text = str(given).strip()
    try:
        value = float(text.removesuffix("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        value = -1.0
    if not 0.0 < value < 1.0:
        message = f"'{text}' given; wanted: a part of the largest K such as 0.01 or '1 %'"
        raise CaseError.at("--tolerance", message)
    return value
