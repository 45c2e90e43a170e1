"""What a trade is going to run: a case on several settings of its cells and increments, checked before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

from crackgrow.case import Case
from crackgrow.case.accuracy import TARGETS
from crackgrow.case.dump import written
from crackgrow.case.format import FORMAT
from crackgrow.case.model import ContactNumerics, Numerics
from crackgrow.errors import CaseError, Fault
from crackgrow.geometry.tolerance import SAME_PART
from crackgrow.study.plan import UNWRITTEN, CaseFile, Run, Study, folder_names

OWN: Final = "own"
HALF: Final = "half"
NONE: Final = "none"
LEAST: Final = 3  # settings that values are extrapolated from
TOLERANCE: Final = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class TradePlan:
    """The runs, and what is asked of them."""

    study: Study
    case: Case  # as it is given, with the number of steps that was asked for
    settings: tuple[str, ...]  # names of those of cells, the coarsest first
    own: str  # one of them, or a run of its own
    increments: tuple[str, ...]  # runs with the cells of the own one, the longest first
    tolerance: float  # of K, over the largest of a step

    @property
    def grows(self) -> bool:
        """Whether steps are of growth."""
        return self.case.growth is not None and self.case.growth.steps > 0


def plan_trade(
    case: str | Path,
    folder: str | Path | None = None,
    *,
    overrides: Sequence[str] = (),
    settings: Sequence[str] = tuple(TARGETS),
    tolerance: str | float = TOLERANCE,
    increments: Sequence[str] = (HALF,),
    steps: int | None = None,
) -> TradePlan:
    """Check what is asked for and return the plan; raises CaseError with what is wrong.

    folder: of the results; default outputs/trade/<name of the case>
    settings: three or more names or targets, the coarsest first
    tolerance: of K, a part of the largest of a step or a text such as "1 %"
    increments: lengths, run with as many steps as make the length of the case's own; or "half", or "none"
    steps: growth steps (default: those of the case)
    """
    file = CaseFile(Path(case), tuple(overrides))
    base = file.load()
    if steps is not None:
        if base.growth is None or steps < 0:
            wanted = "wanted: 0 or more" if base.growth else "the case has no `growth`, so no steps"
            raise CaseError.at("--steps", f"{steps} given; {wanted}")
        file = CaseFile(file.path, (*file.overrides, f"growth.steps={steps}"))
        base = file.load()
    made = _settings(file, settings)
    asked = {name: accuracy_overrides(one.numerics.accuracy) for name, one in made.items()}
    own = next((name for name, one in made.items() if written(one)["numerics"] == written(base)["numerics"]), OWN)
    cells = {**asked, **({} if own in asked else {OWN: ()})}
    shorter = {name: (*cells[own], *growth) for name, growth in _increments(file, base, increments).items()}
    names = [*cells, *shorter]
    folder = Path("outputs/trade") / base.name if folder is None else Path(folder)
    runs = []
    for number, (name, words) in enumerate(zip(names, folder_names(names), strict=True)):
        one = CaseFile(file.path, (*file.overrides, *({**cells, **shorter}[name]), *UNWRITTEN))
        runs.append(Run(number, name, folder / words, (name,), one, one.load()))
    study = Study("trade", base.name, base.title, folder, ("setting",), tuple(runs))
    return TradePlan(study, base, tuple(asked), own, tuple(shorter), _tolerance(tolerance))


def accuracy_overrides(accuracy: str | float) -> tuple[str, ...]:
    """All that a preset or a target sets or counts on, given as keys, which a case's own would win over otherwise."""
    numerics, contact = FORMAT.keys_of(Numerics), FORMAT.keys_of(ContactNumerics)
    return (
        f"numerics.accuracy={accuracy}",
        "numerics.spacing=auto",
        "numerics.refine={tips: auto, kinks: auto, corners: auto}",
        f"numerics.support={numerics['support'].default}",
        f"numerics.quadrature={numerics['quadrature'].default}",
        f"numerics.contact.spacing={contact['spacing'].default}",
    )


def _settings(file: CaseFile, names: Sequence[str]) -> dict[str, Case]:
    """The case with the settings asked for, by name."""
    if len(names) < LEAST or len(set(names)) < len(names):
        wanted = "wanted: three settings or more, the coarsest first, such as draft standard fine"
        raise CaseError.at("--at", f"{', '.join(names)} given; {wanted}")
    found = {}
    for name in names:
        case = _with(file, "numerics.accuracy", name, "--at")
        found[name] = file.load(*accuracy_overrides(case.numerics.accuracy))
    if any(a <= b for a, b in pairwise(case.numerics.target for case in found.values())):
        raise CaseError.at("--at", f"{', '.join(names)} given; wanted: the largest error first")
    return found


def _increments(file: CaseFile, base: Case, lengths: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Overrides of other increments by name, the longest first, each with as many steps as make the same length."""
    growth = base.growth
    if growth is None or not growth.steps:
        if tuple(lengths) not in ((HALF,), (NONE,)):
            raise CaseError.at("--increments", "the case does not grow: it has no increments")
        return {}
    found: dict[str, tuple[float, tuple[str, ...]]] = {}
    for text in () if tuple(lengths) == (NONE,) else lengths:
        length = f"{0.5 * growth.increment!r} m" if text == HALF else text
        other = _with(file, "growth.increment", length, "--increments").growth
        assert other is not None  # since the case grows
        if other.increment > (1.0 - SAME_PART) * growth.increment:
            raise CaseError.at("--increments", f"{text} given; wanted: shorter than the case's own one")
        n_steps = math.ceil(growth.steps * growth.increment / other.increment - 1e-9)
        found[f"{text} increment"] = other.increment, (f"growth.increment={length}", f"growth.steps={n_steps}")
    return {name: found[name][1] for name in sorted(found, key=lambda name: -found[name][0])}


def _with(file: CaseFile, key: str, value: str, option: str) -> Case:
    """The case with another value of a key; raises CaseError, of what is wrong with the value at the option."""
    case, faults = file.tried(f"{key}={value}")
    if case is None:
        raise CaseError([Fault(option, None, "", fault.message) if fault.key == key else fault for fault in faults])
    return case


def _tolerance(given: str | float) -> float:
    """A part such as 0.01 or "1 %"."""
    text = str(given).strip()
    try:
        value = float(text.removesuffix("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        value = -1.0
    if not 0.0 < value < 1.0:
        raise CaseError.at("--tolerance", f"'{text}' given; wanted: a part of the largest K such as 0.01 or '1 %'")
    return value
