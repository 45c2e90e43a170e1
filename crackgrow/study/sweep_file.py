"""Sweep and fit files: which keys of which case take which values. Read as strictly as a case, faults with lines."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Sequence
from collections.abc import Mapping as AnyMapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.format import format_of
from crackgrow.case.reader import Broken, Listing, Node, Scalar, Table, read_file
from crackgrow.case.report import Path as KeyPath
from crackgrow.case.report import Place, Report, did_you_mean, quoted
from crackgrow.case.scalars import INVALID, Context, refuse
from crackgrow.case.units import QuantityError, Units, parse_number
from crackgrow.errors import Fault
from crackgrow.study.plan import UNWRITTEN, CaseFile

MOST_RUNS: Final = 10_000  # of one sweep: more is a slip of the pen
MOST_KEYS: Final = 3  # of one fit: more are seldom told apart by a curve
DIGITS: Final = 12  # of a generated value: what is beyond is rounding, and 0.3 is not to be 0.30000000000000004
_PLAIN_ENDS: Final = re.compile(r"[,\[\]{}]")  # what a word without quotes can't hold inside a list
_NUMBER_AND_UNIT: Final = re.compile(r"([-+.\deE]*[\d.])\s*([^\W\d_].*)?")


@dataclass(frozen=True, slots=True)
class Listed:
    """Values one by one."""

    texts: tuple[str, ...]  # as an override takes them

    def at(self, parts: Floats) -> tuple[str, ...]:
        """The values that take the places 0 <= part < 1 in the list."""
        return tuple(self.texts[int(part * len(self.texts))] for part in parts)


@dataclass(frozen=True, slots=True)
class Range:
    """Numbers from one to another, both taken, evenly spaced on their scale."""

    low: float
    high: float
    unit: str  # of both, empty for bare numbers
    n: int | None
    log: bool

    @property
    def texts(self) -> tuple[str, ...]:
        """The values, as an override takes them; one where the design chooses."""
        return self.at(np.linspace(0.0, 1.0, self.n or 1))

    def at(self, parts: Floats) -> tuple[str, ...]:
        """The values at parts of the range: low at 0, high at 1."""
        return tuple(f"{value:.{DIGITS}g} {self.unit}".strip() for value in self.numbers(parts).tolist())

    def numbers(self, parts: Floats) -> Floats:
        """The same as numbers."""
        ratio = self.high / self.low if self.log else 1.0
        return np.asarray(self.low * ratio**parts if self.log else self.low + (self.high - self.low) * parts)


@dataclass(frozen=True, slots=True)
class Given:
    """What a key of these files takes: what it is in words, and the function that reads it, as specs of a case do."""

    words: str
    read: Callable[[Node, KeyPath, Context], object]

    def describe(self) -> str:
        return self.words


def _read_number(node: Node, path: KeyPath, context: Context) -> object:
    """A number and its unit, empty for a bare one; the case checks them."""
    match = _NUMBER_AND_UNIT.fullmatch(node.text.strip()) if isinstance(node, Scalar) else None
    if not isinstance(node, Scalar) or match is None:
        return refuse(node, NUMBER.words, path, context)
    try:
        return parse_number(match[1]), match[2] or ""
    except QuantityError as error:
        return context.refused(path, f"{quoted(node.text)} {error}; wanted: {NUMBER.words}")


def _read_values(node: Node, path: KeyPath, context: Context) -> object:
    """Listed or Range, of one parameter."""
    if isinstance(node, Table):
        found: Any = FORMAT.part("Range").read(node, path, context)
        return _range(found, path, context) if context.report.sound(*path) else INVALID
    if not isinstance(node, Listing):
        return refuse(node, VALUES.words, path, context)
    if not node.items:
        return context.refused(path, "an empty list given; wanted: at least one value")
    texts: list[Any] = []
    for index, item in enumerate(node.items):
        context.report.put((*path, index), item.place)
        texts.append(_read_text(item, (*path, index), context))
    return Listed(tuple(texts)) if context.report.sound(*path) else INVALID


def _range(found: dict[str, Any], path: KeyPath, context: Context) -> object:
    (low, unit), (high, other), log = found["from"], found["to"], found["scale"] == "log"
    if unit != other:
        return context.refused(path, f"from has the unit '{unit}', to has '{other}'; give both the same")
    if low == high:
        return context.refused(path, f"from and to are both {low:g}; a range has two ends")
    if log and min(low, high) <= 0.0:
        return context.refused(path, "scale: log needs `from` and `to` above 0")
    return Range(low, high, unit, found.get("n"), log)


def _read_text(node: Node, path: KeyPath, context: Context) -> object:
    """Any value, as text that reads back to it."""
    try:
        return yaml_text(node)
    except ValueError:  # of what the reader has found broken
        return INVALID


def keyed(of: Given) -> Given:
    """A mapping from keys of the case, such as numerics.spacing, in the order of the file; one key at least."""
    words = f"a mapping of keys of the case such as numerics.spacing, each {of.words}"

    def read(node: Node, path: KeyPath, context: Context) -> object:
        if not isinstance(node, Table) or not node.entries:
            return refuse(node, words, path, context)
        values: dict[str, object] = {}
        for key, entry in node.entries.items():
            inner = (*path, key)
            context.report.put(inner, entry.place)
            if not all(key.split(".")) or "=" in key:
                context.report.fault(inner, f"{quoted(key)} is not a key path such as numerics.spacing")
            else:
                values[key] = of.read(entry.node, inner, context)
        return values

    return Given(words, read)


def yaml_text(node: Node, inside: bool = False) -> str:
    """The node on one line of YAML, or `inside` another; what was in quotes stays so. Raises ValueError if broken."""
    if isinstance(node, Listing):
        return f"[{', '.join(yaml_text(item, inside=True) for item in node.items)}]"
    if isinstance(node, Table):
        entries = (f"{json.dumps(key)}: {yaml_text(of.node, inside=True)}" for key, of in node.entries.items())
        return f"{{{', '.join(entries)}}}"
    if isinstance(node, Broken):
        raise ValueError("a broken node has no text")
    text = node.text if node.plain else json.dumps(node.text, ensure_ascii=False)
    return json.dumps(text, ensure_ascii=False) if inside and _PLAIN_ENDS.search(text) else text


NUMBER: Final = Given("a number, bare or with a unit", _read_number)
VALUES: Final = Given("a list of values, or {from, to, n, scale}", _read_values)
SETTING: Final = Given("a value as the case takes it", _read_text)
FORMAT: Final = format_of(
    Path(__file__).with_name("sweep.yaml").read_text(encoding="utf-8"),
    kinds={"parameters": keyed(VALUES), "settings": keyed(SETTING), "number with a unit": NUMBER},
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

    def case_file(self, values: AnyMapping[str, str]) -> CaseFile:
        """The case with what all runs have, and then these values of keys: a value may set what others lie in."""
        kept = (f"output.{key}={str(value).lower()}" for key, value in FORMAT.written(self.output).items())
        given = (*self.settings.items(), *values.items())
        return CaseFile(self.base, (*kept, *(f"{key}={text}" for key, text in given)))


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
    places: AnyMapping[KeyPath, Place]
    base: Path
    parameters: AnyMapping[str, Range]
    settings: AnyMapping[str, str]
    measured: Measured

    def case_file(self, texts: Sequence[str]) -> CaseFile:
        """The case with these values of the parameters, without what a fit does not need of its runs."""
        given = {**self.settings, **dict(zip(self.parameters, texts, strict=True))}
        return CaseFile(self.base, (*UNWRITTEN, *(f"{key}={text}" for key, text in given.items())))


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
    return FORMAT.made(FitFile, values, path=path, base=base, places=report.places)


def placed(file: SweepFile | FitFile, faults: Iterable[Fault]) -> list[Fault]:
    """Faults that a case has found in values, with the line of the file that gives them."""
    found = []
    for fault in faults:
        given = (file.places.get((part, fault.of_override)) for part in ("parameters", "reference", "set"))
        place = next(filter(None, given), None)
        found.append(replace(fault, source=place.source, line=place.line) if place else fault)
    return found


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
