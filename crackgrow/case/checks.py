"""Whether bodies, materials, interfaces, laws of contact and numerical settings of a case fit together."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely

from crackgrow.case.check_regions import knows
from crackgrow.case.format import FORMAT
from crackgrow.case.layout import SMALLEST, Scene, named
from crackgrow.case.model import STEEPEST, CoulombContact
from crackgrow.case.report import Faults, Path, quoted
from crackgrow.case.segments import STRAIGHT, line_length, opened, parted
from crackgrow.case.shapes import Resolved
from crackgrow.vectors import cross

MAX_NODES = 4_000_000  # lattice nodes; beyond, the memory of no workstation suffices
MIN_SPACINGS_ACROSS = 2  # of the smaller side of a body
LARGEST_POISSON = 0.4999  # in plane strain; beyond, K of cracks is off by tens of per cent
FARTHEST = 100.0  # factor between moduli of rock with bedding; beyond, fields on a circle are not resolved
STIFFEST_GAUSS = 1e5  # numerics.contact.stiffness of gauss points; beyond, their tractions are nothing but waves


def check_material(scene: Scene) -> Faults:
    """There is a body; Poisson's ratio near 1/2 is not for plane strain; gravity needs a density."""
    sound = scene.report.sound
    if not named(scene.resolved, "bodies") and sound("bodies"):
        yield ("bodies",), "no body given; a case needs one"
    for name in named(scene.resolved, "bodies"):
        poisson = scene.get("bodies", name, "material", "poisson")
        if scene.get("plane") == "strain" and poisson is not None and poisson > LARGEST_POISSON:
            wanted = f"wanted in plane strain: > -1 and <= {LARGEST_POISSON} (0.5: incompressible)"
            yield ("bodies", name, "material", "poisson"), f"{poisson:g} given; {wanted}"
        yield from _elastic_bedding(scene, name)
    for index, load in scene.items("loads", "gravity"):
        key = ("bodies", load["body"], "material", "density")
        if load["body"] in named(scene.resolved, "bodies") and sound(*key) and scene.get(*key) is None:
            yield key, f"missing: loads.{index} is gravity, so the body needs a density"


def _elastic_bedding(scene: Scene, name: str) -> Faults:
    """Moduli are alike; every stress stores energy: 1 - nu - 2 nu'^2 E / E' > 0 (Pickering 1970)."""
    key = ("bodies", name, "material")
    bedding, young, poisson = (*key, "bedding"), scene.get(*key, "young"), scene.get(*key, "poisson")
    across, other = scene.get(*bedding, "poisson"), scene.get(*bedding, "young")
    for which in ("young", "shear"):
        modulus = scene.get(*bedding, which)
        if None not in (young, modulus) and not 1.0 / FARTHEST < modulus / young < FARTHEST:
            message = f"is {modulus / young:.3g} times the modulus along the planes"
            yield (*bedding, which), f"{message}; wanted: within a factor of {FARTHEST:g} of it"
    if None in (across, young, poisson, other):
        return
    least = 1.0 - 2.0 * LARGEST_POISSON if scene.get("plane") == "strain" else 0.0
    largest = math.sqrt(max(1.0 - poisson - least, 0.0) * other / (2.0 * young))
    if abs(across) > largest:
        wanted = f"wanted with these moduli: from {-largest:.6g} to {largest:.6g}, for the energy to be positive"
        yield (*bedding, "poisson"), f"{across:g} given; {wanted}"


def check_numerics(scene: Scene) -> Faults:
    """The lattice fits the bodies, the increment fits the lattice, the contact settings fit each other."""
    spacing, increment = scene.get("numerics", "spacing"), scene.get("growth", "increment")
    if spacing is not None and scene.bodies:
        yield from _spacing(scene, spacing)
    if spacing is not None and increment is not None and increment < SMALLEST * spacing:
        yield ("growth", "increment"), f"{scene.length(increment)} is less than {smallest(scene, spacing)}"
    stiffness = scene.get("numerics", "contact", "stiffness")
    rigid = stiffness == "rigid" or (isinstance(stiffness, float) and stiffness > STIFFEST_GAUSS)
    if scene.get("numerics", "contact", "discretization") == "gauss" and rigid:
        why = "has more contact points than the displacement can follow, so no unique traction"
        message = f"gauss with contact that is rigid, or stiffer than {STIFFEST_GAUSS:g}, {why}"
        remedy = "use mortar, or give numerics.contact.stiffness a number such as 10"
        yield ("numerics", "contact", "discretization"), f"{message}; {remedy}"


