"""What a trade is going to run, checked before anything runs; on disk it tells whether a study can be gone on with."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from crackgrow.case import dump_case
from crackgrow.errors import CaseError, Fault
from crackgrow.results.atomic import write_text
from crackgrow.study.setting import CaseFile, Setting
from crackgrow.study.trade.axes import chosen_axes
from crackgrow.study.trade.grid import finest, settings_of, with_length
from crackgrow.study.trade.measures import check_results

FINEST: Final = "finest"
PLAN_FILE: Final = "plan.json"


@dataclass(frozen=True, slots=True)
class Plan:
    """A trade, ready to run."""

    file: CaseFile
    grows: bool
    settings: tuple[Setting, ...]
    reference: tuple[str, ...] | Path  # overrides of a run to make, or the folder of one
    steps: int | None  # of growth, of the case's own increment; None: those of the case
    folder: Path

    def run_overrides(self, overrides: Sequence[str]) -> tuple[str, ...]:
        """All that a run is given beside the case file."""
        return with_length(self.file, overrides, self.steps)

    @property
    def reference_folder(self) -> Path:
        """Where the reference's results are, or will be."""
        return self.reference if isinstance(self.reference, Path) else self.folder / "reference"

    def identity(self) -> dict[str, object]:
        """What must be the same for rows of two studies to stand in one table."""
        reference = self.reference if isinstance(self.reference, tuple) else (str(self.reference.resolve()),)
        return {"case": dump_case(self.file.load()), "reference": list(reference), "steps": self.steps}

    def write(self) -> None:
        """Leave the identity in the folder; raises OutputError."""
        write_text(self.folder / PLAN_FILE, json.dumps(self.identity(), indent=1) + "\n")

    def check_same(self) -> None:
        """Raise CaseError where the folder holds another study, or none."""
        path = self.folder / PLAN_FILE
        if not path.is_file():
            raise CaseError([Fault("--resume", None, "", f"{self.folder} holds no trade to go on with")])
        before, now = json.loads(path.read_text(encoding="utf-8")), self.identity()
        different = [key for key in now if before.get(key) != now[key]]
        if different:
            message = f"the trade in {self.folder} had another {' and '.join(different)}; leave out --resume"
            raise CaseError([Fault("--resume", None, "", message)])


def plan_trade(
    file: CaseFile,
    folder: Path,
    *,
    axes: Sequence[str] = (),
    reference: Sequence[str] = (FINEST,),
    steps: int | None = None,
    presets: bool = True,
) -> Plan:
    """Check what is asked for and return the plan.

    axes: such as "spacing=3,2,1.5"; none: those that suit the case
    reference: "finest", a result folder, or settings of the case such as "numerics.spacing=0.25"
    steps: growth steps of the case's own increment
    presets: whether draft, standard and fine are run beside the grid

    Raises CaseError with what is wrong.
    """
    grows = file.load().growth is not None
    if steps is not None and not (grows and steps >= 0):
        message = f"{steps} given; " + ("wanted: 0 or more" if grows else "the case has no `growth`, so no steps")
        raise CaseError([Fault("--steps", None, "", message)])
    chosen = chosen_axes(file, axes)
    settings = settings_of(chosen) if presets else settings_of(chosen, ())
    true: tuple[str, ...] | Path
    if tuple(reference) == (FINEST,):
        true = finest(file, settings, chosen)
    elif len(reference) == 1 and "=" not in reference[0]:
        true = Path(reference[0])
        check_results(true)
    else:
        true = tuple(reference)
        file.load(*true)
    return Plan(file, grows, tuple(settings), true, steps, folder)
