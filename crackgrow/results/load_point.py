"""What the load curve shows of a step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from crackgrow.run.result import StepResult


@dataclass(frozen=True, slots=True)
class LoadPoint:
    """A step on the load curve."""

    factor: float
    displacement: float  # m, of the loads
    crack_length: float  # m, of all cracks
    slip: Mapping[str, float]  # m, largest slip, with its sign, of every surface that has a contact law


def load_point(result: StepResult) -> LoadPoint:
    """The point of a step."""
    touching = [face for face in result.faces if face.crack in result.contact.crack]
    slip = {face.crack: float(face.slip[np.argmax(np.abs(face.slip))]) for face in touching}
    return LoadPoint(result.load_factor, result.load_displacement, result.crack_length, slip)
