"""What a trade is going to run: presets, every combination of the axes' values, and the reference, checked before.

On disk the plan tells whether a study can be gone on with.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from crackgrow.case import Case, dump_case
from crackgrow.case.accuracy import STANDARD, TARGETS
from crackgrow.case.model import ContactSupport
from crackgrow.case.report import did_you_mean, quoted
from crackgrow.case.units import Metres
from crackgrow.errors import CaseError, Fault
from crackgrow.results.atomic import write_text
from crackgrow.study.setting import UNWRITTEN, CaseFile, Setting, accuracy_overrides, check_steps
from crackgrow.study.trade.measures import check_results

Axes = Mapping[str, tuple[str, ...]]

KEYS: Final[Mapping[str, str]] = {
    "spacing": "numerics.spacing",
    "support": "numerics.support",
    "quadrature": "numerics.quadrature",
    "contact_spacing": "numerics.contact.spacing",
    "stiffness": "numerics.contact.stiffness",
    "solver": "numerics.contact.solver",
    "tip_radius": "growth.tip_stress.radius",
    "increment": "growth.increment",
    "accuracy": "numerics.accuracy",
    "tips": "numerics.refine.tips",
    "kinks": "numerics.refine.kinks",
    "corners": "numerics.refine.corners",
    "tip_functions": "numerics.tip_functions",
}
"""The key of the case that an axis sets."""

SPACINGS: Final = (2.0, 1.5, 1.0, 0.7, 0.5)  # of the automatic spacing of cells of one size at standard accuracy
ONE_SIZE: Final = "numerics.refine={tips: 0, kinks: 0, corners: 0}"

FINER = 2.0  # times: the reference's spacing below the finest that is judged

FINEST: Final = "finest"
PLAN_FILE: Final = "plan.json"


def chosen_axes(file: CaseFile, texts: Sequence[str]) -> Axes:
    """The axes asked for, such as "spacing=3,2,1.5", or else those that suit the case.

    Raises CaseError with all faults: unknown axes, values that the case does not allow.
    """
    case = file.load()
    if not texts:
        return default_axes(file, case)
    faults: list[Fault] = []
    axes: dict[str, tuple[str, ...]] = {}
    for text in texts:
        name, equals, listed = text.partition("=")
        values = tuple(value.strip() for value in listed.split(","))
        if name not in KEYS:
            hint = did_you_mean(name, KEYS)
            faults.append(_fault(name, f"no such axis{hint}; there are {', '.join(KEYS)}"))
        elif not equals or not all(values):
            faults.append(_fault(name, f"{quoted(text)} given; wanted: values with commas between, {name}=A,B,C"))
        elif name in axes:
            faults.append(_fault(name, "given twice; write all its values in one"))
        elif len(set(values)) < len(values):
            faults.append(_fault(name, f"{quoted(listed)} has a value twice"))
        elif KEYS[name].startswith("growth.") and case.growth is None:
            faults.append(_fault(name, f"the case has no `growth`, so no {KEYS[name]}"))
        else:
            axes[name] = values
            faults.extend(fault for value in values for fault in _faults_of(file, name, value))
    if faults:
        raise CaseError(faults)
    return axes


def default_axes(file: CaseFile, case: Case) -> Axes:
    """Spacings round the automatic one, patches, quadrature, and the distance of contact nodes where faces touch."""
    automatic = file.load("numerics.spacing=auto", f"numerics.accuracy={STANDARD}", ONE_SIZE).numerics.spacing
    touching = [crack.contact for crack in case.cracks] + [
        None if interface.contact == "bonded" else interface.contact for interface in case.interfaces
    ]
    axes = {"spacing": tuple(f"{Metres(automatic * part):.3g}" for part in SPACINGS), "support": ("1.5", "2")}
    if any(touching) or any(isinstance(support, ContactSupport) for support in case.supports):
        return {**axes, "quadrature": ("3", "4"), "contact_spacing": ("1.25", "2")}
    return {**axes, "support": ("1.5", "2", "2.5"), "quadrature": ("2", "3", "4")}


def _faults_of(file: CaseFile, name: str, value: str) -> list[Fault]:
    """What the case says of one value; faults that are not the value's own keep their words."""
    _, faults = file.tried(f"{KEYS[name]}={value}")
    return [_fault(name, fault.message) if fault.key == KEYS[name] else fault for fault in faults]


def _fault(name: str, message: str) -> Fault:
    return Fault("--axis", None, name, message)


def settings_of(axes: Axes, presets: Sequence[str] = tuple(TARGETS)) -> list[Setting]:
    """The presets, then every combination of the axes' values, the first axis varying slowest."""
    found = [Setting(f"accuracy={name}", accuracy_overrides(name), name) for name in presets]
    for values in itertools.product(*axes.values()):
        pairs = list(zip(axes, values, strict=True))
        name = " ".join(f"{axis}={value}" for axis, value in pairs)
        found.append(Setting(name, tuple(f"{KEYS[axis]}={value}" for axis, value in pairs)))
    return found


def with_length(file: CaseFile, overrides: Sequence[str], steps: int | None) -> tuple[str, ...]:
    """A run's overrides: nothing drawn, and as many steps as make the length of `steps` of the case's own increment.

    steps: None for those of the case
    """
    base = file.load()
    if base.growth is None:
        return (*overrides, *UNWRITTEN)
    n_steps = base.growth.steps if steps is None else steps
    growth = file.load(*(text for text in overrides if text.startswith(f"{KEYS['increment']}="))).growth
    assert growth is not None  # the base has it
    n_steps = math.ceil(n_steps * base.growth.increment / growth.increment - 1e-9)
    return (*overrides, f"growth.steps={n_steps}", *UNWRITTEN)


def finest(file: CaseFile, settings: Sequence[Setting], axes: Axes) -> tuple[str, ...]:
    """Overrides of the reference: half the finest spacing there is, the shortest increment, the rest as `fine`.

    So are the cells at tips, kinks and corners, unless the spacing is smaller.
    """
    tried = [file.tried(*setting.overrides)[0] for setting in settings]
    cases = [case for case in tried if case is not None]  # else values, each allowed, don't fit: the row will say why
    spacing = min(case.numerics.spacing for case in cases) / FINER
    overrides = [*accuracy_overrides("fine"), f"numerics.spacing={spacing!r} m"]
    if "increment" in axes:
        increments = [case.growth.increment for case in cases if case.growth is not None]
        overrides.append(f"growth.increment={min(increments)!r} m")
    return tuple(overrides)


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
            raise CaseError.at("--resume", f"{self.folder} holds no trade to go on with")
        before, now = json.loads(path.read_text(encoding="utf-8")), self.identity()
        different = [key for key in now if before.get(key) != now[key]]
        if different:
            message = f"the trade in {self.folder} had another {' and '.join(different)}; leave out --resume"
            raise CaseError.at("--resume", message)


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
    case = file.load()
    check_steps(case, steps)
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
    return Plan(file, case.growth is not None, tuple(settings), true, steps, folder)
