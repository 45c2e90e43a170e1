"""Whether bodies, materials, interfaces, laws of contact and numerical settings of a case fit together."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from crackgrow.case.check_regions import knows_body
from crackgrow.case.layout import SMALLEST, Scene, named
from crackgrow.case.model import STEEPEST
from crackgrow.case.report import Path, quoted
from crackgrow.case.shapes import BodyShape, Resolved

MAX_NODES = 4_000_000  # lattice nodes; beyond, the memory of no workstation suffices
MIN_SPACINGS_ACROSS = 2  # of the smaller side of a body
LARGEST_POISSON = 0.4999  # in plane strain; beyond, K of cracks is off by tens of per cent
STIFFEST_GAUSS = 1e5  # numerics.contact.stiffness of gauss points; beyond, their tractions are nothing but waves


def check_counts(scene: Scene) -> None:
    """At least one body."""
    if not named(scene.resolved, "bodies") and scene.report.sound("bodies"):
        scene.report.fault(("bodies",), "no body given; a case needs one")


def check_material(scene: Scene) -> None:
    """Poisson's ratio near 1/2 is not for plane strain; gravity needs a density."""
    report = scene.report
    for name in named(scene.resolved, "bodies"):
        poisson = scene.get("bodies", name, "material", "poisson")
        if scene.get("plane") == "strain" and poisson is not None and poisson > LARGEST_POISSON:
            message = (
                f"{poisson:g} given; wanted in plane strain: > -1 and <= {LARGEST_POISSON:g} (0.5: incompressible)"
            )
            report.fault(("bodies", name, "material", "poisson"), message)
    for index, load in scene.items("loads", "gravity"):
        key = ("bodies", load["body"], "material", "density")
        known = load["body"] in named(scene.resolved, "bodies") and report.sound(*key)
        if known and scene.get(*key) is None:
            report.fault(key, f"missing: loads.{index} is gravity, so the body needs a density")


def check_numerics(scene: Scene) -> None:
    """The lattice fits the bodies, the increment fits the lattice, the contact settings fit each other."""
    report = scene.report
    spacing = scene.get("numerics", "spacing")
    if spacing is not None:
        _check_spacing(scene, spacing)
        increment = scene.get("growth", "increment")
        if increment is not None and increment < SMALLEST * spacing:
            limit = f"{SMALLEST:g} of the lattice spacing, {scene.length(SMALLEST * spacing)}"
            report.fault(("growth", "increment"), f"{scene.length(increment)} is less than {limit}")
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


def check_contacts(scene: Scene) -> None:
    """Report what is no law: friction that rises, steep dilation, tensile strength beyond what shear allows."""
    for key, law in contact_laws(scene):
        friction, residual, dilation = law["friction"], law["residual_friction"], law["dilation_angle"]
        if residual > friction:
            message = f"{residual:g} given; wanted: at most the friction, {friction:g}: slip wears faces, it cannot"
            scene.report.fault((*key, "residual_friction"), f"{message} make them rougher")
        elif math.tan(math.radians(dilation)) > residual and not {"wear", "residual_dilation_angle"} & set(law):
            steepest = math.degrees(math.atan(residual))
            limit = f"at most {steepest:.4g} deg, whose tangent is the residual friction, {residual:g}"
            why = "faces that rise more steeply than friction holds them back would create energy when they slip"
            scene.report.fault((*key, "dilation_angle"), f"{dilation:g} deg given; wanted: {limit}: {why}")
        for bent in {"barton", "max_closure"} & law.keys() if isinstance(scene.resolved["loading"], str) else ():
            message = f"depends on the pressure, which loading: {scene.resolved['loading']} does not follow; wanted: a"
            scene.report.fault((*key, bent), f"{message} loading.history")
        if "max_closure" in law and "stiffness" not in law:
            scene.report.fault((*key, "max_closure"), "is of a joint; wanted besides: its stiffness {normal, shear}")
        steepest = max(friction, math.tan(math.radians(STEEPEST))) if "barton" in law else friction
        if law["tension"] * steepest > law["cohesion"]:
            apex = scene.units.show(law["cohesion"] / steepest, "stress")
            message = f"above the apex of the shear strength, cohesion / friction = {apex}; wanted: at most that"
            scene.report.fault((*key, "tension"), message)
        _check_wear(scene, key, law)
        keeps = law["tension"] == 0.0 and (law["cohesion"] == 0.0 or law["cohesion_after_slip"] == "kept")
        for length in ("weakening_length", "decay_length"):
            if length in law and residual == friction and keeps and "residual_dilation_angle" not in law:
                message = "nothing weakens: give a residual_friction below the friction, or a cohesion that slip takes"
                scene.report.fault((*key, length), message)


