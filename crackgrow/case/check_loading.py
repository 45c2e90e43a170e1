"""Whether the load history, or its stages, fit loads, supports, bodies and growth."""

from __future__ import annotations

from crackgrow.case.accuracy import target_of
from crackgrow.case.check_regions import knows_body
from crackgrow.case.checks import contact_laws
from crackgrow.case.layout import Scene, named
from crackgrow.case.report import Path, did_you_mean, quoted
from crackgrow.case.shapes import Resolved

KEY = ("loading", "stages")

LOADS = (
    "traction",
    "far_field",
    "gravity",
    "pressure",
    "volume",
    "stress",
    "force",
)  # the key that holds the size of a load


def check_stages(scene: Scene) -> None:
    """Report what does not go with stages, and every fault of a single one."""
    report, stages = scene.report, scene.resolved["loading"]["stages"]
    if not stages:
        report.fault(KEY, "no stage given; wanted: at least one, such as [{factor: 1}]")
    if scene.get("growth", "unload_between_steps") is False:
        message = "false given; wanted with stages: true. Every step goes through all stages from the unloaded state"
        report.fault(("growth", "unload_between_steps"), message)
    gone: dict[str, float] = {}
    for number, stage in enumerate(stages):
        key: Path = (*KEY, number)
        if isinstance(stage, dict) and report.sound(*key):
            _check_loads(scene, (*key, "loads"), stage)
            changes = _check_excavation(scene, key, stage, gone)
            if number and not changes and not stage.get("loads") and "factor" not in stage:
                report.fault(key, "changes nothing; wanted: factor, loads, excavate or release")


def _check_loads(scene: Scene, key: Path, stage: Resolved) -> None:
    """Report names that no load has, and loads of one name of which some are held."""
    if not isinstance(scene.resolved["loads"], list):
        return  # that they are none is told
    loads = [load for index, load in scene.listed("loads") if scene.report.sound("loads", index, "name")]
    known = list(dict.fromkeys(load["name"] for load in loads if "name" in load))
    for name in stage.get("loads", {}):
        if name not in known:
            hint = f"{', '.join(known) or 'none has a name'}{did_you_mean(name, known)}"
            scene.report.fault((*key, name), f"no load is called {quoted(name)}; names of loads: {hint}")
        elif len({load.get("held") for load in loads if load.get("name") == name}) > 1:
            message = "some of the loads of this name are held and others not: with which factor do they begin?"
            scene.report.fault((*key, name), message)


def _check_excavation(scene: Scene, key: Path, stage: Resolved, gone: dict[str, float]) -> bool:
    """Report bodies that can't be taken out, and shares that release nothing; whether the stage releases anything.

    `gone` are the bodies taken out so far, with what is released; those of the stage are added.
    """
    names, whole = stage.get("excavate", []), (*key, "excavate")
    for index, name in enumerate(names):
        at = (*whole, index) if (*whole, index) in scene.report.places else whole  # a body alone is no item of a list
        cracks = [crack for crack, host in scene.hosts.items() if host == name]
        if name in gone:
            scene.report.fault(at, f"body '{name}' is gone already")
        elif key[-1] == 0:
            message = "no stage before this one loads the rock: leave the body out of the case, or put a stage before"
            scene.report.fault(at, message)
        elif knows_body(scene, at, name) and cracks:
            message = f"crack '{cracks[0]}' lies in body '{name}'; rock that is taken out can have no cracks"
            scene.report.fault(at, message)
        gone[name] = 0.0
    if names and not named(scene.resolved, "bodies").keys() - gone.keys():
        scene.report.fault(whole, "no body is left")
    least = min(gone.values(), default=1.0)
    release = stage.get("release", 1.0 if names else least)
    if "release" in stage and least == 1.0:
        message = "nothing is left to release" if gone else "no rock is gone that could be released"
        scene.report.fault((*key, "release"), f"{message}; leave it out")
    elif release < least:
        message = f"{release:g} given, and {least:g} is released already; wanted: no less than that"
        scene.report.fault((*key, "release"), message)
    changes = bool(names) or release > least or not scene.report.sound(*key)
    for name, share in gone.items():
        gone[name] = max(share, release)
    return changes


def check_loading(scene: Scene) -> None:
    """Report a history without factors, a critical load where nothing tells it or can be scaled, and a lost target."""
    loading = scene.get("loading")
    if loading == "critical":
        _check_critical(scene)
    elif loading == "strength_reduction":
        _check_reduction(scene)
    elif loading is not None and "stages" in loading:
        check_stages(scene)
    elif loading is not None and not loading["history"]:
        message = "no factor given; wanted: at least one, such as [1.0], or loading: critical"
        scene.report.fault(("loading", "history"), message)
    _check_goal(scene)


def _check_goal(scene: Scene) -> None:
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
        scene.report.fault(("numerics", "goal"), f"{asked}, but {lacks[goal]}; wanted: goal: {others}")


def _check_reduction(scene: Scene) -> None:
    """Strength is reduced of contact, without growth, and there must be some."""
    if "growth" in scene.resolved:
        message = "strength_reduction is of friction and cohesion of contact, under loads that stay; leave out `growth`"
        scene.report.fault(("loading",), message)
    if isinstance(scene.get("numerics", "accuracy"), float):
        message = "no target where strength is reduced until nothing holds, and no K or slip settles; wanted: a name"
        scene.report.fault(("numerics", "accuracy"), message)
    laws = [law for _, law in contact_laws(scene)]
    sound = all(scene.report.sound(key) for key in ("cracks", "interfaces", "supports"))
    if sound and not any(law.friction > 0.0 or law.cohesion > 0.0 for law in laws):
        message = "strength_reduction divides friction and cohesion of contact, and no crack, interface or foundation"
        scene.report.fault(("loading",), f"{message} has any")


def _check_critical(scene: Scene) -> None:
    """A critical load needs a criterion, a tip that it is judged at, and something that it scales."""
    report = scene.report
    if "growth" not in scene.resolved:
        message = "critical needs `growth`, whose criterion says which load is critical (steps: 0 finds it and stops)"
        report.fault(("loading",), message)
    elif scene.get("growth", "unload_between_steps") is False:
        message = (
            "false given; wanted with loading: critical: true. Every step finds its load factor from the unloaded "
            "state; with friction that remembers there is no such state, give loading: {history: [...]} instead"
        )
        report.fault(("growth", "unload_between_steps"), message)
    cracks = named(scene.resolved, "cracks")
    sound = report.sound("cracks") and report.sound("growth", "initiation")
    if sound and not scene.starts_cracks and all(crack["tips"] == "none" for crack in cracks.values()):
        report.fault(("loading",), "critical needs a tip that can grow, where the criterion is judged; `tips` has none")
    if report.sound("loads") and report.sound("supports") and not _has_scaled(scene):
        message = "critical scales the loads that are not held and the prescribed displacements, and all of them are"
        report.fault(("loading",), f"{message} held or zero: no load factor changes anything; leave out `held`")


def _has_scaled(scene: Scene) -> bool:
    """Whether there is a load that is neither held nor zero, or a prescribed displacement that is not zero."""
    return any(not load.get("held", False) and _size(load) > 0 for load in scene.resolved["loads"]) or any(
        isinstance(value, str) or value != 0
        for support in scene.resolved["supports"]
        for value in support.get("displacement", {}).values()
    )


def _size(load: Resolved) -> float:
    """Return the largest component of a load, without its sign; a formula counts as if it were one."""
    given = next(load[key] for key in LOADS if key in load)
    parts = given if isinstance(given, list) else [given]
    return max(1.0 if isinstance(part, str) else abs(part) for part in parts)
