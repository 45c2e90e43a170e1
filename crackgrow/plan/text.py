"""The plan of a case in words: what is modelled and why, how large it is, what it costs, what to beware of."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Final

import numpy as np

from crackgrow.case import model
from crackgrow.case.accuracy import STANDARD, name_of
from crackgrow.case.dump import changes_of
from crackgrow.case.layout import ON_OUTLINE
from crackgrow.case.model import Case, CoulombContact, Crack
from crackgrow.case.on_map import length_unit
from crackgrow.case.segments import line_length, meeting_places
from crackgrow.case.touching import scene_size
from crackgrow.case.toughness import BY_K, averaging_radius, shear_radius
from crackgrow.case.units import Metres
from crackgrow.plan.cost import Cost, Sizes, estimated_cost, estimated_nodes, sizes_of
from crackgrow.results.gathered import Gathered
from crackgrow.results.units import component_text, counted, stress_text
from crackgrow.run.warning_causes import StepWarning

SHOWN_CRACKS: Final = 20  # more cracks are summed up
SHOWN_FACTORS: Final = 12  # of longer load histories the first ones are named, and the last
SHOWN_SURFACES: Final = 12  # of more the rest is summed up

LOADS: Final[Mapping[type, str]] = {
    model.Gravity: "gravity on {load.body}",
    model.FluidPressure: "pressure {pressure} in {load.surface}",
    model.FluidVolume: "a volume of fluid in {load.surface}",
    model.EdgePressure: "pressure {pressure} on {load.region.body}.{load.region.edge}",
    model.FarField: "far-field stress on the outline of {load.body}",
    model.PointForce: "a force at a point of {load.body}",
    model.InSituStress: "in-situ stress in {load.body}",
}
"""What is said of a load; tractions on edges are counted."""

Shown = Callable[[float], str]
"""A length (m) in the unit that suits the scene."""


def plan_text(case: Case) -> str:
    """Lines of text: the overview of the case, the model of step 0, its cost, warnings. Raises GeometryError."""
    sizes = sizes_of(case)
    cost = estimated_cost(case, sizes)
    takes = f"the whole run takes {cost.words}, within a factor of two for most scenes"
    warnings = [f"warning: {text}" for text in _warnings(sizes, cost)] or ["no warnings"]
    return "\n".join([overview(case), "model of step 0:", *_model(case, sizes), takes, *warnings])


def plan_record(case: Case) -> dict[str, object]:
    """The model of step 0, its cost and the warnings, in what JSON can hold; s, MiB, m. Raises GeometryError."""
    sizes = sizes_of(case)
    cost = estimated_cost(case, sizes)
    counts = asdict(sizes)
    del counts["scene_warnings"]
    return {
        "case": case.name,
        "title": case.title,
        "spacing": case.numerics.spacing,
        "model": counts,
        "cost": asdict(cost),
        "warnings": _warnings(sizes, cost),
        "changes": [text for kind in changes_of(case) for text in kind],
    }


def overview(case: Case) -> str:
    """Lines of text: bodies, interfaces, cracks and tips, supports and loads, growth, spacing and estimated size."""
    scale, unit = length_unit(case)

    def show(length: float) -> str:
        return f"{length * scale:g} {unit}"

    n_tips = sum(crack.tip_at_start + crack.tip_at_end for crack in case.cracks)
    n_meetings = len(meeting_places([crack.points for crack in case.cracks], ON_OUTLINE * scene_size(case)))
    contact, nodes = case.numerics.contact, estimated_nodes(case)
    stiffness = "rigid" if contact.stiffness is None else f"stiffness {contact.stiffness:g} E/h"
    lines = [
        f"{case.name}: {case.title}",
        f"plane {case.plane}",
        *(_body_line(body, scale, show) for body in case.bodies),
        *(_interface_line(interface, show) for interface in case.interfaces if interface.lines),
        *_crack_lines(case.cracks, scale, show),
        f"cracks: {len(case.cracks)}, tips: {n_tips}"
        + (f", meeting at {counted(n_meetings, 'place')}" if n_meetings else ""),
        *_support_lines(case),
        f"loads: {', '.join(_loads(case))}, {_loading(case)}",
        f"growth: {', '.join(_growth(case, show))}",
        f"lattice: spacing {show(case.numerics.spacing)}{_rule(case)}, "
        f"support {case.numerics.support:g} spacings, about {nodes} nodes, {2 * nodes} dofs before cracks",
        f"contact: {contact.discretization}, {stiffness}, solver {contact.solver}",
    ]
    return "\n".join(lines)


def _body_line(body: model.Body, scale: float, show: Shown) -> str:
    width, height = np.ptp(body.outline, axis=0)
    n_holes, density = len(body.rings) - 1, body.material.density
    words = [
        f"{width * scale:g} x {show(height)}" + (f" with {counted(n_holes, 'hole')}" if n_holes else ""),
        f"E = {stress_text(body.material.young)}",
        f"nu = {body.material.poisson:g}" + ("" if density is None else f", density {density:g} kg/m^3"),
    ]
    if (across := body.material.bedding) is not None:
        shear = "" if across.shear is None else f", G = {stress_text(across.shear)}"
        words.append(
            f"across bedding at {across.angle:g} deg E = {stress_text(across.young)}, nu = {across.poisson:g}{shear}"
        )
    strength = "no strength given" if body.strength is None else (
        f"tension {stress_text(body.strength.tension)}, cohesion {stress_text(body.strength.cohesion)}, "
        f"friction angle {body.strength.friction_angle:g} deg"
    )  # fmt: skip
    if body.strength is not None and body.strength.bedding is not None:
        bedding = body.strength.bedding
        strength += f"; along bedding at {bedding.angle:g} deg"
        strength += f" tension {stress_text(bedding.tension)}" if bedding.tension else ""
        strength += f" toughness {1e-6 * bedding.toughness:g} MPa sqrt(m)" if bedding.toughness else ""
    return f"body {body.name}: {', '.join(words)}; {strength}"


def _interface_line(interface: model.Interface, show: Shown) -> str:
    law = "bonded" if interface.contact == "bonded" else _law(interface.contact)
    length = show(sum(map(line_length, interface.lines)))
    toughness = "" if interface.toughness is None else f", G_c {interface.toughness:g} J/m^2"
    return f"interface between {' and '.join(interface.bodies)}: length {length}; {law}{toughness}"


def _support_lines(case: Case) -> list[str]:
    n_points = sum(isinstance(support, model.PointSupport) for support in case.supports)
    n_edges = sum(isinstance(support, model.EdgeSupport) for support in case.supports)
    foundations = [support for support in case.supports if isinstance(support, model.ContactSupport)]
    return [
        f"supports: {n_points} at points, {n_edges} on edges, {counted(len(foundations), 'rigid foundation')}",
        *(
            f"{'platen that moves' if any(f.moves) else 'foundation'} on edge {f.region.edge} of {f.region.body}: "
            f"{_law(f.contact)}"
            for f in foundations
        ),
    ]


def _loading(case: Case) -> str:
    if isinstance(case.loading, model.CriticalLoad):
        return "each step at its critical load factor"
    if isinstance(case.loading, model.StrengthReduction):
        return "all of them, with friction and cohesion divided by a factor until the scene fails"
    if isinstance(case.loading, model.Stages):
        befores = (case.loading.before, *case.loading.stages)
        return "in stages: " + ", ".join(map(_stage_text, befores, case.loading.stages))
    factors = [f"{factor:g}" for factor in case.loading.factors]
    if len(factors) > SHOWN_FACTORS:
        return f"{len(factors)} load factors {', '.join(factors[:SHOWN_FACTORS])}, ..., {factors[-1]}"
    return f"load factors {', '.join(factors)}"


def _stage_text(before: model.Stage, stage: model.Stage) -> str:
    """What a stage changes."""
    released, factors = dict(before.excavated), dict(before.loads)
    words = [f"without {name}" for name, _ in stage.excavated if name not in released]
    news = [(name, share) for name, share in stage.excavated if share != released.get(name)]
    words += [f"{100.0 * share:g} % of {name} released" for name, share in news]
    words += [f"{name} times {factor:g}" for name, factor in stage.loads if factor != factors.get(name)]
    if stage.factor != before.factor:
        words.append(f"factor {stage.factor:g}")
    return f"{stage.name} ({', '.join(words)})" if words else stage.name


def _loads(case: Case) -> Iterator[str]:
    """Say which loads there are, and which of them every load factor leaves as they are."""
    tractions = [load.held for load in case.loads if isinstance(load, model.EdgeTraction)]
    if tractions or not case.loads:
        held = "held" if all(tractions) else f"{sum(tractions)} held"
        yield f"{counted(len(tractions), 'traction')} on edges" + (f" ({held})" if any(tractions) else "")
    for load in case.loads:
        if type(load) in LOADS:
            words = LOADS[type(load)].format(load=load, pressure=component_text(getattr(load, "pressure", 0.0)))
            yield words + (" (held)" if load.held else "")


def _law(contact: CoulombContact) -> str:
    """Say the law of closed faces: friction and cohesion, and the rest where it is not the default."""
    residual, wear, barton = contact.residual_friction, contact.wear, contact.barton
    table = (
        ("tensile strength {}", stress_text(contact.tension) if contact.tension else None),
        ("residual friction {:g}", residual if residual != contact.friction else None),
        ("cohesion kept after slip", contact.cohesion_kept or None),
        ("dilation angle {:g} deg", contact.dilation_angle or None),
        ("weakening over {:g} of slip", Metres(contact.weakening_length) if contact.weakening_length else None),
        ("decaying over {:g} of slip", Metres(contact.decay_length) if contact.decay_length else None),
        (f"worn to friction {contact.worn[0]:g} by {{:g}} of slip", Metres(wear.slip[-1]) if wear else None),
        ("dilation worn to {:g} deg", contact.worn[1] if contact.worn[1] < contact.dilation_angle else None),
        ("stiffness {0[0]:g} and {0[1]:g} GPa/m", contact.stiffness and [k / 1e9 for k in contact.stiffness]),
        ("closure of at most {:g}", None if contact.max_closure is None else Metres(contact.max_closure)),
        ("JRC {:g}", barton and barton.jrc),
        ("JCS {}", barton and stress_text(barton.jcs)),
    )
    words = [text.format(value) for text, value in table if value is not None]
    return ", ".join([f"friction {contact.friction:g}", f"cohesion {stress_text(contact.cohesion)}", *words])


def _crack_lines(cracks: Sequence[Crack], scale: float, show: Shown) -> Iterator[str]:
    """One line for each of a few cracks; of many, a line for the rest under each law."""
    rest: dict[str, list[float]] = {}
    for number, crack in enumerate(cracks):
        law = "faces never touch" if crack.contact is None else _law(crack.contact)
        length = line_length(crack.points)
        if number < SHOWN_CRACKS:
            tips = [name for name, there in (("start", crack.tip_at_start), ("end", crack.tip_at_end)) if there]
            yield f"crack {crack.name}: length {show(length)}, tips: {' and '.join(tips) or 'none'}; {law}"
        else:
            rest.setdefault(law, []).append(length)
    for law, lengths in rest.items():
        longest = f"length {min(lengths) * scale:g} to {show(max(lengths))}"
        yield f"{counted(len(lengths), 'more crack')}: {longest}; {law}"


def _growth(case: Case, show: Shown) -> Iterator[str]:
    growth = case.growth
    if growth is None:
        n_factors = case.last_step + 1 if isinstance(case.loading, model.LoadHistory | model.Stages) else 1
        yield f"none, {'one static solve' if n_factors == 1 else f'{n_factors} static solves'}"
        return
    if growth.steps == 0:
        yield f"none, {growth.criterion} is judged"
        yield from _radii(case, growth, show)
        return
    law, at = growth.rate_law, growth.initiation.at
    yield f"{counted(growth.steps, 'step')} of {show(growth.increment)}" + (" at most" if law else "")
    if isinstance(law, model.Fatigue):
        yield f"da/dN = {law.rate:g} m (dK/{1e-6 * law.at:g} MPa sqrt(m))^{law.exponent:g}"
    elif law is not None:
        yield f"v = {law.velocity:g} m/s (K/K_c)^{law.exponent:g}"
    yield growth.criterion + ("" if growth.direction == "explicit" else f" ({growth.direction} direction)")
    yield growth.advance.replace("_", " ")
    if at != "tips":
        yield f"new cracks {'anywhere' if at == 'anywhere' else f'at {at}'}"
    yield from _radii(case, growth, show)
    if not growth.unload_between_steps:
        yield "without unloading between steps"


def _radii(case: Case, growth: model.Growth, show: Shown) -> Iterator[str]:
    """The averaging radius that is given, and the toughness of the bodies with cracks, with the radius that follows."""

    def text(radius: float) -> str:
        return f"tip radius {show(radius)} ({radius / case.numerics.spacing:.3g} x the spacing)"

    if growth.tip_radius is not None:
        yield text(growth.tip_radius)
    hosts = {crack.body for crack in case.cracks}
    for body in case.bodies:
        strength = body.strength
        if body.name not in hosts or strength is None:
            continue
        if strength.toughness is not None:
            averages = "" if growth.criterion in BY_K else f" ({text(averaging_radius(growth, strength))})"
            yield f"toughness of '{body.name}' {strength.toughness / 1e6:g} MPa sqrt(m){averages}"
        if strength.shear_toughness is not None:
            radius = shear_radius(growth, strength)
            averages = " (not used: no tip grows in shear)" if radius is None else f" ({text(radius)})"
            yield f"toughness in shear of '{body.name}' {strength.shear_toughness / 1e6:g} MPa sqrt(m){averages}"


def _rule(case: Case) -> str:
    """Say what gave an automatic spacing, or that a preset which asks for another one does not."""
    rule, accuracy, goal = case.numerics.auto_rule, case.numerics.accuracy, case.numerics.goal
    if rule is not None:
        return f" (auto, {name_of(accuracy, goal)}: {rule})"
    return "" if accuracy == STANDARD else f" (given, not that of {name_of(accuracy, goal)})"


def _model(case: Case, sizes: Sizes) -> Iterator[str]:
    gathered = f" (gathered at {sizes.n_gathered})" if sizes.n_gathered else ""
    singular = f"{8 * sizes.n_singular} of tip functions at {counted(sizes.n_tips, 'tip')}{gathered}"
    dofs = [f"{2 * sizes.n_patches} of {sizes.n_patches} physical patches", *([singular] if sizes.n_singular else [])]
    yield f"  {sizes.n_dofs} dofs: {', '.join(dofs)}; {sizes.n_elements} manifold elements"
    yield f"  {counted(sizes.n_multipliers, 'multiplier')} for supports and bonds"
    starts = case.growth is not None and case.growth.initiation.at != "tips"
    if case.numerics.measured and (sizes.n_tips or starts or case.numerics.goal != "K"):
        name = name_of(case.numerics.target, case.numerics.goal)
        yield f"  {name}: cells are refined where that is missed, and coarsened again; these are the first"
    if len(sizes.cells) > 1:
        scale, unit = length_unit(case)
        yield "  cells: " + ", ".join(f"{n} of {side * scale:.3g} {unit}" for side, n in sizes.cells)
    kind = "mortar nodes" if case.numerics.contact.discretization == "mortar" else "Gauss points"
    sides = "normal and tangential" if any(surface.rough for surface in sizes.surfaces) else "normal alone"
    points = f"{counted(sizes.n_tractions, 'traction')} at {sizes.n_contact} {kind}, {sides}"
    yield f"  contact: {points if sizes.n_contact else 'none'}"
    for surface in sizes.surfaces[:SHOWN_SURFACES]:
        law = "with friction or cohesion" if surface.rough else "normal contact alone: neither friction nor cohesion"
        untouched = "bonded: multipliers close gap and slip" if surface.bonded else "no contact: its faces never touch"
        said = f"{counted(surface.n_points, 'point')}, {law}" if surface.touching else untouched
        yield f"    {surface.name}: {said}"
    rest = sizes.surfaces[SHOWN_SURFACES:]
    if rest:
        yield f"    {len(rest)} more: {counted(sum(surface.n_points for surface in rest), 'point')}"


def _warnings(sizes: Sizes, cost: Cost) -> list[str]:
    gathered, memory = Gathered(), cost.warning
    gathered.add(0, [*sizes.scene_warnings, *([StepWarning("MEMORY", memory)] if memory else [])])
    return list(gathered.sentences(with_steps=False))
