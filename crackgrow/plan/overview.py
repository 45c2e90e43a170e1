"""What a case models and about how large it is, in a few lines: for `crackgrow check`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
import shapely

from crackgrow.case import model
from crackgrow.case.accuracy import STANDARD, name_of
from crackgrow.case.features import line_length
from crackgrow.case.layout import ON_OUTLINE
from crackgrow.case.model import Case, CoulombContact, Crack
from crackgrow.case.segments import meeting_places
from crackgrow.case.touching import scene_size
from crackgrow.case.toughness import BY_K, averaging_radius, shear_radius
from crackgrow.case.units import Metres
from crackgrow.results.places import component_text, length_unit
from crackgrow.results.units import counted, stress_text

SHOWN_CRACKS: Final = 20  # more cracks are summed up
SHOWN_FACTORS: Final = 12  # of longer load histories the first ones are named, and the last


def overview(case: Case) -> str:
    """Lines of text: bodies, interfaces, cracks and tips, supports and loads, growth, spacing and estimated size."""
    scale, unit = length_unit(case)
    n_tips = sum(crack.tip_at_start + crack.tip_at_end for crack in case.cracks)
    contact = case.numerics.contact
    stiffness = "rigid" if contact.stiffness is None else f"stiffness {contact.stiffness:g} E/h"
    nodes = estimated_nodes(case)
    lines = [
        f"{case.name}: {case.title}",
        f"plane {case.plane}",
        *(_body_line(body, scale, unit) for body in case.bodies),
        *(_interface_line(interface, scale, unit) for interface in case.interfaces),
        *_crack_lines(case.cracks, scale, unit),
        f"cracks: {len(case.cracks)}, tips: {n_tips}{_meetings(case)}",
        *_support_lines(case),
        f"loads: {_loads(case)}, {_loading(case)}",
        _growth_line(case, scale, unit),
        f"lattice: spacing {case.numerics.spacing * scale:g} {unit}{_rule(case)}, "
        f"support {case.numerics.support:g} spacings, about {nodes} nodes, {2 * nodes} dofs before cracks",
        f"contact: {contact.discretization}, {stiffness}, solver {contact.solver}",
    ]
    return "\n".join(lines)


def estimated_nodes(case: Case) -> int:
    """About how many lattice nodes have a patch that overlaps a body, counted for each body.

    Nodes within half a patch r of the outline count too: area + perimeter r + 4 r^2 (a convex outline, square
    patches), without those further than r inside of a hole: its area - perimeter r + 4 r^2; over the area h^2 of a
    node.
    """
    h = case.numerics.spacing
    reach = case.numerics.support * h
    total = 0.0
    for body in case.bodies:
        outline, *holes = (shapely.Polygon(ring.points - ring.points[0]) for ring in body.rings)
        total += outline.area + outline.length * reach + 4 * reach**2
        for hole in holes:
            if hole.area > hole.length * reach / 2:  # a square hole wider than a patch
                total -= hole.area - hole.length * reach + 4 * reach**2
    return round(total / h**2)


def _body_line(body: model.Body, scale: float, unit: str) -> str:
    width, height = np.ptp(body.outline, axis=0) * scale
    material = f"E = {stress_text(body.material.young)}, nu = {body.material.poisson:g}"
    if body.material.density is not None:
        material += f", density {body.material.density:g} kg/m^3"
    n_holes = len(body.rings) - 1
    holes = f" with {counted(n_holes, 'hole')}" if n_holes else ""
    strength = "no strength given" if body.strength is None else (
        f"tension {stress_text(body.strength.tension)}, cohesion {stress_text(body.strength.cohesion)}, "
        f"friction angle {body.strength.friction_angle:g} deg"
    )  # fmt: skip
    return f"body {body.name}: {width:g} x {height:g} {unit}{holes}, {material}; {strength}"


def _interface_line(interface: model.Interface, scale: float, unit: str) -> str:
    length = sum(map(line_length, interface.lines)) * scale
    law = "bonded" if interface.contact == "bonded" else _law(interface.contact)
    return f"interface between {' and '.join(interface.bodies)}: length {length:g} {unit}; {law}"


def _support_lines(case: Case) -> list[str]:
    n_points = sum(isinstance(support, model.PointSupport) for support in case.supports)
    n_edges = sum(isinstance(support, model.EdgeSupport) for support in case.supports)
    foundations = [support for support in case.supports if isinstance(support, model.ContactSupport)]
    return [
        f"supports: {n_points} at points, {n_edges} on edges, {counted(len(foundations), 'rigid foundation')}",
        *(f"foundation on edge {f.region.edge} of {f.region.body}: {_law(f.contact)}" for f in foundations),
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


def _loads(case: Case) -> str:
    """Say which loads there are, and which of them every load factor leaves as they are."""
    tractions = [load.held for load in case.loads if isinstance(load, model.EdgeTraction)]
    words = [counted(len(tractions), "traction") + " on edges"] if tractions or not case.loads else []
    if any(tractions):
        words[0] += " (held)" if all(tractions) else f" ({sum(tractions)} held)"
    for load in case.loads:
        held = " (held)" if load.held else ""
        if isinstance(load, model.Gravity):
            words.append(f"gravity on {load.body}{held}")
        elif isinstance(load, model.FluidPressure):
            words.append(f"pressure {component_text(load.pressure)} in {load.surface}{held}")
        elif isinstance(load, model.EdgePressure):
            words.append(f"pressure {component_text(load.pressure)} on {load.region.body}.{load.region.edge}{held}")
        elif isinstance(load, model.FarField):
            words.append(f"far-field stress on the outline of {load.body}{held}")
        elif isinstance(load, model.PointForce):
            words.append(f"a force at a point of {load.body}{held}")
        elif isinstance(load, model.InSituStress):
            words.append(f"in-situ stress in {load.body}{held}")
    return ", ".join(words)


def _law(contact: CoulombContact) -> str:
    """Say the law of closed faces: friction and cohesion, and the rest where it is not the default."""
    words = [f"friction {contact.friction:g}", f"cohesion {stress_text(contact.cohesion)}"]
    if contact.tension:
        words.append(f"tensile strength {stress_text(contact.tension)}")
    if contact.residual_friction != contact.friction:
        words.append(f"residual friction {contact.residual_friction:g}")
    if contact.cohesion_kept:
        words.append("cohesion kept after slip")
    if contact.dilation_angle:
        words.append(f"dilation angle {contact.dilation_angle:g} deg")
    if contact.weakening_length:
        words.append(f"weakening over {Metres(contact.weakening_length):g} of slip")
    if contact.decay_length:
        words.append(f"decaying over {Metres(contact.decay_length):g} of slip")
    if contact.wear is not None:
        words.append(f"worn to friction {contact.worn[0]:g} by {Metres(contact.wear.slip[-1]):g} of slip")
    if contact.worn[1] < contact.dilation_angle:
        words.append(f"dilation worn to {contact.worn[1]:g} deg")
    if contact.stiffness is not None:
        words.append("stiffness {:g} and {:g} GPa/m".format(*(k / 1e9 for k in contact.stiffness)))
    if contact.max_closure is not None:
        words.append(f"closure of at most {Metres(contact.max_closure):g}")
    if contact.barton is not None:
        words.append(f"JRC {contact.barton.jrc:g}, JCS {stress_text(contact.barton.jcs)}")
    return ", ".join(words)


def _crack_lines(cracks: tuple[Crack, ...], scale: float, unit: str) -> list[str]:
    """One line for each of a few cracks; of many, a line for the rest under each law."""
    laws: dict[str, list[float]] = {}
    for crack in cracks[SHOWN_CRACKS:]:
        laws.setdefault(_crack_law(crack), []).append(line_length(crack.points) * scale)
    return [_crack_line(crack, scale, unit) for crack in cracks[:SHOWN_CRACKS]] + [
        f"{counted(len(lengths), 'more crack')}: length {min(lengths):g} to {max(lengths):g} {unit}; {law}"
        for law, lengths in laws.items()
    ]


def _crack_line(crack: Crack, scale: float, unit: str) -> str:
    tips = [name for name, there in (("start", crack.tip_at_start), ("end", crack.tip_at_end)) if there]
    length = f"length {line_length(crack.points) * scale:g} {unit}"
    return f"crack {crack.name}: {length}, tips: {' and '.join(tips) or 'none'}; {_crack_law(crack)}"


def _crack_law(crack: Crack) -> str:
    return "faces never touch" if crack.contact is None else _law(crack.contact)


def _meetings(case: Case) -> str:
    n_places = len(meeting_places([crack.points for crack in case.cracks], ON_OUTLINE * scene_size(case)))
    return f", meeting at {counted(n_places, 'place')}" if n_places else ""


def _growth_line(case: Case, scale: float, unit: str) -> str:
    growth = case.growth
    if growth is None:
        n_factors = case.last_step + 1 if isinstance(case.loading, model.LoadHistory | model.Stages) else 1
        return f"growth: none, {'one static solve' if n_factors == 1 else f'{n_factors} static solves'}"
    direction = "" if growth.direction == "explicit" else f" ({growth.direction} direction)"
    memory = "" if growth.unload_between_steps else ", without unloading between steps"
    radius = "".join(f", {text}" for text in _radii(case, growth, scale, unit))
    if growth.steps == 0:
        return f"growth: none, {growth.criterion} is judged{radius}"
    steps = f"{counted(growth.steps, 'step')} of {growth.increment * scale:g} {unit}"
    law = growth.subcritical
    if law is not None:
        steps += f" at most, v = {law.velocity:g} m/s (K/K_c)^{law.exponent:g}"
    at = growth.initiation.at
    starts = "" if at == "tips" else f", new cracks {'anywhere' if at == 'anywhere' else f'at {at}'}"
    return f"growth: {steps}, {growth.criterion}{direction}, {growth.advance.replace('_', ' ')}{starts}{radius}{memory}"


def _radii(case: Case, growth: model.Growth, scale: float, unit: str) -> Iterator[str]:
    """The averaging radius that is given, and the toughness of the bodies with cracks, with the radius that follows."""

    def text(radius: float) -> str:
        return f"tip radius {radius * scale:.6g} {unit} ({radius / case.numerics.spacing:.3g} x the spacing)"

    if growth.tip_radius is not None:
        yield text(growth.tip_radius)
    hosts = {crack.body for crack in case.cracks}
    for body in case.bodies:
        if body.name in hosts and body.strength is not None and body.strength.toughness is not None:
            averages = "" if growth.criterion in BY_K else f" ({text(averaging_radius(growth, body.strength))})"
            yield f"toughness of '{body.name}' {body.strength.toughness / 1e6:g} MPa sqrt(m){averages}"
        if body.name in hosts and body.strength is not None and body.strength.shear_toughness is not None:
            radius = shear_radius(growth, body.strength)
            averages = " (not used: no tip grows in shear)" if radius is None else f" ({text(radius)})"
            yield f"toughness in shear of '{body.name}' {body.strength.shear_toughness / 1e6:g} MPa sqrt(m){averages}"


def _rule(case: Case) -> str:
    """Say what gave an automatic spacing, or that a preset which asks for another one does not."""
    rule, accuracy, goal = case.numerics.auto_rule, case.numerics.accuracy, case.numerics.goal
    if rule is not None:
        return f" (auto, {name_of(accuracy, goal)}: {rule})"
    return "" if accuracy == STANDARD else f" (given, not that of {name_of(accuracy, goal)})"
