"""What a case models and about how large it is, in a few lines: for `crackgrow check`."""

from __future__ import annotations

import numpy as np

from crackgrow.case.model import Body, Case, Crack, EdgeSupport


def overview(case: Case) -> str:
    """Lines of text: bodies, cracks and tips, supports and loads, growth, spacing and estimated size."""
    scale, unit = _length_unit(case)
    n_tips = sum(crack.tip_at_start + crack.tip_at_end for crack in case.cracks)
    n_edges = sum(isinstance(support, EdgeSupport) for support in case.supports)
    contact = case.numerics.contact
    stiffness = "rigid" if contact.stiffness is None else f"stiffness {contact.stiffness:g} E/h"
    nodes = estimated_nodes(case)
    lines = [
        f"{case.name}: {case.title}",
        f"plane {case.plane}",
        *(_body_line(body, scale, unit) for body in case.bodies),
        *(_crack_line(crack, scale, unit) for crack in case.cracks),
        f"cracks: {len(case.cracks)}, tips: {n_tips}",
        f"supports: {len(case.supports) - n_edges} at points, {n_edges} on edges",
        f"loads: {len(case.loads)} tractions on edges, load factors {', '.join(f'{f:g}' for f in case.load_factors)}",
        _growth_line(case, scale, unit),
        f"lattice: spacing {case.numerics.spacing * scale:g} {unit}, support {case.numerics.support:g} spacings, "
        f"about {nodes} nodes, {2 * nodes} dofs before cracks",
        f"contact: {contact.discretization}, {stiffness}, solver {contact.solver}",
    ]
    return "\n".join(lines)


def estimated_nodes(case: Case) -> int:
    """About how many lattice nodes have a patch that overlaps a body.

    Nodes within half a patch r of the outline count too: area + perimeter r + 4 r^2 (a convex outline, square
    patches), over the area h^2 of a node.
    """
    h = case.numerics.spacing
    reach = case.numerics.support * h
    total = 0.0
    for body in case.bodies:
        following = np.roll(body.outline, -1, axis=0)
        (x, y), (x_next, y_next) = body.outline.T, following.T
        area = abs(np.sum(x * y_next - x_next * y)) / 2
        perimeter = np.linalg.norm(following - body.outline, axis=1).sum()
        total += (area + perimeter * reach + 4 * reach**2) / h**2
    return round(total)


def _body_line(body: Body, scale: float, unit: str) -> str:
    width, height = np.ptp(body.outline, axis=0) * scale
    material = f"E = {body.material.young / 1e9:g} GPa, nu = {body.material.poisson:g}"
    strength = "no strength given" if body.strength is None else (
        f"tension {body.strength.tension / 1e6:g} MPa, cohesion {body.strength.cohesion / 1e6:g} MPa, "
        f"friction angle {body.strength.friction_angle:g} deg"
    )  # fmt: skip
    return f"body {body.name}: {width:g} x {height:g} {unit}, {material}; {strength}"


def _crack_line(crack: Crack, scale: float, unit: str) -> str:
    length = np.linalg.norm(np.diff(crack.points, axis=0), axis=1).sum() * scale
    tips = [name for name, there in (("start", crack.tip_at_start), ("end", crack.tip_at_end)) if there]
    contact = "faces never touch" if crack.contact is None else (
        f"friction {crack.contact.friction:g}, cohesion {crack.contact.cohesion / 1e6:g} MPa"
    )  # fmt: skip
    return f"crack {crack.name}: length {length:g} {unit}, tips: {' and '.join(tips) or 'none'}; {contact}"


def _growth_line(case: Case, scale: float, unit: str) -> str:
    growth = case.growth
    if growth is None:
        return "growth: none, one static solve"
    return (
        f"growth: {growth.steps} steps of {growth.increment * scale:g} {unit}, {growth.criterion}, "
        f"{growth.advance.replace('_', ' ')}, tip radius {growth.tip_radius * scale:g} {unit}"
    )


def _length_unit(case: Case) -> tuple[float, str]:
    size = max(float(np.ptp(body.outline, axis=0).max()) for body in case.bodies)
    return (1e3, "mm") if size < 1 else (1.0, "m")
