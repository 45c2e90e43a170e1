"""Whether cracks can start where the case wants them to."""

from __future__ import annotations

import shapely

from crackgrow.case.layout import Scene, named

MOST_PLACES = 20_000
"""Places at which the stress is averaged in every step: each takes some hundred points."""


def check_initiation(scene: Scene) -> None:
    """Places without a tip are judged by their stress, in rock that has a strength, and are not too many."""
    at = scene.get("growth", "initiation", "at")
    _check_link(scene)
    if at is None:
        return
    key = ("growth", "initiation")
    spacing = scene.get(*key, "spacing")
    if at in ("tips", "ends", "cracks") and isinstance(spacing, float):
        message = "spacing is of places on outlines and in the rock"
        scene.report.fault((*key, "spacing"), f"{message}; wanted with `at: {at}`: auto, or `at: outlines | anywhere`")
    if at == "tips":
        return
    if at in ("ends", "cracks"):
        return
    bodies = named(scene.resolved, "bodies")
    if scene.report.sound("bodies") and not any(scene.get("bodies", name, "strength") for name in bodies):
        scene.report.fault((*key, "at"), "no body has a strength, and cracks start only where the rock has one")
    if isinstance(spacing, float) and scene.complete:
        _check_number(scene, at, spacing)


def _check_number(scene: Scene, at: str, spacing: float) -> None:
    """There are not too many places."""
    rings = [ring.points for body in scene.bodies.values() for ring in body.rings]
    n = sum(shapely.LinearRing(ring).length for ring in rings) / spacing
    if at == "anywhere":
        n += sum(shapely.Polygon(body.outline).area for body in scene.bodies.values()) / spacing**2
    if n > MOST_PLACES:
        message = f"{scene.length(spacing)} gives about {n:.2g} places; at most {MOST_PLACES} are allowed"
        scene.report.fault(("growth", "initiation", "spacing"), message)


def _check_link(scene: Scene) -> None:
    """Cracks link up over less than what a tip advances by."""
    link, increment = scene.get("growth", "link_distance"), scene.get("growth", "increment")
    if isinstance(link, float) and increment is not None and link > increment:
        message = f"{scene.length(link)} is more than the increment, {scene.length(increment)}; wanted: at most that"
        scene.report.fault(("growth", "link_distance"), message)
