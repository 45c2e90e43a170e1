"""What becomes of mutated case files.

Every mutant is accepted, or refused with places; the JSON Schema refuses it too, or what it cannot express is counted.
"""

from __future__ import annotations

import json
import resource
import signal
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import yaml
from jsonschema import Draft7Validator

from crackgrow.case import load_case
from crackgrow.case.format import CASE
from crackgrow.case.json_schema import case_schema
from crackgrow.case.reader import Table, read_file
from crackgrow.case.report import Report
from crackgrow.case.scalars import Context
from crackgrow.case.units import Units
from crackgrow.errors import CaseError, Fault
from tests.stability.mutations import good_cases, mutant
from tests.yaml12 import read_yaml12

LONGEST = 5.0
"""Seconds that validation may take."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What the reader and an editor with the JSON Schema say of one mutant."""

    number: int
    kind: str
    case: str
    faults: tuple[Fault, ...] | None  # None: accepted
    broken: str  # another exception than CaseError, or too slow, else empty
    seconds: float  # of CPU
    editor_accepts: bool
    wrong_alone: bool  # refused for a value that is wrong whatever the others are, or as YAML

    @property
    def accepted(self) -> bool:
        return self.faults is None and not self.broken


class _TooLongError(Exception):
    pass


@contextmanager
def _time_limit(seconds: float) -> Iterator[None]:
    def stop(number: int, frame: FrameType | None) -> None:
        raise _TooLongError

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)  # of CPU: other programs do not count
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def judge(number: int, good: Mapping[str, str], folder: Path, schema: Draft7Validator) -> Verdict:
    """Read a mutant as a case, and as an editor would."""
    kind, case, data = mutant(number, good)
    path = folder / "scene.yaml"
    path.write_bytes(data)
    faults: tuple[Fault, ...] | None = None
    broken, start = "", time.process_time()
    try:
        with _time_limit(LONGEST):
            load_case(path)
    except CaseError as error:
        faults = error.faults
        if not all(fault.source == str(path) and (fault.line or not fault.key) and fault.message for fault in faults):
            broken = "no place"
    except _TooLongError:
        broken = f"more than {LONGEST:g} s"
    except Exception as error:
        broken = f"{type(error).__name__}: {error}"
    seconds = time.process_time() - start
    alone = faults is not None and _is_wrong_alone(path)
    return Verdict(number, kind, case, faults, broken, seconds, _editor_accepts(data, schema), alone)


def _is_wrong_alone(path: Path) -> bool:
    """Whether reading keys and values finds faults, before any of them is held against another, or against a file."""
    report = Report(str(path))
    root = read_file(path, report)
    if isinstance(root, Table):
        CASE.read(root, (), Context(report, Units(), path.parent))
    return root is None or any(not fault.key.endswith(".file") for fault in report.faults)


def _editor_accepts(data: bytes, schema: Draft7Validator) -> bool:
    try:
        value = read_yaml12(data.decode("utf-8-sig"))
    except (UnicodeDecodeError, yaml.YAMLError, RecursionError, ValueError):
        return False
    return schema.is_valid(value)


def verdicts(n: int, first: int = 0) -> Iterator[Verdict]:
    """Judge mutants, one after another."""
    good, schema = good_cases(), Draft7Validator(json.loads(case_schema()))
    with tempfile.TemporaryDirectory() as folder:
        for number in range(first, first + n):
            yield judge(number, good, Path(folder), schema)


def peak_memory() -> float:
    """MiB that this process has had at most."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
