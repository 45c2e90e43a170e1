"""The automatic spacing of a scene: from the lengths that a lattice must resolve, by the preset."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from crackgrow.case.accuracy import AUTO, REFINED_AT, automatic_spacing
from crackgrow.case.features import Length, line_length, rim_lengths, stretches
from crackgrow.case.layout import Scene, named, points_of

SPACED_BY: Final = ("bodies", "cracks", "growth", "supports", "loads")  # what an automatic spacing follows from


def settle_spacing(scene: Scene) -> None:
    """Give an automatic spacing its number and its rule; a rule of an earlier case stays where it still holds.

    Cells are refined as accuracy asks where the spacing is automatic or a target is a number, else by hand.
    """
    given = scene.get("numerics", "spacing")
    accuracy = scene.get("numerics", "accuracy")
    if given is None:
        return
    if not (accuracy and scene.bodies and all(scene.report.sound(key) for key in SPACED_BY)):
        if given == AUTO:
            scene.report.doubt(("numerics", "spacing"))  # the faults of what it depends on are reported
        return
    numerics = scene.resolved["numerics"]
    spacing, rule, refine = given, "", numerics["refine"] if isinstance(numerics["refine"], dict) else {}
    if given == AUTO or "auto_rule" in numerics:
        refined = [kind for key in REFINED_AT if refine.get(key, AUTO) == AUTO for kind in REFINED_AT[key]]
        spacing, rule = automatic_spacing(accuracy, _lengths(scene), refined)
    followed = given == AUTO or (numerics.get("auto_rule") == rule and given == spacing)
    rest = {key: value for key, value in numerics.items() if key not in ("accuracy", "spacing", "auto_rule")}
    first = {"accuracy": accuracy, "spacing": spacing if followed else given}
    levels = dict.fromkeys(REFINED_AT, AUTO if followed or not isinstance(accuracy, str) else 0)
    rest["refine"] = {**levels, **refine}
    scene.resolved["numerics"] = {**first, **({"auto_rule": rule} if followed else {}), **rest}


def _lengths(scene: Scene) -> Iterator[Length]:
    """Every length of the scene that the lattice must resolve."""
    for name, crack in named(scene.resolved, "cracks").items():
        points = points_of(crack["path"])
        if line_length(points) > 0.0:
            yield Length("tip", line_length(points), f"length of crack '{name}'")
            kinks, parts = stretches(points)
            if len(kinks):
                yield Length("stretch", float(parts.min()), f"shortest part between kinks of crack '{name}'")
    for body in scene.bodies.values():
        yield Length("width", float(body.extent.min()), f"smaller side of body '{body.name}'")
    rims = {name: [ring.points for ring in body.rings] for name, body in scene.bodies.items()}
    supported = [region for key, region in scene.regions.items() if key[0] == "supports"]
    loaded = [region for key, region in scene.regions.items() if key[0] == "loads"]
    yield from rim_lengths(rims, scene.shared.items(), supported, loaded, scene.units.origin or (0.0, 0.0))
    increment = scene.get("growth", "increment")
    if increment is not None:
        yield Length("increment", increment, "growth.increment")
    for body_name, key, radius in scene.averaging_radii():
        by = key[-1].replace("_", " ")
        what = ".".join(key) if body_name is None else f"averaging radius by the {by} of body '{body_name}'"
        yield Length("radius", radius, what)
