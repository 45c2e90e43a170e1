"""Whether stages name loads and bodies that there are, each change something, and leave rock."""

from __future__ import annotations

from crackgrow.case.check_regions import knows_body
from crackgrow.case.layout import Scene, named
from crackgrow.case.report import Path, did_you_mean, quoted
from crackgrow.case.shapes import Resolved

KEY = ("loading", "stages")


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
        elif len({load["held"] for load in loads if load.get("name") == name}) > 1:
            message = "some of the loads of this name are held and others not: with which factor do they begin?"
            scene.report.fault((*key, name), message)


def _check_excavation(scene: Scene, key: Path, stage: Resolved, gone: dict[str, float]) -> bool:
    """Report bodies that can't be taken out, and shares that release nothing; whether the stage releases anything.

    `gone` are the bodies taken out so far, with what is released; those of the stage are added.
    """
    given = stage.get("excavate", [])
    names = [given] if isinstance(given, str) else given
    for index, name in enumerate(names):
        at = (*key, "excavate") if isinstance(given, str) else (*key, "excavate", index)
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
        scene.report.fault((*key, "excavate"), "no body is left")
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
