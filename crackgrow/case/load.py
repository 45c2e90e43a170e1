"""Reading a case file: text, overrides, format, checks, model; all faults are raised together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

from crackgrow.case.build import build_case
from crackgrow.case.check_agreement import check_agreement
from crackgrow.case.check_bodies import check_interfaces, check_loads
from crackgrow.case.check_cracks import check_cracks
from crackgrow.case.check_loading import check_loading
from crackgrow.case.check_points import check_points
from crackgrow.case.check_regions import check_regions, settle_bodies
from crackgrow.case.check_strength import check_initiation, check_strength, check_subcritical, settle_direction
from crackgrow.case.check_supports import check_foundations, check_supports
from crackgrow.case.checks import check_contacts, check_counts, check_material, check_numerics
from crackgrow.case.crack_sets import expand_crack_sets
from crackgrow.case.format import CASE, DEFINITIONS, UNITS_SPEC
from crackgrow.case.layout import Scene, place_cracks, scene_of
from crackgrow.case.minimal_supports import settle_supports
from crackgrow.case.model import Case
from crackgrow.case.overrides import apply_override, with_base
from crackgrow.case.reader import Node, Table, parse, read_file
from crackgrow.case.report import Place, Report
from crackgrow.case.scalars import Context
from crackgrow.case.spacing import settle_spacing
from crackgrow.case.units import Units

STAGES: Final[tuple[Callable[[Scene], None], ...]] = (
    settle_bodies,
    check_regions,
    expand_crack_sets,
    settle_spacing,
    place_cracks,
    settle_supports,
    check_counts,
    check_material,
    settle_direction,
    check_strength,
    check_initiation,
    check_subcritical,
    check_numerics,
    check_cracks,
    check_contacts,
    check_interfaces,
    check_foundations,
    check_supports,
    check_agreement,
    check_loads,
    check_loading,
    check_points,
)


def load_case(path: str | Path, overrides: Sequence[str] = ()) -> Case:
    """Return the checked case of a YAML file, in SI units.

    path: the case file; the case is named after it
    overrides: settings such as "numerics.spacing=1.5" that replace those of the file, the last one wins

    Raises CaseError with every fault found, TypeError where `overrides` is one text in place of a list of them.
    """
    if isinstance(overrides, str):
        raise TypeError(f"overrides are a list of settings such as [{overrides!r}], not a text")
    report = Report(str(path))
    root = read_file(path, report)
    if Path(path).stem in ("", ".", ".."):  # the case is named after its file, and its results after the case
        report.fault((), "the file has no name of its own; wanted: such as my_case.yaml", Place(str(path), None))
    elif not _is_text(Path(path).stem):
        place = Place(str(path), None)
        report.fault((), "the file's name is no text in UTF-8, and the case is named after it; rename it", place)
    return _case_of(root, report, overrides, Path(path))


def read_case(text: str, source: str, name: str, overrides: Sequence[str] = ()) -> Case:
    """Return the checked case of a YAML text, in SI units; `source` stands for its file in faults.

    Raises CaseError with every fault found.
    """
    report = Report(source)
    return _case_of(parse(text, report, Place(source, 1)), report, overrides, Path(f"{name}.yaml"))


def _case_of(root: Node | None, report: Report, overrides: Sequence[str], path: Path) -> Case:
    """The checked case of a node tree. Raises CaseError with every fault found."""
    if not isinstance(root, Table):
        if root is not None and not report.faults:
            report.fault((), "the file holds no mapping; a case is written as key: value", root.place)
        raise report.error()
    if "base" in root.entries and "parameters" in root.entries:
        report.fault((), f"this is a sweep file, not a case: `crackgrow sweep {report.source}` runs it", root.place)
        raise report.error()
    folders: dict[str, Path] = {}
    root = with_base(root, path, report, folders)
    if root is None:
        raise report.error()
    for override in overrides:
        apply_override(root, override, report)
    units = _units_of(root)
    context = Context(report, units or Units(), path.parent, folders)
    resolved: Any = CASE.read(root, (), context)
    if units is None:
        raise report.error()
    for definitions in DEFINITIONS:  # each is written out where it is referred to
        resolved.pop(definitions, None)
    scene = scene_of(resolved, report, units)
    for stage in STAGES:
        stage(scene)
    if report.faults:
        raise report.error()
    resolved["units"] = {"length": "m", "stress": "Pa"}
    return build_case(path.stem, scene)


def _is_text(name: str) -> bool:
    """Whether a name can be written into files: the system has other bytes as halves of surrogate pairs."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def _units_of(root: Table) -> Units | None:
    """Return what bare numbers mean, None if that is faulty; the faults are reported with the rest of the case."""
    if "units" not in root.entries:
        return Units()
    scratch = Report("")
    values: Any = UNITS_SPEC.read(root.entries["units"].node, ("units",), Context(scratch, Units()))
    sound = isinstance(values, dict) and all(isinstance(unit, str) for unit in values.values())
    return Units(**values) if sound else None  # what the parser refused is no fault of the scratch report
