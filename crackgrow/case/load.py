"""Reading a case file: text, overrides, format, checks, model; all faults are raised together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path as FilePath
from typing import Any, Final

from crackgrow.arrays import frozen
from crackgrow.case import model
from crackgrow.case.check_actions import check_agreement, check_foundations, check_loads, check_supports
from crackgrow.case.check_cracks import check_cracks
from crackgrow.case.check_loading import check_loading
from crackgrow.case.check_regions import check_regions, place_points, settle_bodies
from crackgrow.case.check_strength import check_initiation, check_rate_law, check_strength, settle_direction
from crackgrow.case.checks import check_contacts, check_interfaces, check_material, check_numerics
from crackgrow.case.crack_sets import place_ends_and_sets
from crackgrow.case.drawings import read_drawings
from crackgrow.case.format import CASE, DEFINITIONS, FORMAT
from crackgrow.case.layout import Scene, place_cracks, scene_of
from crackgrow.case.model import Case
from crackgrow.case.overrides import apply_override, with_base
from crackgrow.case.reader import Node, Table, has_half_pair, parse, read_file
from crackgrow.case.report import Faults, Path, Place, Report
from crackgrow.case.scalars import Context
from crackgrow.case.segments import opened, parted
from crackgrow.case.shapes import BodyShape, Resolved, Ring
from crackgrow.case.shorthand import settle_outlines, settle_supports
from crackgrow.case.sizing import settle_spacing
from crackgrow.case.surface import SurfaceName, crack_name
from crackgrow.case.touching import shared_lines
from crackgrow.case.units import Units

REDUCTION: Final = "strength_reduction"

STAGES: Final[tuple[Callable[[Scene], Faults | None], ...]] = (
    settle_outlines,
    settle_bodies,
    check_regions,
    place_ends_and_sets,
    settle_spacing,
    place_cracks,
    settle_supports,
    settle_direction,
    place_points,
    check_material,
    check_strength,
    check_initiation,
    check_rate_law,
    check_numerics,
    check_cracks,
    check_contacts,
    check_interfaces,
    check_foundations,
    check_supports,
    check_agreement,
    check_loads,
    check_loading,
)
"""What settles the scene, each from what those before it have found; checks only read it. Each yields faults."""


def load_case(path: str | FilePath, overrides: Sequence[str] = ()) -> Case:
    """Return the checked case of a YAML file, in SI units.

    path: the case file; the case is named after it
    overrides: settings such as "numerics.spacing=1.5" that replace those of the file, the last one wins

    Raises CaseError with every fault found, TypeError where `overrides` is one text in place of a list of them.
    """
    if isinstance(overrides, str):
        raise TypeError(f"overrides are a list of settings such as [{overrides!r}], not a text")
    report = Report(str(path))
    root = read_file(path, report)
    name, place = FilePath(path).stem, Place(str(path), None)
    if name in ("", ".", ".."):  # the case is named after its file, and its results after the case
        report.fault((), "the file has no name of its own; wanted: such as my_case.yaml", place)
    elif has_half_pair(name):  # what the system has of bytes that are no text
        report.fault((), "the file's name is no text in UTF-8, and the case is named after it; rename it", place)
    return _case_of(root, report, overrides, FilePath(path))


def read_case(text: str, source: str, name: str, overrides: Sequence[str] = ()) -> Case:
    """Return the checked case of a YAML text, in SI units; `source` stands for its file in faults.

    Raises CaseError with every fault found.
    """
    report = Report(source)
    return _case_of(parse(text, report, Place(source, 1)), report, overrides, FilePath(f"{name}.yaml"))


def _case_of(root: Node | None, report: Report, overrides: Sequence[str], path: FilePath) -> Case:
    """The checked case of a node tree. Raises CaseError with every fault found."""
    if isinstance(root, Table) and {"base", "parameters"} <= root.entries.keys():
        kind = "fit" if "measured" in root.entries else "sweep"
        report.fault((), f"this is a {kind} file, not a case: `crackgrow {kind} {report.source}` runs it", root.place)
        raise report.error()
    folders: dict[str, FilePath] = {}
    case = with_base(root, path, report, folders)
    if case is None:
        raise report.error()
    for override in overrides:
        apply_override(case, override, report)
    context = Context(report, Units(), path.parent, folders)
    resolved: Any = CASE.read(case, (), context)
    if not report.sound("units"):  # the rest was read in other units
        raise report.error()
    read_drawings(resolved, context)
    for definitions in DEFINITIONS:  # each is written out where it is referred to
        resolved.pop(definitions, None)
    scene = scene_of(resolved, report, context.units)
    for stage in STAGES:
        for key, message in stage(scene) or ():
            report.fault(key, message)
    if report.faults:
        raise report.error()
    return _built(path.stem, scene)


def _built(name: str, scene: Scene) -> model.Case:
    """The frozen case of a scene that has no faults: its resolved mapping is all SI and checked."""
    resolved = scene.resolved
    output, points = resolved["output"], resolved["output"].get("points", {}).items()
    return FORMAT.made(
        model.Case,
        resolved,
        name=name,
        bodies=tuple(_body(scene.bodies[key], body) for key, body in resolved["bodies"].items()),
        cracks=tuple(_crack(scene, key, crack) for key, crack in resolved["cracks"].items()),
        interfaces=tuple(part for its in resolved["interfaces"] for part in _interface(scene, its)),
        supports=tuple(_item(scene, "Support", ("supports", k), its) for k, its in enumerate(resolved["supports"])),
        loads=tuple(_item(scene, "Load", ("loads", k), its) for k, its in enumerate(resolved["loads"])),
        loading=_loading(resolved),
        output=FORMAT.made(
            model.Output,
            {**output, "fields": list(dict.fromkeys(output["fields"]))},
            points=tuple(_item(scene, "HistoryPoint", ("output", "points", key), its, name=key) for key, its in points),
        ),
        origin=scene.units.origin or (0.0, 0.0),
        moved=tuple(move for move in scene.moves if move.distance > scene.tolerance),
        cut=tuple(scene.cuts),
    )


def _body(shape: BodyShape, body: Resolved) -> model.Body:
    rings = tuple(Ring(ring.points, ring.edge_names) for ring in shape.rings)
    return FORMAT.made(model.Body, body, name=shape.name, rings=rings)


def _crack(scene: Scene, name: str, crack: Resolved) -> model.Crack:
    tips, points = scene.tips_of(name), scene.cracks[name]
    return FORMAT.made(
        model.Crack,
        crack,
        name=name,
        points=points,
        tip_at_start="start" in tips,
        tip_at_end="end" in tips,
        body=scene.hosts[name],
        left_out=len(crack["path"].get("points", points)) - len(points),
    )


def _interface(scene: Scene, interface: Resolved) -> Iterator[model.Interface]:
    """An interface; of one that is cracked, or may be, this part, then what is bonded."""
    first, second = (scene.bodies[name] for name in interface["between"])
    lines = shared_lines(first, second)
    if "cracked" not in interface and "toughness" not in interface:
        yield FORMAT.made(model.Interface, interface, lines=lines)
        return
    crack, left = None, lines
    if "cracked" in interface:
        lines = opened(lines, interface["cracked"])
        crack, left = parted(lines, interface["cracked"], scene.reach) or (None, lines)
    yield FORMAT.made(model.Interface, interface, lines=() if crack is None else (crack,), boundary=lines)
    bond = {**interface, "contact": "bonded"}
    yield FORMAT.made(model.Interface, bond, lines=left, beside_crack=True, boundary=lines)


def _item(scene: Scene, kind: str, key: Path, item: Resolved, **others: Any) -> Any:
    """A support, a load or a history point: an instance of the class that its form stands for."""
    forms = {form: FORMAT.part(form) for form in FORMAT.declared[kind]}
    its = next(form for form, spec in forms.items() if spec.required() <= item.keys() <= spec.fields.keys())
    if (*key, "on") in scene.regions:
        others["region"] = scene.regions[*key, "on"]
    if "crack" in item or "interface" in item:
        others["surface"] = (
            crack_name(item["crack"]) if "crack" in item else SurfaceName("interface", tuple(item["interface"]))
        )
    if "at" in item:
        at = (*key, "at")
        others["point"] = scene.places[at] if at in scene.places else frozen(item["at"])
        others |= {"body": scene.holders[at]} if at in scene.holders else {}
    if "between" in item:
        ends = [(*key, "between", end) for end in range(2)]
        others |= {
            "bodies": tuple(scene.holders[end] for end in ends),
            "points": frozen([scene.places[end] for end in ends]),
        }
    return FORMAT.made(getattr(model, its.split()[0]), item, **others)


def _loading(resolved: Resolved) -> model.Loading:
    loading = resolved["loading"]
    if isinstance(loading, str):
        return model.StrengthReduction() if loading == REDUCTION else model.CriticalLoad()
    if "stages" in loading:
        return _stages(loading["stages"], resolved["loads"])
    return FORMAT.made(model.LoadHistory, loading)


def _stages(given: list[Resolved], loads: list[Resolved]) -> model.Stages:
    """Every stage with all that holds at its end: what it does not say is as before; what is taken out is released."""
    named = {name for stage in given for name in stage.get("loads", {})}
    own = {load["name"]: float(load["held"]) for load in loads if load.get("name") in named}
    before = stage = model.Stage("", 0.0, tuple(own.items()), ())
    stages: list[model.Stage] = []
    for number, item in enumerate(given):
        own.update(item.get("loads", {}))
        release = item.get("release", float("excavate" in item))
        gone = dict(stage.excavated) | dict.fromkeys(item.get("excavate", []), 0.0)
        excavated = tuple((body, max(share, release)) for body, share in gone.items())
        factor = item.get("factor", stage.factor if number else 1.0)
        stage = model.Stage(item.get("name", f"stage {number}"), factor, tuple(own.items()), excavated)
        stages.append(stage)
    return model.Stages(before, tuple(stages), given={"stages": given})