def smallest(scene: Scene, spacing: float) -> str:
    """The least length of cracks and increments, in words."""
    return f"{SMALLEST:g} of the lattice spacing, {scene.length(SMALLEST * spacing)}"


def _spacing(scene: Scene, spacing: float) -> Faults:
    """The smallest body is some spacings across, and the lattice of the whole scene fits into memory."""
    key = ("numerics", "spacing")
    body = min(scene.bodies.values(), key=lambda body: float(body.extent.min()))
    coarsest = float(body.extent.min()) / MIN_SPACINGS_ACROSS
    if spacing > coarsest:
        limit = f"half the smaller side of body '{body.name}', {scene.length(coarsest)}"
        yield key, f"{scene.length(spacing)} is too coarse; at most {limit}"
        return
    margin = 2 * (scene.get("numerics", "support") or 0.0) + 1
    width, height = (scene.box[1] - scene.box[0]).tolist()
    n_nodes = (width / spacing + margin) * (height / spacing + margin)
    if n_nodes > MAX_NODES:
        a, b, c = MAX_NODES - margin**2, -margin * (width + height), -width * height  # a h^2 + b h + c = 0
        finest = (-b + math.sqrt(b**2 - 4 * a * c)) / (2 * a)
        digit = 10.0 ** (math.floor(math.log10(finest)) - 1)  # two digits of it, rounded up
        rule, least = scene.get("numerics", "auto_rule"), scene.length(math.ceil(finest / digit) * digit)
        given = scene.length(spacing) + (f" (auto: {rule})" if rule else "")
        remedy = (
            f"give a spacing by hand, of {least} or more, or a smaller body" if rule else f"wanted: {least} or more"
        )
        yield key, f"{given} gives about {n_nodes:.2g} lattice nodes; at most {MAX_NODES:g} are allowed; {remedy}"


def check_contacts(scene: Scene) -> Faults:
    """Report what is no law: friction that rises, steep dilation, tensile strength beyond what shear allows."""
    loading = scene.resolved["loading"]
    for key, law in contact_laws(scene):
        friction, residual, dilation = law.friction, law.residual_friction, law.dilation_angle
        if residual > friction:
            message = f"{residual:g} given; wanted: at most the friction, {friction:g}: slip wears faces, it cannot"
            yield (*key, "residual_friction"), f"{message} make them rougher"
        elif _slope(dilation) > residual and law.wear is None and law.residual_dilation_angle is None:
            steepest = math.degrees(math.atan(residual))
            limit = f"at most {steepest:.4g} deg, whose tangent is the residual friction, {residual:g}"
            why = "faces that rise more steeply than friction holds them back would create energy when they slip"
            yield (*key, "dilation_angle"), f"{dilation:g} deg given; wanted: {limit}: {why}"
        for bent, given in (("barton", law.barton), ("max_closure", law.max_closure)):
            if given is not None and isinstance(loading, str):
                message = f"depends on the pressure, which loading: {loading} does not follow; wanted: a"
                yield (*key, bent), f"{message} loading.history"
        if law.max_closure is not None and law.stiffness is None:
            yield (*key, "max_closure"), "is of a joint; wanted besides: its stiffness {normal, shear}"
        steepest = friction if law.barton is None else max(friction, _slope(STEEPEST))
        if law.tension * steepest > law.cohesion:
            apex = f"cohesion / friction = {scene.units.show(law.cohesion / steepest, 'stress')}"
            yield (*key, "tension"), f"above the apex of the shear strength, {apex}; wanted: at most that"
        if residual <= friction:
            yield from _wear(key, law)


