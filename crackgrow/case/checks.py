"""Whether counts, materials and numerical settings of a case fit together. Faults go to the report."""

from __future__ import annotations

import math

import numpy as np

from crackgrow.case.layout import SHORTEST, Scene, named
from crackgrow.case.shapes import BodyShape

MAX_NODES = 4_000_000  # lattice nodes; beyond, the memory of no workstation suffices
MIN_SPACINGS_ACROSS = 2  # of the smaller side of a body
LARGEST_POISSON = 0.4999  # in plane strain; beyond, K of cracks is off by tens of per cent
STIFFEST_GAUSS = 1e5  # numerics.contact.stiffness of gauss points; beyond, their tractions are nothing but waves


def check_counts(scene: Scene) -> None:
    """At least one body; a corrected direction is for the criterion that knows K."""
    report = scene.report
    if not named(scene.resolved, "bodies") and report.sound("bodies"):
        report.fault(("bodies",), "no body given; a case needs one")
    criterion = scene.get("growth", "criterion")
    if scene.get("growth", "direction") == "implicit" and criterion not in (None, "max_hoop_stress"):
        message = f"implicit is for criterion max_hoop_stress, {criterion} given; use explicit"
        report.fault(("growth", "direction"), message)


def check_material(scene: Scene) -> None:
    """Poisson's ratio near 1/2 is not for plane strain; growth needs a strength, gravity a density."""
    report = scene.report
    for name in named(scene.resolved, "bodies"):
        poisson = scene.get("bodies", name, "material", "poisson")
        if scene.get("plane") == "strain" and poisson is not None and poisson > LARGEST_POISSON:
            message = (
                f"{poisson:g} given; wanted in plane strain: > -1 and <= {LARGEST_POISSON:g} (0.5: incompressible)"
            )
            report.fault(("bodies", name, "material", "poisson"), message)
        strength = ("bodies", name, "strength")
        if _has_growing_cracks(scene, name) and report.sound(*strength) and scene.get(*strength) is None:
            message = "missing: cracks can grow in it, so it needs a strength {tension, cohesion, friction_angle}"
            report.fault(strength, message)
        _check_tension(scene, name)
    for index, load in scene.items("loads", "gravity"):
        key = ("bodies", load["body"], "material", "density")
        known = load["body"] in named(scene.resolved, "bodies") and report.sound(*key)
        if known and scene.get(*key) is None:
            report.fault(key, f"missing: loads.{index} is gravity, so the body needs a density")


def _has_growing_cracks(scene: Scene, body: str) -> bool:
    """Whether growth is given and a crack in the body, or one that may lie in it, has a tip that can grow."""
    if "growth" not in scene.resolved:
        return False
    only = len(named(scene.resolved, "bodies")) == 1
    cracks = [name for name in named(scene.resolved, "cracks") if only or scene.hosts.get(name) == body]
    return any(scene.get("cracks", name, "tips") != "none" for name in cracks)


def _check_tension(scene: Scene, name: str) -> None:
    """The tensile strength cuts off the Mohr-Coulomb cone below its apex, c / tan(phi)."""
    strength = scene.get("bodies", name, "strength")
    if strength is None or not scene.report.sound("bodies", name, "strength"):
        return
    slope = np.tan(np.deg2rad(strength["friction_angle"]))
    if strength["tension"] * slope > strength["cohesion"]:
        apex = scene.units.show(strength["cohesion"] / slope, "stress")
        message = f"above the apex of the shear strength, cohesion / tan(friction_angle) = {apex}; wanted: at most that"
        scene.report.fault(("bodies", name, "strength", "tension"), message)


def check_numerics(scene: Scene) -> None:
    """The lattice fits the bodies, the increment fits the lattice, the contact settings fit each other."""
    report = scene.report
    spacing = scene.get("numerics", "spacing")
    if spacing is not None:
        _check_spacing(scene, spacing)
        increment = scene.get("growth", "increment")
        if increment is not None and increment < SHORTEST * spacing:
            limit = f"{SHORTEST:g} of the lattice spacing, {scene.length(SHORTEST * spacing)}"
            report.fault(("growth", "increment"), f"{scene.length(increment)} is less than {limit}")
    radius = scene.get("growth", "tip_stress", "radius")
    if radius is not None and scene.complete and radius > scene.size:
        message = f"{scene.length(radius)} is more than the size of the scene, {scene.length(scene.size)}"
        report.fault(("growth", "tip_stress", "radius"), f"{message}; wanted: a length of the material")
    stiffness = scene.get("numerics", "contact", "stiffness")
    rigid = stiffness == "rigid" or (isinstance(stiffness, float) and stiffness > STIFFEST_GAUSS)
    if scene.get("numerics", "contact", "discretization") == "gauss" and rigid:
        message = (
            f"gauss with contact that is rigid, or stiffer than {STIFFEST_GAUSS:g}, has more contact points than the "
            "displacement can follow, so no unique traction; use mortar, or give numerics.contact.stiffness a number "
            "such as 10"
        )
        report.fault(("numerics", "contact", "discretization"), message)


def _check_spacing(scene: Scene, spacing: float) -> None:
    """The smallest body is some spacings across, and the lattice of the whole scene fits into memory."""
    if not scene.bodies:
        return

    def side(body: BodyShape) -> float:
        return float(body.extent.min())

    key = ("numerics", "spacing")
    smallest = min(scene.bodies.values(), key=side)
    if spacing > side(smallest) / MIN_SPACINGS_ACROSS:
        limit = f"half the smaller side of body '{smallest.name}', {scene.length(side(smallest) / MIN_SPACINGS_ACROSS)}"
        scene.report.fault(key, f"{scene.length(spacing)} is too coarse; at most {limit}")
        return
    margin = 2 * (scene.get("numerics", "support") or 0.0) + 1
    width, height = (scene.box[1] - scene.box[0]).tolist()
    n_nodes = (width / spacing + margin) * (height / spacing + margin)
    if n_nodes > MAX_NODES:
        rule = scene.get("numerics", "auto_rule")
        least = _finest_spacing(width, height, margin)
        given = scene.length(spacing) + (f" (auto: {rule})" if rule else "")
        remedy = f"wanted: {scene.length(least)} or more"
        if rule:
            remedy = f"give a spacing by hand, of {scene.length(least)} or more, or a smaller body"
        message = f"{given} gives about {n_nodes:.2g} lattice nodes; at most {MAX_NODES:g} are allowed; {remedy}"
        scene.report.fault(key, message)


def _finest_spacing(width: float, height: float, margin: float) -> float:
    """The least spacing (m), two digits of it and rounded up, that needs no more than the nodes that are allowed."""
    a, b, c = MAX_NODES - margin**2, -margin * (width + height), -width * height  # a h^2 + b h + c = 0
    least = (-b + math.sqrt(b**2 - 4 * a * c)) / (2 * a)
    digit = 10.0 ** (math.floor(math.log10(least)) - 1)
    return math.ceil(least / digit) * digit
