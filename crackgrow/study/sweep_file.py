"""The sweep file: which parameters of which case take which values. Read as strictly as a case, faults with lines."""

from __future__ import annotations

import math
from collections.abc import Mapping as AnyMapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

from crackgrow.case.format import format_of
from crackgrow.case.reader import Table, read_file
from crackgrow.case.report import Path as KeyPath
from crackgrow.case.report import Place, Report, did_you_mean
from crackgrow.case.scalars import Context
from crackgrow.case.units import Units
from crackgrow.study.values import KeyedValues, Listed, ParameterValues, Range, ValueText

MOST_RUNS: Final = 10_000  # of one sweep: more is a slip of the pen
MOST_KEYS: Final = 3  # of one fit: more are seldom told apart by a curve

FORMAT: Final = format_of(
    Path(__file__).with_name("sweep.yaml").read_text(encoding="utf-8"),
    kinds={"parameters": KeyedValues(ParameterValues()), "settings": KeyedValues(ValueText())},
    wrapped={},
)


@dataclass(frozen=True, slots=True)
class Kept:
    """Which files each run keeps."""

    frames: Literal["every_step", "first_and_last", "none"]
    figures: bool
    report: bool


@dataclass(frozen=True, slots=True)
class SweepFile:
    """A sweep file that has no faults of its own; what the case says of its values is not known yet."""

    path: Path
    places: AnyMapping[KeyPath, Place]  # of all keys
    base: Path
    parameters: AnyMapping[str, Listed | Range]
    settings: AnyMapping[str, str]
    reference: AnyMapping[str, str]
    design: Literal["grid", "zip", "latin_hypercube"]
    output: Kept
    samples: int | None
    responses: tuple[str, ...] | None
    seed: int = 0

    @property
    def fixed(self) -> tuple[str, ...]:
        """Overrides that all runs have."""
        kept = (f"output.{key}={str(value).lower()}" for key, value in FORMAT.written(self.output).items())
        return (*kept, *(f"{key}={text}" for key, text in self.settings.items()))


@dataclass(frozen=True, slots=True)
class Measured:
    """What was measured: a curve y(x), or the path of a crack."""

    file: str  # relative to the fit file
    x: str | None = None
    y: str | None = None
    crack: str | None = None
    columns: tuple[str, str] | None = None  # of the file


@dataclass(frozen=True, slots=True)
class FitFile:
    """A fit file that has no faults of its own."""

    path: Path
    base: Path
    parameters: AnyMapping[str, Range]
    settings: AnyMapping[str, str]
    measured: Measured

    @property
    def base_folder(self) -> Path:
        """The folder that names of files are relative to."""
        return self.path.parent


def read_sweep_file(path: Path) -> SweepFile:
    """The sweep of a YAML file; raises CaseError with all its faults."""
    values, base, report = _read(path, "SweepFile", "sweep", "cases/sweeps/angle_friction.yaml")
    if report.sound("parameters") and report.sound("design"):
        _check_design(values, report)
    if report.faults:
        raise report.error()
    return FORMAT.made(SweepFile, values, path=path, base=base, places=report.places)


def read_fit_file(path: Path) -> FitFile:
    """Read the definition of a fit from a YAML file. Raises CaseError with all errors in it."""
    values, base, report = _read(path, "FitFile", "fit", "cases/fits/rough_joint.yaml")
    for key, given in values["parameters"].items() if report.sound("parameters") else ():
        if not isinstance(given, Range) or given.n is not None:
            report.fault(("parameters", key), "wanted: a range {from, to} to search in, without n")
    if report.sound("parameters") and len(values["parameters"]) > MOST_KEYS:
        report.fault(("parameters",), f"{len(values['parameters'])} keys given; wanted: at most {MOST_KEYS}")
    if report.sound("measured"):
        measured = values["measured"]
        if ("x" in measured, "y" in measured, "crack" in measured) not in ((True, True, False), (False, False, True)):
            report.fault(("measured",), "wanted: x and y, of a curve, or crack, of a path")
        elif not (path.parent / measured["file"]).is_file():
            report.fault(("measured", "file"), f"there is no file {path.parent / measured['file']}")
    if report.faults:
        raise report.error()
    return FORMAT.made(FitFile, values, path=path, base=base)


def _read(path: Path, part: str, command: str, example: str) -> tuple[Any, Path, Report]:
    """The values of a file of a study, its base, and the report of its faults; raises CaseError with no mapping."""
    report = Report(str(path))
    root = read_file(path, report)
    if not isinstance(root, Table):
        if root is not None and not report.faults:
            report.fault((), f"the file holds no mapping; a {command} is written as key: value", root.place)
        raise report.error()
    if "bodies" in root.entries and "parameters" not in root.entries:
        study = f"a {command} has `base: {path.name}` and `parameters`, such as {example}"
        report.fault((), f"this is a case, not a {command} file: `crackgrow run {path}` runs it; {study}", root.place)
        raise report.error()
    values: Any = FORMAT.part(part).read(root, (), Context(report, Units(), path.parent))
    base = path.parent / values["base"] if report.sound("base") else path
    if report.sound("base") and not base.is_file():
        names = sorted(file.name for file in base.parent.glob("*.yaml"))
        report.fault(("base",), f"there is no case file {base}{did_you_mean(base.name, names)}")
    if report.sound("parameters") and report.sound("set"):
        for key in values["parameters"]:
            if key in values["set"]:
                report.fault(("set", key), "is a parameter too; give it in one place", report.places["set", key])
    return values, base, report


def _check_design(values: Any, report: Report) -> None:
    """Report what doesn't suit the design: numbers of values, keys of another design."""
    design, parameters = values["design"], values["parameters"]
    if design == "latin_hypercube":
        if "samples" not in values and report.sound("samples"):
            report.fault(("samples",), f"missing: a Latin hypercube needs a number of runs, 1 to {MOST_RUNS}")
    else:
        for key in ("samples", "seed"):
            if key in values:
                report.fault((key,), f"is for design: latin_hypercube; this is a {design}")
    for key, value in parameters.items():
        _check_parameter(("parameters", key), value, design, report)
    if not report.sound("parameters"):
        return
    counts = {key: len(v.texts) if isinstance(v, Listed) else v.n or 1 for key, v in parameters.items()}
    if design == "zip" and len(set(counts.values())) > 1:
        listed = ", ".join(f"{key}: {count}" for key, count in counts.items())
        report.fault(("parameters",), f"a zip takes as many values of each parameter; given are {listed}")
    n_runs = math.prod(counts.values()) if design == "grid" else max(counts.values())
    if report.sound("samples"):
        n_runs = values.get("samples", n_runs)
    if n_runs > MOST_RUNS:
        key = "samples" if "samples" in values else "parameters"
        report.fault((key,), f"this makes {n_runs} runs; at most {MOST_RUNS} are taken")


def _check_parameter(path: KeyPath, value: Listed | Range, design: str, report: Report) -> None:
    if isinstance(value, Range) and design == "latin_hypercube" and value.n is not None:
        report.fault((*path, "n"), "has no place in a Latin hypercube: `samples` is the number of its values")
    if isinstance(value, Range) and design != "latin_hypercube" and value.n is None:
        report.fault((*path, "n"), f"missing: the number of values from {value.low:g} to {value.high:g}")
    if isinstance(value, Listed) and design == "grid":
        for text in dict.fromkeys(text for text in value.texts if value.texts.count(text) > 1):
            report.fault(path, f"has the value {text} twice: a grid would make the same run again")
