"""What growth needs of the rock: a strength, an averaging radius, by itself or of a toughness, and places to start."""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.case.format import FORMAT
from crackgrow.case.layout import Scene, named
from crackgrow.case.model import Strength
from crackgrow.case.report import Faults, Path
from crackgrow.case.toughness import BY_K, RAY_CRITERIA

MOST_PLACES = 20_000
"""Places at which the stress is averaged in every step: each takes some hundred points."""

RATE_LAWS = {
    "subcritical": "{velocity: v_max, exponent: n} of v = v_max (K/K_c)^n",
    "fatigue": "{rate: C, at: 1 MPa sqrt(m), exponent: m} of da/dN = C (dK/at)^m",
}
"""Laws by which growth takes time, with the constants that they need."""


def settle_direction(scene: Scene) -> Faults:
    """Fill in a direction that is left out: implicit where K_I and K_II decide all, else explicit."""
    growth = scene.resolved.get("growth")
    if not isinstance(growth, dict):
        return
    if "direction" not in growth:
        tough = bodies_with(scene, toughness=True)
        growth["direction"] = "implicit" if tough and growth.get("criterion") in BY_K else "explicit"
    criterion = scene.get("growth", "criterion")
    if scene.get("growth", "direction") == "implicit" and criterion not in (None, *BY_K):
        yield ("growth", "direction"), f"implicit is for criterion max_hoop_stress, {criterion} given; use explicit"


def check_strength(scene: Scene) -> Faults:
    """Rock in which cracks can grow has a strength; the radius of its criterion is told once, and is a length of it."""
    growth, cracks, given = scene.resolved.get("growth"), named(scene.resolved, "cracks"), strengths(scene)
    bodies = named(scene.resolved, "bodies")
    for body in bodies:
        key = ("bodies", body, "strength")
        inside = [name for name in cracks if len(bodies) == 1 or scene.hosts.get(name) == body]
        grows = growth is not None and any(scene.get("cracks", name, "tips") != "none" for name in inside)
        if body in given:
            yield from _limits(scene, key, given[body])
            yield from _shear_toughness(scene, (*key, "shear_toughness"), given[body])
        elif grows and scene.report.sound(*key):
            yield key, "missing: cracks can grow in it, so it needs a strength {tension, cohesion, friction_angle}"
    if isinstance(growth, dict) and scene.report.sound("growth", "tip_stress"):
        if scene.report.sound("bodies"):
            yield from _told_once(scene)
        yield from _sizes(scene)


def _limits(scene: Scene, key: Path, strength: Strength) -> Faults:
    """The tensile strength cuts off the Mohr-Coulomb cone below its apex, c / tan(phi); bedding differs."""
    slope, bedding = float(np.tan(np.deg2rad(strength.friction_angle))), strength.bedding
    for where, tension in ((key, strength.tension), ((*key, "bedding"), bedding.tension if bedding else None)):
        if tension is not None and tension * slope > strength.cohesion:
            apex = f"cohesion / tan(friction_angle) = {scene.units.show(strength.cohesion / slope, 'stress')}"
            yield (*where, "tension"), f"above the apex of the shear strength, {apex}; wanted: at most that"
    if bedding is None:
        return
    key = (*key, "bedding")
    if bedding.tension is None and bedding.toughness is None:
        yield key, "gives nothing that differs along the planes; give tension, toughness or both"
    if bedding.toughness is not None and strength.toughness is None:
        message = "is that of cracks along the planes; give strength.toughness, that across them, too"
        yield (*key, "toughness"), message
    if bedding.toughness is None and None not in (bedding.tension, strength.toughness):
        message = "is of new cracks in rock with a toughness; give bedding.toughness, which tips go by, too"
        yield (*key, "tension"), message


def _shear_toughness(scene: Scene, key: Path, strength: Strength) -> Faults:
    """A toughness in shear stands for a length by the cohesion, and is for criteria that judge shear on rays."""
    criterion = scene.get("growth", "criterion")
    if strength.shear_toughness is None:
        return
    if strength.cohesion == 0.0:
        yield key, "stands for a length by the cohesion, which is 0; give a cohesion > 0, or leave it out"
    elif criterion in BY_K and scene.report.sound("growth", "initiation") and not scene.starts_cracks:
        why = f"{criterion} lets none unless cracks start in shear; leave it out, or give growth.initiation: ends"
        yield key, f"is of tips that grow in shear, and {why}"
    elif criterion not in (None, *RAY_CRITERIA):
        wanted = " or ".join(sorted(RAY_CRITERIA))
        yield key, f"is for criteria that judge shear on rays from the tip; {criterion} given; wanted: {wanted}"


def strengths(scene: Scene) -> dict[str, Strength]:
    """The strengths that are given and sound, by body."""
    found = {name: scene.get("bodies", name, "strength") for name in named(scene.resolved, "bodies")}
    return {name: FORMAT.made(Strength, given) for name, given in found.items() if isinstance(given, dict)}


def bodies_with(scene: Scene, toughness: bool) -> list[str]:
    """The bodies whose strength has a toughness, or has none: with cracks, or all where cracks may start in any."""
    anywhere = scene.get("growth", "initiation", "at") in ("outlines", "anywhere")
    hosts = set(() if anywhere else scene.hosts.values()) or set(named(scene.resolved, "bodies"))
    given = strengths(scene).items()
    return [name for name, its in given if name in hosts and (its.toughness is not None) == toughness]


