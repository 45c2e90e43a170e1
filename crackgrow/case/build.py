"""From the resolved mapping, all SI and checked, to the frozen data of the model."""

from __future__ import annotations

from crackgrow.case.formula import CoordinateFormula
from crackgrow.case.layout import Scene
from crackgrow.case.model import (
    Body,
    Case,
    Component,
    ContactNumerics,
    ContactSupport,
    CoulombContact,
    Crack,
    CrackPressure,
    CriticalLoad,
    EdgeSupport,
    EdgeTraction,
    Gravity,
    Growth,
    InSituStress,
    Interface,
    Load,
    LoadHistory,
    Loading,
    Material,
    Numerics,
    Output,
    PointSupport,
    Refinement,
    Ring,
    Strength,
    Support,
)
from crackgrow.case.neighbours import shared_lines
from crackgrow.case.shapes import BodyShape, Resolved, frozen


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
        loading=_loading(resolved["loading"]),
        growth=_growth(resolved["growth"]) if "growth" in resolved else None,
        numerics=_numerics(resolved["numerics"]),
        output=_output(resolved["output"]),
        resolved=resolved,
        moved=tuple(move for move in scene.moves if move.distance > scene.tolerance),
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
    return CoulombContact(
        friction=contact["friction"],
        cohesion=contact["cohesion"],
        residual_friction=contact["residual_friction"],
        cohesion_kept=contact["cohesion_after_slip"] == "kept",
        dilation_angle=contact["dilation_angle"],
    )


def _component(value: float | str | None) -> Component | None:
    return CoordinateFormula(value) if isinstance(value, str) else value


def _load(scene: Scene, index: int, load: Resolved) -> Load:
    held = load["held"]
    if "gravity" in load:
        return Gravity(load["body"], tuple(load["gravity"]), held)
    if "pressure" in load:
        return CrackPressure(load["crack"], load["pressure"], held)
    if "stress" in load:
        return InSituStress(load["body"], tuple(load["stress"]), held)
    return EdgeTraction(scene.regions["loads", index, "on"], tuple(load["traction"]), held)


def _loading(loading: Resolved | str) -> Loading:
    return CriticalLoad() if isinstance(loading, str) else LoadHistory(tuple(loading["history"]))


def _growth(growth: Resolved) -> Growth:
    return Growth(
        steps=growth["steps"],
        increment=growth["increment"],
        advance=growth["advance"],
        criterion=growth["criterion"],
        direction=growth["direction"],
        tip_radius=growth["tip_stress"]["radius"],
        unload_between_steps=growth["unload_between_steps"],
    )


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
        refine=Refinement(**numerics["refine"]),
        tip_functions=numerics["tip_functions"],
        auto_rule=numerics.get("auto_rule"),
    )


def _output(output: Resolved) -> Output:
    return Output(output["frames"], tuple(dict.fromkeys(output["fields"])), output["figures"], output["report"])