def _check_wear(scene: Scene, key: Path, law: Resolved) -> None:
    """What wears has one length, is told once, falls, and dilates by less than friction holds back."""
    ways = [way for way in ("weakening_length", "decay_length", "wear") if way in law]
    if len(ways) > 1:
        scene.report.fault(
            (*key, ways[1]), f"is given beside {ways[0]}; wanted: one of them: each says how strength wears"
        )
        return
    angle, friction = law["dilation_angle"], law["friction"]
    slips, frictions = [0.0, 1.0], [friction, law["residual_friction"]]
    angles, where = [angle, law.get("residual_dilation_angle", angle)], "residual_dilation_angle"
    if "wear" in law:
        where, told = "wear", law["wear"]
        slips, frictions = [0.0, *told["slip"]], [friction, *told["friction"]]
        angles = [angle, *told.get("dilation_angle", [angle] * len(told["slip"]))]
        for other in ("residual_friction", "residual_dilation_angle"):
            if other in law and law[other] != {"residual_friction": friction}.get(other):
                message = f"is the last one of {'.'.join(map(str, key))}.wear; wanted: one of them"
                scene.report.fault((*key, other), message)
                return
    elif where in law and not ways:
        message = "dilation wears over a length of slip; wanted besides: weakening_length or decay_length"
        scene.report.fault((*key, where), message)
    message, rising = "", [angles] if where != "wear" else [frictions, angles]
    if not len(slips) == len(frictions) == len(angles) > 1:
        message = f"{len(slips) - 1} slips, {len(frictions) - 1} frictions and {len(angles) - 1} angles given; wanted: "
        message += "one or more slips, and as many of each"
    elif any(after <= before for before, after in pairwise(slips)):
        message = "slips do not rise; wanted: each above the one before it, and the first above 0"
    elif any(after > before for values in rising for before, after in pairwise(values)):
        message = "friction or dilation angle rises; wanted: each at most the one before it: slip wears faces"
    elif where in law and any(math.tan(math.radians(a)) > mu for a, mu in zip(angles, frictions, strict=True)):
        message = "faces rise more steeply than friction holds them back, and would create energy when they slip; "
        message += "wanted: tan(dilation angle) at most the friction at each slip"
    if message:
        scene.report.fault((*key, where), message)


def contact_laws(scene: Scene) -> Iterator[tuple[Path, Resolved]]:
    """Yield every law that is given and sound, with its key; that of a set of cracks once."""
    laws = {name: scene.get("cracks", name, "contact") for name in named(scene.resolved, "cracks")}
    for name, law in {id(law): (name, law) for name, law in reversed(laws.items())}.values():
        if isinstance(law, dict):
            yield ("cracks", name, "contact"), law
    for kind in ("interfaces", "supports"):
        for index, item in scene.items(kind, "contact"):
            if isinstance(item["contact"], dict):
                yield (kind, index, "contact"), item["contact"]


def check_interfaces(scene: Scene) -> None:
    """Report shared boundaries without an interface, and interfaces without a shared boundary."""
    seen: dict[frozenset[str], int] = {}
    all_clear = True
    listing = scene.resolved.get("interfaces")
    for index, interface in enumerate(listing if isinstance(listing, list) else []):
        key = ("interfaces", index, "between")
        if not isinstance(interface, dict) or not scene.report.sound(*key):
            all_clear = False
            continue
        pair = interface["between"]
        known = [knows_body(scene, (*key, k), name) for k, name in enumerate(pair)]
        if all(known):
            _check_pair(scene, key, pair, seen)
            seen.setdefault(frozenset(pair), index)
        else:
            all_clear = False
    if all_clear and isinstance(listing, list):  # else the missing one may be that which cannot be read
        for first, second in scene.shared:
            if frozenset((first, second)) not in seen:
                line = f"- {{between: [{first}, {second}], contact: {{friction: 0.5, cohesion: 0}}}}"
                message = f"bodies '{first}' and '{second}' share a boundary; say what holds there, such as {line}"
                scene.report.fault(("interfaces",), f"{message}, or with contact: bonded")


def _check_pair(scene: Scene, key: Path, pair: list[str], seen: dict[frozenset[str], int]) -> None:
    """Report a body that meets itself, a pair given before, and a pair without a shared boundary."""
    first, second = pair
    if first == second:
        scene.report.fault(key, f"{quoted(first)} is given twice; wanted: two bodies")
    elif frozenset(pair) in seen:
        number = seen[frozenset(pair)]
        scene.report.fault(key, f"'{first}' and '{second}' have an interface already, interfaces.{number}")
    elif not scene.lines_between(first, second) and all(scene.report.sound("bodies", name, "shape") for name in pair):
        gap = scene.bodies[first].polygon.distance(scene.bodies[second].polygon)
        apart = f"they are {scene.length(gap)} apart" if gap > scene.tolerance else "they touch at points only"
        scene.report.fault(key, f"'{first}' and '{second}' share no boundary: {apart}")
