"""From the resolved mapping, all SI and checked, to the frozen data of the model."""

from __future__ import annotations

from crackgrow.case import model
from crackgrow.case.declared import made
from crackgrow.case.layout import Scene
from crackgrow.case.neighbours import shared_lines
from crackgrow.case.shapes import BodyShape, Resolved, frozen
from crackgrow.case.surface import SurfaceName, crack_name

REDUCTION = "strength_reduction"


def build_case(name: str, scene: Scene) -> model.Case:
    """Return the case of a scene that has no faults."""
    resolved = scene.resolved
    return made(
        model.Case,
        resolved,
        name=name,
        bodies=tuple(_body(scene.bodies[key], body) for key, body in resolved["bodies"].items()),
        cracks=tuple(_crack(scene, key, crack) for key, crack in resolved["cracks"].items()),
        interfaces=tuple(_interface(scene, interface) for interface in resolved["interfaces"]),
        supports=tuple(_support(scene, index, support) for index, support in enumerate(resolved["supports"])),
        loads=tuple(_load(scene, index, load) for index, load in enumerate(resolved["loads"])),
        loading=_loading(resolved),
        output=_output(scene, resolved["output"]),
        resolved=resolved,
        moved=tuple(move for move in scene.moves if move.distance > scene.tolerance),
        cut=tuple(scene.cuts),
    )


def _body(shape: BodyShape, body: Resolved) -> model.Body:
    rings = tuple(model.Ring(ring.points, ring.edge_names) for ring in shape.rings)
    return made(model.Body, body, name=shape.name, rings=rings)


def _crack(scene: Scene, name: str, crack: Resolved) -> model.Crack:
    tips, points = scene.tips_of(name), scene.cracks[name]
    return made(
        model.Crack,
        crack,
        name=name,
        points=points,
        tip_at_start="start" in tips,
        tip_at_end="end" in tips,
        body=scene.hosts[name],
        left_out=len(crack["path"].get("points", points)) - len(points),
    )


def _interface(scene: Scene, interface: Resolved) -> model.Interface:
    first, second = interface["between"]
    lines = shared_lines(scene.bodies[first], scene.bodies[second], scene.tolerance)
    return made(model.Interface, interface, lines=lines)


def _support(scene: Scene, index: int, support: Resolved) -> model.Support:
    if "at" in support:
        return made(model.PointSupport, support)
    region = scene.regions["supports", index, "on"]
    return (
        made(model.ContactSupport, support, region=region)
        if "contact" in support
        else made(model.EdgeSupport, support, region=region)
    )


def _load(scene: Scene, index: int, load: Resolved) -> model.Load:
    if "traction" in load:
        return made(model.EdgeTraction, load, region=scene.regions["loads", index, "on"])
    if "on" in load:
        return made(model.EdgePressure, load, region=scene.regions["loads", index, "on"])
    if "pressure" in load:
        return made(model.FluidPressure, load, surface=_surface(load))
    if "force" in load:
        key = ("loads", index, "at")
        return made(model.PointForce, load, body=scene.holders[key], point=scene.places[key])
    return made(model.Gravity, load) if "gravity" in load else made(model.InSituStress, load)


def _surface(item: Resolved) -> SurfaceName:
    """The crack or the interface that is named."""
    return crack_name(item["crack"]) if "crack" in item else SurfaceName("interface", tuple(item["interface"]))


def _loading(resolved: Resolved) -> model.Loading:
    loading = resolved["loading"]
    if isinstance(loading, str):
        return model.StrengthReduction() if loading == REDUCTION else model.CriticalLoad()
    if "stages" in loading:
        return _stages(loading["stages"], resolved["loads"])
    return model.LoadHistory(tuple(loading["history"]))


def _stages(given: list[Resolved], loads: list[Resolved]) -> model.Stages:
    """Every stage with all that holds at its end: what it does not say is as before; what is taken out is released."""
    named = {name for stage in given for name in stage.get("loads", {})}
    own = {load["name"]: float(load["held"]) for load in loads if load.get("name") in named}
    before = stage = model.Stage("", 0.0, tuple(own.items()), ())
    stages: list[model.Stage] = []
    for number, item in enumerate(given):
        own.update(item.get("loads", {}))
        excavate, release = item.get("excavate", []), item.get("release", float("excavate" in item))
        gone = dict(stage.excavated) | dict.fromkeys([excavate] if isinstance(excavate, str) else excavate, 0.0)
        excavated = tuple((body, max(share, release)) for body, share in gone.items())
        factor = item.get("factor", stage.factor if number else 1.0)
        stage = model.Stage(item.get("name", f"stage {number}"), factor, tuple(own.items()), excavated)
        stages.append(stage)
    return model.Stages(before, tuple(stages))


def _output(scene: Scene, output: Resolved) -> model.Output:
    points = tuple(_history_point(scene, name, point) for name, point in output.get("points", {}).items())
    return made(model.Output, {**output, "fields": list(dict.fromkeys(output["fields"]))}, points=points)


def _history_point(scene: Scene, name: str, point: Resolved) -> model.HistoryPoint:
    key = ("output", "points", name)
    if "between" in point:
        ends = [(*key, "between", end) for end in range(2)]
        first, second = (scene.holders[end] for end in ends)
        return model.PointPair(name, (first, second), frozen([scene.places[end] for end in ends]))
    place = scene.places[*key, "at"]
    if "crack" in point or "interface" in point:
        return made(model.FacePoint, point, name=name, surface=_surface(point), point=place)
    return made(model.RockPoint, point, name=name, body=scene.holders[*key, "at"], point=place)