def _slope(angle: float) -> float:
    """The tangent of an angle in degrees."""
    return math.tan(math.radians(angle))


def _wear(key: Path, law: CoulombContact) -> Faults:
    """What wears has one length, is told once, weakens, and dilates by less than friction holds back."""
    friction, residual = law.friction, law.residual_friction
    angle, last = law.dilation_angle, law.residual_dilation_angle
    ways = [way for way in ("weakening_length", "decay_length", "wear") if getattr(law, way)]
    if len(ways) > 1:
        yield (*key, ways[1]), f"is given beside {ways[0]}; wanted: one of them: each says how strength wears"
    elif law.wear is not None:
        told = {"residual_friction": residual != friction, "residual_dilation_angle": last is not None}
        angles = law.wear.dilation_angle or [angle] * len(law.wear.slip)
        if any(told.values()):
            message = f"is the last one of {'.'.join(map(str, key))}.wear; wanted: one of them"
            yield (*key, max(told, key=lambda name: told[name])), message
        elif message := _wrong_course([0.0, *law.wear.slip], [friction, *law.wear.friction], [angle, *angles]):
            yield (*key, "wear"), message
    else:
        keeps = law.tension == 0.0 and (law.cohesion == 0.0 or law.cohesion_kept)
        if ways and residual == friction and keeps and last is None:
            message = "nothing weakens: give a residual_friction below the friction, or a cohesion that slip takes"
            yield (*key, ways[0]), message
        if last is not None and not ways:
            message = "dilation wears over a length of slip; wanted besides: weakening_length or decay_length"
            yield (*key, "residual_dilation_angle"), message
        elif last is not None and (message := _wrong_course([0.0, 1.0], [friction, residual], [angle, last])):
            yield (*key, "residual_dilation_angle"), message


def _wrong_course(slips: list[float], frictions: list[float], angles: list[float]) -> str:
    """What is wrong with frictions and dilation angles (degrees) at slips (m), in words; empty if nothing is."""
    if not len(slips) == len(frictions) == len(angles) > 1:
        counts = f"{len(slips) - 1} slips, {len(frictions) - 1} frictions and {len(angles) - 1} angles given"
        return f"{counts}; wanted: one or more slips, and as many of each"
    if any(after <= before for before, after in pairwise(slips)):
        return "slips do not rise; wanted: each above the one before it, and the first above 0"
    if any(after > before for values in (frictions, angles) for before, after in pairwise(values)):
        return "friction or dilation angle rises; wanted: each at most the one before it: slip wears faces"
    if any(_slope(angle) > friction for angle, friction in zip(angles, frictions, strict=True)):
        steep = "faces rise more steeply than friction holds them back, and would create energy when they slip"
        return f"{steep}; wanted: tan(dilation angle) at most the friction at each slip"
    return ""


def contact_laws(scene: Scene) -> Iterator[tuple[Path, CoulombContact]]:
    """Yield every law that is given and sound, with its key; that of a set of cracks once."""
    laws = {name: scene.get("cracks", name, "contact") for name in named(scene.resolved, "cracks")}
    for name, law in {id(law): (name, law) for name, law in reversed(laws.items())}.values():
        if isinstance(law, dict):
            yield ("cracks", name, "contact"), FORMAT.made(CoulombContact, law)
    for kind in ("interfaces", "supports"):
        for index, item in scene.items(kind, "contact"):
            if isinstance(item["contact"], dict):
                yield (kind, index, "contact"), FORMAT.made(CoulombContact, item["contact"])


