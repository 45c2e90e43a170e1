"""Random scenes are solved, with equilibrium and every condition of contact, or refused with a reason that says why."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.errors import CaseError, CrackgrowError
from crackgrow.run import grow
from crackgrow.run.residual import WORST_RESIDUAL
from tests.stability.contact_conditions import Increment, recorded, violations
from tests.stability.random_scenes import random_scene, text_of

FEW, MANY = range(20), range(1000)

RESIDUAL = 1e-9
"""Relative equilibrium residual of an increment, but for ill-conditioned scenes: steps of these say so."""

ILL_CONDITIONED = 0.03
"""Of the scenes, at most. Their residual is below what the program refuses."""

JUMPS = "jumps of the faces are off by"
"""What a step says whose contact conditions are ill conditioned."""

VIOLATION = 1e-7
"""Relative violation of a condition of contact."""

VIOLATED = 0.01
"""Of the scenes, at most, have a larger one: ill-conditioned ones, whose steps say so."""

LONGEST = 60.0
"""Seconds."""

LONG = 0.003
"""Of the scenes, at most, take longer: pieces that contact alone holds, near the load that lets them go."""

NOT_READ = 0.01
"""Of the scenes, at most: the generator makes what the reader accepts."""

SOLVED = 0.7
"""Of the scenes, at least; the others are mostly pieces that slide or rock off what contact alone holds."""

REASONS = (
    "is free to move",
    "the criterion is met under the held loads alone",
    "the contact problem of",
    "the system is too ill conditioned",
    "the system is ill conditioned",
    "contact alone holds",
    "no critical load factor found",
    "use a smaller dilation angle",
    "supports contradict each other",
)
"""What a scene may be refused for after it was read; any other reason is a fault of the program."""


@dataclass(frozen=True, slots=True)
class Trial:
    """How one scene ended."""

    reason: str  # empty where it was solved
    read: bool  # whether the reader accepted it
    seconds: float
    increments: list[Increment]


def attempt(folder: Path, seed: int) -> Trial:
    """Read and run the scene; errors of any other kind than a refusal, and warnings, are let through."""
    path = folder / "scene.yaml"
    path.write_text(text_of(random_scene(seed)), encoding="utf-8")
    start, reason, read = time.perf_counter(), "", True
    with recorded() as increments:
        try:
            for result in grow(load_case(path)):
                assert np.isfinite([result.residual, result.penetration, result.complementarity]).all()
                told = any("the equilibrium residual is" in warning for warning in result.warnings)
                assert told == (result.residual > RESIDUAL)
        except CrackgrowError as error:
            reason = str(error)
            read = not isinstance(error, CaseError)
    return Trial(reason, read, time.perf_counter() - start, increments)


def check(folder: Path, seeds: range) -> Counter[str]:
    """Check the scenes one by one; returns how many ended in which way."""
    ends: Counter[str] = Counter()
    for seed in seeds:
        trial, violated = attempt(folder, seed), False
        for increment in trial.increments:
            assert np.isfinite(increment.outcome.u).all(), f"seed {seed}"
            assert increment.outcome.residual <= WORST_RESIDUAL, f"seed {seed}"
            worst = {name: value for name, value in violations(increment).items() if not value < VIOLATION}
            told = increment.outcome.residual > RESIDUAL or any(JUMPS in note for note in increment.outcome.notes)
            assert not worst or told, f"seed {seed}: {worst}"
            violated |= bool(worst)
        known = [words for words in REASONS if words in trial.reason]
        assert not trial.reason or not trial.read or known, f"seed {seed}: {trial.reason}"
        ends["violated"] += violated
        ends["long"] += trial.seconds > LONGEST
        ends["ill conditioned"] += any(increment.outcome.residual > RESIDUAL for increment in trial.increments)
        ends["solved" if not trial.reason else known[0] if trial.read else "not read"] += 1
    return ends


def test_a_few_scenes(tmp_path: Path) -> None:
    ends = check(tmp_path, FEW)
    assert ends["solved"] >= SOLVED * len(FEW), ends
    assert ends["ill conditioned"] == ends["violated"] == ends["long"] == 0


@pytest.mark.slow
def test_many_scenes(tmp_path: Path) -> None:
    ends = check(tmp_path, MANY)
    assert ends["solved"] >= SOLVED * len(MANY), ends
    assert ends["ill conditioned"] <= ILL_CONDITIONED * len(MANY), ends
    assert ends["violated"] <= VIOLATED * len(MANY), ends
    assert ends["long"] <= LONG * len(MANY), ends
    assert ends["not read"] <= NOT_READ * len(MANY), ends
