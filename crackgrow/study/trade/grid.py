"""The runs of a trade: presets, every combination of the axes' values, and the reference."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from crackgrow.case import Case
from crackgrow.case.accuracy import PRESETS
from crackgrow.errors import CaseError
from crackgrow.study.setting import UNWRITTEN, CaseFile, Setting, accuracy_overrides
from crackgrow.study.trade.axes import KEYS, Axes

FINER = 2.0  # times: the reference's spacing below the finest that is judged


def settings_of(axes: Axes, presets: Sequence[str] = tuple(PRESETS)) -> list[Setting]:
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
    cases = [case for setting in settings if (case := case_or_none(file, setting.overrides)) is not None]
    spacing = min(case.numerics.spacing for case in cases) / FINER
    overrides = [*accuracy_overrides("fine"), f"numerics.spacing={spacing!r} m"]
    if "increment" in axes:
        increments = [case.growth.increment for case in cases if case.growth is not None]
        overrides.append(f"growth.increment={min(increments)!r} m")
    return tuple(overrides)


def case_or_none(file: CaseFile, overrides: Sequence[str]) -> Case | None:
    """The case with settings; None where their values, each allowed, don't fit together: the row will say why."""
    try:
        return file.load(*overrides)
    except CaseError:
        return None
