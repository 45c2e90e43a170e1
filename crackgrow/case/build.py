"""From the resolved mapping, all SI and checked, to the frozen data of the model."""

from __future__ import annotations

from crackgrow.case.formula import component_of
from crackgrow.case.layout import Scene
from crackgrow.case.model import (
    Body,
    Case,
    Component,
    ContactNumerics,
    ContactSupport,
    CoulombContact,
    Crack,
    CriticalLoad,
    EdgeSupport,
    EdgeTraction,
    FacePoint,
    FluidPressure,
    Gravity,
    Growth,
    HistoryPoint,
    Initiation,
    InSituStress,
    Interface,
    Load,
    LoadHistory,
    Loading,
    Material,
    Numerics,
    Output,
    PointForce,
    PointPair,
    PointSupport,
    Refinement,
    Ring,
    RockPoint,
    Stage,
    Stages,
    Strength,
    StrengthReduction,
    Subcritical,
    Support,
)
from crackgrow.case.neighbours import shared_lines
from crackgrow.case.shapes import BodyShape, Resolved, frozen

REDUCTION = "strength_reduction"


def build_case(name: str, scene: Scene) -> Case:
    """Return the case of a scene that has no faults."""
    resolved = scene.resolved
    return Case(
        name=name,
        title=resolved["title"],
        source=resolved["source"],
        plane=resolved["plane"],
        bodies=tuple(_body(scene.bodies[key], body) for key, body in resolved["bodies"].items()),
        cracks=tuple(_crack(scene, key, crack) for key, crack in resolved["cracks"].items()),
        interfaces=tuple(_interface(scene, interface) for interface in resolved["interfaces"]),
        supports=tuple(_support(scene, index, support) for index, support in enumerate(resolved["supports"])),
        loads=tuple(_load(scene, index, load) for index, load in enumerate(resolved["loads"])),
        loading=_loading(resolved),
        growth=_growth(resolved["growth"]) if "growth" in resolved else None,
        numerics=_numerics(resolved["numerics"]),
        output=_output(scene, resolved["output"]),
        resolved=resolved,
        moved=tuple(move for move in scene.moves if move.distance > scene.tolerance),
        cut=tuple(scene.cuts),
    )


def _body(shape: BodyShape, body: Resolved) -> Body:
    rings = tuple(Ring(ring.points, ring.edge_names) for ring in shape.rings)
    strength = Strength(**body["strength"]) if "strength" in body else None
    return Body(shape.name, rings, Material(**body["material"]), strength)


def _crack(scene: Scene, name: str, crack: Resolved) -> Crack:
    tips, contact = scene.tips_of(name), crack["contact"]
    return Crack(
        name=name,
        points=scene.cracks[name],
        tip_at_start="start" in tips,
        tip_at_end="end" in tips,
        contact=None if contact == "none" else _contact(contact),
        body=scene.hosts[name],
        left_out=len(crack["path"].get("points", scene.cracks[name])) - len(scene.cracks[name]),
    )


def _interface(scene: Scene, interface: Resolved) -> Interface:
    first, second = interface["between"]
    contact = interface["contact"]
    return Interface(
        bodies=(first, second),
        lines=shared_lines(scene.bodies[first], scene.bodies[second], scene.tolerance),
        contact="bonded" if contact == "bonded" else _contact(contact),
    )


def _support(scene: Scene, index: int, support: Resolved) -> Support:
    if "contact" in support:
        return ContactSupport(scene.regions["supports", index, "on"], _contact(support["contact"]))
    x, y = (_component(support["displacement"].get(component)) for component in ("x", "y"))
    if "at" in support:
        return PointSupport(support["body"], frozen(support["at"]), (x, y))
    return EdgeSupport(scene.regions["supports", index, "on"], (x, y))


def _contact(contact: Resolved) -> CoulombContact:
    joint = contact.get("stiffness")
    return CoulombContact(
        friction=contact["friction"],
        cohesion=contact["cohesion"],
        residual_friction=contact["residual_friction"],
        cohesion_kept=contact["cohesion_after_slip"] == "kept",
        dilation_angle=contact["dilation_angle"],
        stiffness=(joint["normal"], joint["shear"]) if joint else None,
        weakening_length=contact.get("weakening_length", 0.0),
    )


def _component(value: float | str | None) -> Component | None:
    return None if value is None else component_of(value)


