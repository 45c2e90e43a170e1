"""Whether the load history, or its stages, fit loads, supports, bodies and growth."""

from __future__ import annotations

from crackgrow.case.accuracy import target_of
from crackgrow.case.check_regions import knows
from crackgrow.case.checks import contact_laws
from crackgrow.case.layout import Scene, named
from crackgrow.case.report import Faults, Path, did_you_mean, quoted
from crackgrow.case.shapes import Resolved

KEY = ("loading", "stages")
UNLOAD = ("growth", "unload_between_steps")

LOADS = ("traction", "far_field", "gravity", "pressure", "volume", "stress", "force")
"""The key that holds the size of a load."""


def check_loading(scene: Scene) -> Faults:
    """Report a history without factors, a critical load where nothing tells it or can be scaled, and a lost target."""
    loading = scene.get("loading")
    if loading == "critical":
        yield from _critical(scene)
    elif loading == "strength_reduction":
        yield from _reduction(scene)
    elif loading is not None and "stages" in loading:
        yield from _stages(scene, loading["stages"])
    elif loading is not None and not loading["history"]:
        yield ("loading", "history"), "no factor given; wanted: at least one, such as [1.0], or loading: critical"
    yield from _goal(scene)


def _stages(scene: Scene, stages: list[Resolved]) -> Faults:
    """Report what does not go with stages, and every fault of a single one."""
    if not stages:
        yield KEY, "no stage given; wanted: at least one, such as [{factor: 1}]"
    if scene.get(*UNLOAD) is False:
        message = "false given; wanted with stages: true. Every step goes through all stages from the unloaded state"
        yield UNLOAD, message
    gone: dict[str, float] = {}
    for number, stage in enumerate(stages):
        key: Path = (*KEY, number)
        if not isinstance(stage, dict) or not scene.report.sound(*key):
            continue
        yield from _stage_loads(scene, (*key, "loads"), stage)
        before = dict(gone)
        yield from _excavation(scene, key, stage, gone)
        changes = gone != before or stage.get("loads") or "factor" in stage
        if number and not changes and scene.report.sound(*key):
            yield key, "changes nothing; wanted: factor, loads, excavate or release"


def _stage_loads(scene: Scene, key: Path, stage: Resolved) -> Faults:
    """Report names that no load has, and loads of one name of which some are held."""
    if not isinstance(scene.resolved["loads"], list):
        return  # that they are none is told
    loads = [load for index, load in scene.listed("loads") if scene.report.sound("loads", index, "name")]
    known = list(dict.fromkeys(load["name"] for load in loads if "name" in load))
    for name in stage.get("loads", {}):
        if name not in known:
            hint = f"{', '.join(known) or 'none has a name'}{did_you_mean(name, known)}"
            yield (*key, name), f"no load is called {quoted(name)}; names of loads: {hint}"
        elif len({load.get("held") for load in loads if load.get("name") == name}) > 1:
            message = "some of the loads of this name are held and others not: with which factor do they begin?"
            yield (*key, name), message


def _excavation(scene: Scene, key: Path, stage: Resolved, gone: dict[str, float]) -> Faults:
    """Report bodies that can't be taken out, and shares that release nothing.

    `gone` are the bodies taken out so far, with what is released; those of the stage are added.
    """
    names, whole = stage.get("excavate", []), (*key, "excavate")
    for index, name in enumerate(names):
        at = (*whole, index) if (*whole, index) in scene.report.places else whole  # a body alone is no item of a list
        cracks = [crack for crack, host in scene.hosts.items() if host == name]
        if name in gone:
            yield at, f"body '{name}' is gone already"
        elif key[-1] == 0:
            yield at, "no stage before this one loads the rock: leave the body out of the case, or put a stage before"
        elif knows(scene, at, "body", name) and cracks:
            yield at, f"crack '{cracks[0]}' lies in body '{name}'; rock that is taken out can have no cracks"
        gone[name] = 0.0
    if names and not named(scene.resolved, "bodies").keys() - gone.keys():
        yield whole, "no body is left"
    least = min(gone.values(), default=1.0)
    release = stage.get("release", 1.0 if names else least)
    if "release" in stage and least == 1.0:
        message = "nothing is left to release" if gone else "no rock is gone that could be released"
        yield (*key, "release"), f"{message}; leave it out"
    elif release < least:
        message = f"{release:g} given, and {least:g} is released already; wanted: no less than that"
        yield (*key, "release"), message
    gone.update({name: max(share, release) for name, share in gone.items()})