def _told_once(scene: Scene) -> Faults:
    """A radius is given where rock has no toughness, and nowhere else."""
    key = ("growth", "tip_stress")
    without, tough = (bodies_with(scene, toughness=known) for known in (False, True))
    if "tip_stress" not in scene.resolved["growth"] and (without or not (tough or scene.parts_interfaces)):
        where = f"bodies.{without[0]}.strength" if without else "the strength of the rock"
        message = "missing: {radius: R}, the averaging radius, a length of the material"
        yield key, f"{message}; or give {where} a toughness, from which it follows"
    elif "tip_stress" in scene.resolved["growth"] and tough and not without:
        message = f"the averaging radius follows from the toughness of body '{tough[0]}'"
        yield key, f"{message}, and cannot be given besides; leave out one of the two"


def _sizes(scene: Scene) -> Faults:
    """A radius that a criterion averages over is no larger than the scene."""
    for name, key, radius in scene.averaging_radii() if scene.complete else ():
        if radius <= scene.size:
            continue
        message = f"{scene.length(radius)} is more than the size of the scene, {scene.length(scene.size)}"
        if name is None:
            yield key, f"{message}; wanted: a length of the material"
        elif key[-1] == "shear_toughness":
            yield key, f"asks for an averaging radius by the cohesion that is too large: {message}"
        else:
            told = f"asks {scene.get('growth', 'criterion')} for an averaging radius by the tension that is too large"
            yield key, f"{told}: {message}; max_hoop_stress needs none"


def check_rate_law(scene: Scene) -> Faults:
    """Growth at a rate has its constants and a toughness, under loads that are given.

    All tips go at once, and none starts.
    """
    law, report = scene.get("growth", "law"), scene.report
    for key, wanted in RATE_LAWS.items():
        given = scene.get("growth", key) is not None
        if given and law not in (None, key):
            yield ("growth", key), f"is for law: {key}; leave it out, or give `law: {key}`"
        if law == key and not given and report.sound("growth", key):
            yield ("growth", key), f"missing: {wanted}, for law: {key}"
    if law not in RATE_LAWS:
        return
    advance, at = scene.get("growth", "advance"), scene.get("growth", "initiation", "at")
    if advance not in (None, "all"):
        message = f"{advance} given; wanted with law: {law}: all, since every tip goes at its own rate"
        yield ("growth", "advance"), message
    if at not in (None, "tips"):
        message = f"{at} given; wanted with law: {law}: tips. Cracks start where the criterion is met, at no time"
        yield ("growth", "initiation", "at"), message
    if scene.get("loading") == "critical":
        message = f"critical holds a tip at K = K_c, where it is unstable; wanted with growth.law: {law}"
        yield ("loading",), f"{message}: a history of loads{', or stages' if law == 'subcritical' else ''}"
    elif law == "fatigue" and report.sound("loading"):
        yield from _cycle(scene)
    without = bodies_with(scene, toughness=False) if report.sound("bodies") else []
    if without:
        needs = "K over K_c" if law == "subcritical" else "K_c, from which on tips are unstable"
        message = f"{law} needs {needs}, and bodies.{without[0]}.strength has no toughness; give it one"
        yield ("growth", "law"), message


def _cycle(scene: Scene) -> Faults:
    """A cycle is between two loads, the larger one last, where tips are judged; dK is of the hoop stress."""
    criterion, history = scene.get("growth", "criterion"), scene.get("loading", "history") or [1.0]
    if scene.get("loading", "stages") is not None or history[0] == history[-1]:
        message = "wanted with growth.law: fatigue: a history whose first and last load differ, such as [0.1, 1]"
        yield ("loading",), message
    elif history[-1] < max(history):
        message = f"ends with {history[-1]:g}; wanted with growth.law: fatigue: the largest load last, such as [0.1, 1]"
        why = "since tips are judged there; where negative factors open cracks turn the sign of the loads"
        yield ("loading", "history"), f"{message}, {why}"
    if scene.get("growth", "unload_between_steps") is False:
        yield ("growth", "unload_between_steps"), "wanted with law: fatigue: true, since every cycle unloads"
    if criterion not in (None, *BY_K):
        message = f"{criterion} given; wanted with law: fatigue: max_hoop_stress, since dK is of the hoop stress"
        yield ("growth", "criterion"), message


def check_initiation(scene: Scene) -> Faults:
    """Cracks link up over less than an increment; they start in rock that has a strength, at not too many places."""
    key = ("growth", "initiation")
    at, spacing = scene.get(*key, "at"), scene.get(*key, "spacing")
    link, increment = scene.get("growth", "link_distance"), scene.get("growth", "increment")
    if isinstance(link, float) and increment is not None and link > increment:
        message = f"{scene.length(link)} is more than the increment, {scene.length(increment)}; wanted: at most that"
        yield ("growth", "link_distance"), message
    if at in ("tips", "ends", "cracks") and isinstance(spacing, float):
        message = f"spacing is of places on outlines and in the rock; wanted with `at: {at}`: auto"
        yield (*key, "spacing"), f"{message}, or `at: outlines | anywhere`"
    if at not in ("outlines", "anywhere"):
        return
    if scene.report.sound("bodies") and not strengths(scene):
        yield (*key, "at"), "no body has a strength, and cracks start only where the rock has one"
    if isinstance(spacing, float) and scene.complete:
        rocks = [body.polygon for body in scene.bodies.values()]
        n = sum(rock.length / spacing for rock in rocks)
        if at == "anywhere":
            n += sum(shapely.Polygon(rock.exterior).area for rock in rocks) / spacing**2
        if n > MOST_PLACES:
            message = f"{scene.length(spacing)} gives about {n:.2g} places; at most {MOST_PLACES} are allowed"
            yield (*key, "spacing"), message