def check_interfaces(scene: Scene) -> Faults:
    """Report shared boundaries without an interface, and interfaces without a shared boundary."""
    seen: dict[frozenset[str], int] = {}
    listing, clear = scene.resolved.get("interfaces"), 0
    for index, interface in scene.listed("interfaces"):
        key = ("interfaces", index, "between")
        if scene.report.sound(*key):
            pair = interface["between"]
            known = [knows(scene, (*key, k), "body", name) for k, name in enumerate(pair)]
            if all(known):
                clear += 1
                yield from _pair(scene, key, pair, seen)
                seen.setdefault(frozenset(pair), index)
                sound = scene.report.sound("interfaces", index) and scene.lines_between(*pair)
                if sound and "cracked" in interface and (fault := _fault_of_crack(scene, interface)):
                    yield ("interfaces", index, "cracked"), fault
                tough, law = sound and "toughness" in interface, scene.get("growth", "law")
                if tough and interface["contact"] == "bonded":
                    why = "so that this has no law; give it a law of contact"
                    yield ("interfaces", index, "toughness"), f"lets a bond part, and the interface is bonded, {why}"
                elif tough and law not in (None, "critical"):
                    why = f"not at a rate; wanted with growth.law: {law}: leave it out"
                    yield ("interfaces", index, "toughness"), f"lets a tip grow at G = G_c, {why}"
    if isinstance(listing, list) and clear == len(listing):  # else the missing one may be that which cannot be read
        for first, second in scene.shared:
            if frozenset((first, second)) not in seen:
                line = f"- {{between: [{first}, {second}], contact: {{friction: 0.5, cohesion: 0}}}}"
                message = f"bodies '{first}' and '{second}' share a boundary; say what holds there, such as {line}"
                yield ("interfaces",), f"{message}, or with contact: bonded"


def _pair(scene: Scene, key: Path, pair: list[str], seen: dict[frozenset[str], int]) -> Faults:
    """Report a body that meets itself, a pair given before, and a pair without a shared boundary."""
    first, second = pair
    if first == second:
        yield key, f"{quoted(first)} is given twice; wanted: two bodies"
    elif frozenset(pair) in seen:
        yield key, f"'{first}' and '{second}' have an interface already, interfaces.{seen[frozenset(pair)]}"
    elif not scene.lines_between(first, second) and all(scene.report.sound("bodies", name, "shape") for name in pair):
        gap = scene.bodies[first].polygon.distance(scene.bodies[second].polygon)
        apart = f"they are {scene.length(gap)} apart" if gap > scene.tolerance else "they touch at points only"
        yield key, f"'{first}' and '{second}' share no boundary: {apart}"


def _fault_of_crack(scene: Scene, interface: Resolved) -> str:
    """What is wrong with the cracked part of an interface, in words; empty where nothing is."""
    if interface["contact"] == "bonded":
        return "the interface is bonded, so that its cracked part has no law; give it a law of contact"
    ends, reach = interface["cracked"], scene.reach
    lines = opened(scene.lines_between(*interface["between"]), ends)
    whole = shapely.MultiLineString(list(lines))
    for end in ends:
        line = shapely.shortest_line(whole, shapely.Point(end))
        apart = float(shapely.length(line))
        if apart > reach:
            where = f"{scene.exact_point(np.array(end))} is {scene.units.show(apart, 'length', 3)} from the interface"
            return f"{where}; the nearest point of it is {scene.exact_point(shapely.get_coordinates(line)[0])}"
    found = parted(lines, ends, reach)
    if found is None:
        return "its ends lie on different lines of the interface; wanted: both on one of them"
    crack, left = found
    if line_length(crack) <= max(SMALLEST * (scene.get("numerics", "spacing") or 0.0), reach):
        return f"the cracked part has a length of {scene.length(line_length(crack))}; wanted: two places apart"
    if not left:
        return "the cracked part is the whole interface; leave `cracked` out"
    for line in left:
        for before, behind in ((crack, line), (line, crack)):
            if np.hypot(*(before[-1] - behind[0])) <= scene.tolerance:
                step, next_step = before[-1] - before[-2], behind[1] - behind[0]
                if abs(np.arctan2(cross(step, next_step), step @ next_step)) > STRAIGHT:
                    where = scene.units.place(behind[0])
                    return f"an end of the cracked part {where} lies on a corner of the interface; wanted: beside it"
    return ""