def _goal(scene: Scene) -> Faults:
    """A target needs what it is the error of."""
    accuracy, goal = scene.get("numerics", "accuracy"), scene.get("numerics", "goal")
    if not accuracy or not all(map(scene.report.sound, ("cracks", "interfaces", "supports"))):
        return
    tips = scene.starts_cracks or any(crack["tips"] != "none" for crack in named(scene.resolved, "cracks").values())
    surfaces = named(scene.resolved, "cracks") or scene.resolved.get("interfaces") or list(contact_laws(scene))
    lacks = {
        "K": "" if tips or isinstance(accuracy, str) else "no crack has a tip, so there is no K",  # it is the default
        "slip": "" if surfaces else "there is no crack, interface or foundation, so nothing slips",
        "reaction": "",
        "load_factor": "" if scene.get("loading") == "critical" else "the load factor is given; it is found with "
        "loading: critical",
    }  # fmt: skip
    if goal and lacks[goal]:
        others = " | ".join(name for name, why in lacks.items() if not why)
        asked = f"{goal} is asked for within {100.0 * target_of(accuracy):.3g} % (numerics.accuracy)"
        yield ("numerics", "goal"), f"{asked}, but {lacks[goal]}; wanted: goal: {others}"


def _reduction(scene: Scene) -> Faults:
    """Strength is reduced of contact, without growth, and there must be some."""
    if "growth" in scene.resolved:
        message = "strength_reduction is of friction and cohesion of contact, under loads that stay; leave out `growth`"
        yield ("loading",), message
    if isinstance(scene.get("numerics", "accuracy"), float):
        message = "no target where strength is reduced until nothing holds, and no K or slip settles; wanted: a name"
        yield ("numerics", "accuracy"), message
    laws = [law for _, law in contact_laws(scene)]
    sound = all(scene.report.sound(key) for key in ("cracks", "interfaces", "supports"))
    if sound and not any(law.friction > 0.0 or law.cohesion > 0.0 for law in laws):
        message = "strength_reduction divides friction and cohesion of contact, and no crack, interface or foundation"
        yield ("loading",), f"{message} has any"


def _critical(scene: Scene) -> Faults:
    """A critical load needs a criterion, a tip that it is judged at, and something that it scales."""
    sound = scene.report.sound
    if "growth" not in scene.resolved:
        message = "critical needs `growth`, whose criterion says which load is critical (steps: 0 finds it and stops)"
        yield ("loading",), message
    elif scene.get(*UNLOAD) is False:
        message = "false given; wanted with loading: critical: true. Every step finds its load factor from the unloaded"
        remedy = "with friction that remembers there is no such state, give loading: {history: [...]} instead"
        yield UNLOAD, f"{message} state; {remedy}"
    tips = [crack["tips"] for crack in named(scene.resolved, "cracks").values()] if sound("cracks") else ["both"]
    starts = scene.starts_cracks or scene.parts_interfaces
    if sound("growth", "initiation") and not starts and set(tips) <= {"none"}:
        yield ("loading",), "critical needs a tip that can grow, where the criterion is judged; `tips` has none"
    if not (sound("loads") and sound("supports")):
        return
    supports, free = scene.resolved["supports"], [its for its in scene.resolved["loads"] if not its.get("held", False)]
    sizes = [next(load[key] for key in LOADS if key in load) for load in free]
    sizes += [[*its.get("displacement", {}).values(), *its.get("moves", [])] for its in supports]
    parts = [part for size in sizes for part in (size if isinstance(size, list) else [size])]
    if not any(part != 0.0 for part in parts):
        message = "critical scales the loads that are not held and the prescribed displacements, and all of them are"
        yield ("loading",), f"{message} held or zero: no load factor changes anything; leave out `held`"