def _load(scene: Scene, index: int, load: Resolved) -> Load:
    held, name = load["held"], load.get("name")
    if "gravity" in load:
        return Gravity(load["body"], tuple(load["gravity"]), held, name)
    if "pressure" in load:
        surface = load["crack"] if "crack" in load else tuple(load["interface"])
        return FluidPressure(surface, component_of(load["pressure"]), held, name)
    if "force" in load:
        key = ("loads", index, "at")
        return PointForce(scene.holders[key], scene.places[key], tuple(load["force"]), held, name)
    if "stress" in load:
        xx, yy, xy = (component_of(component) for component in load["stress"])
        return InSituStress(load["body"], (xx, yy, xy), held, name)
    x, y = (component_of(component) for component in load["traction"])
    return EdgeTraction(scene.regions["loads", index, "on"], (x, y), held, name)


def _loading(resolved: Resolved) -> Loading:
    loading = resolved["loading"]
    if isinstance(loading, str):
        return StrengthReduction() if loading == REDUCTION else CriticalLoad()
    if "stages" in loading:
        return _stages(loading["stages"], resolved["loads"])
    return LoadHistory(tuple(loading["history"]))


def _stages(given: list[Resolved], loads: list[Resolved]) -> Stages:
    """Every stage with all that holds at its end: what it does not say is as before; what is taken out is released."""
    named = {name for stage in given for name in stage.get("loads", {})}
    own = {load["name"]: float(load["held"]) for load in loads if load.get("name") in named}
    before = stage = Stage("", 0.0, tuple(own.items()), ())
    stages: list[Stage] = []
    for number, item in enumerate(given):
        own.update(item.get("loads", {}))
        excavate, release = item.get("excavate", []), item.get("release", float("excavate" in item))
        gone = dict(stage.excavated) | dict.fromkeys([excavate] if isinstance(excavate, str) else excavate, 0.0)
        excavated = tuple((body, max(share, release)) for body, share in gone.items())
        factor = item.get("factor", stage.factor if number else 1.0)
        stage = Stage(item.get("name", f"stage {number}"), factor, tuple(own.items()), excavated)
        stages.append(stage)
    return Stages(before, tuple(stages))


def _growth(growth: Resolved) -> Growth:
    return Growth(
        steps=growth["steps"],
        increment=growth["increment"],
        advance=growth["advance"],
        criterion=growth["criterion"],
        direction=growth["direction"],
        tip_radius=growth["tip_stress"]["radius"] if "tip_stress" in growth else None,
        unload_between_steps=growth["unload_between_steps"],
        initiation=Initiation(growth["initiation"]["at"], _unless_auto(growth["initiation"]["spacing"])),
        link_distance=_unless_auto(growth["link_distance"]),
        subcritical=Subcritical(**growth["subcritical"]) if "subcritical" in growth else None,
    )


def _unless_auto(value: float | str) -> float | None:
    return None if isinstance(value, str) else value


def _numerics(numerics: Resolved) -> Numerics:
    contact = dict(numerics["contact"])
    if contact["stiffness"] == "rigid":
        contact["stiffness"] = None
    return Numerics(
        spacing=numerics["spacing"],
        support=numerics["support"],
        quadrature=numerics["quadrature"],
        contact=ContactNumerics(**contact),
        accuracy=numerics["accuracy"],
        goal=numerics["goal"],
        refine=Refinement(**numerics["refine"]),
        tip_functions=numerics["tip_functions"],
        auto_rule=numerics.get("auto_rule"),
    )


def _output(scene: Scene, output: Resolved) -> Output:
    points = tuple(_history_point(scene, name, point) for name, point in output.get("points", {}).items())
    fields = tuple(dict.fromkeys(output["fields"]))
    return Output(output["frames"], fields, output["figures"], output["report"], points)


def _history_point(scene: Scene, name: str, point: Resolved) -> HistoryPoint:
    key = ("output", "points", name)
    if "between" in point:
        ends = [(*key, "between", end) for end in range(2)]
        first, second = (scene.holders[end] for end in ends)
        return PointPair(name, (first, second), frozen([scene.places[end] for end in ends]))
    place = scene.places[*key, "at"]
    if "crack" in point:
        return FacePoint(name, point["crack"], place)
    if "interface" in point:
        first, second = point["interface"]
        return FacePoint(name, (first, second), place)
    return RockPoint(name, scene.holders[*key, "at"], place)
