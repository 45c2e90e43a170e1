"""Faces that touch: forces, tractions, states and slip of the paper's examples, and of a crack sheared to and fro.

Example 1: two blocks with a frictional interface, pressed askew and pushed sideways. Example 2: a block on a rigid,
rough foundation, or on an elastic one that is 1e7 times stiffer. Example 3: a closed crack at 30 degrees.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.quadrature.rules import gauss
from crackgrow.run.checkpoint import beginning
from crackgrow.run.increments import LoadState
from crackgrow.run.loading import LoadsInTurn
from crackgrow.run.scene import make_scene
from tests.verification.solutions import CASES, Floats, Solved, jump_of, rate, relative_L2, solved, table
from tests.verification.table import Record, Row, parameters


def interface(friction: str, spacing: float = 0.05) -> Solved:
    """Example 1."""
    return solved(f"interface_friction{friction.replace('.', '')}", f"numerics.spacing={spacing}")


def force_between(friction: str, axis: int) -> float:
    """Size of the force (MN/m) between the blocks along x or y."""
    (reaction,) = (r for r in interface(friction).result.reactions if r.where == "upper/lower")
    return abs(reaction.force[axis]) / 1e6


def interface_error(friction: str, what: str, spacing: float = 0.05) -> float:
    """Relative mean-square difference of pressure, shear or slip along the whole interface."""
    reference, solution, x = table(f"interface_strain_friction{friction}.csv"), interface(friction, spacing), X
    if what == "slip":
        return relative_L2(x, np.abs(solution.jump(x)[1]), np.interp(x, reference["x_m"], np.abs(reference["slip_m"])))
    normal, shear = solution.tractions(x)
    found = -normal if what == "pressure" else np.abs(shear)
    column = "normal_pressure_Pa" if what == "pressure" else "shear_Pa"
    return relative_L2(x, found, np.interp(x, reference["x_m"], np.abs(reference[column])))


def interface_order(friction: str, what: str) -> float:
    """The order of that difference."""
    spacings = (0.1, 0.05, 0.025)
    return rate(spacings, [interface_error(friction, what, spacing) for spacing in spacings])


X = np.linspace(0.0, 1.0, 2001)
INTERFACES = {"0.1": (635.76, 63.576), "0.4": (635.76, 214.29)}
"""Normal and shear force (MN/m) by friction."""


def _interfaces() -> Iterator[Row]:
    for friction, (normal, shear) in INTERFACES.items():
        name, code = f"interface, friction {friction}", f"interface_strain_friction{friction}.csv"
        value = partial(force_between, friction, 1)
        yield Row(name, "normal force [MN/m]", value, normal, code, 5e-4)
        value = partial(force_between, friction, 0)
        yield Row(name, "shear force [MN/m]", value, shear, code, 5e-4 if friction == "0.1" else 2e-3)
        for what, tolerance in (("pressure", 1e-2), ("shear", 2e-2 if friction == "0.1" else 3e-2), ("slip", 1e-2)):
            value = partial(interface_error, friction, what)
            yield Row(name, f"L2 difference of {what}", value, 0.0, code, tolerance)
    code = "interface_strain_friction0.{}.csv"
    value = partial(interface_order, "0.1", "pressure")  # at rims the pressure's moment is kept, not its shape
    yield Row("interface, friction 0.1", "order of pressure", value, 1.4, code.format(1), 0.0, "at least")
    value = partial(interface_order, "0.4", "shear")
    yield Row("interface, friction 0.4", "order of shear", value, 1.0, code.format(4), 0.0, "at least")


AWAY = 1.6  # m: the corners of the block at 2 m are singular
BLOCK = "block_strain_pull_right.csv, good to 3e-5"
LEFT = "loads.1.traction=[-60,0]"


def block(case: str, spacing: float, support: float, *settings: str) -> Solved:
    """Example 2."""
    return solved(case, f"numerics.spacing={spacing}", f"numerics.support={support}", *settings)


def pressure_and_shear(solution: Solved) -> tuple[Floats, Floats, Floats]:
    """Places x (n,) m of the contact nodes, pressure and shear on the block towards -x (n,) Pa."""
    contact = solution.result.contact
    order = np.argsort(contact.points[:, 0])
    x, normal, shear = (v[order] for v in (contact.points[:, 0], contact.normal_traction, contact.tangential_traction))
    force = next(r.force[0] for r in solution.result.reactions if "." in r.where or "/" in r.where)
    towards = np.sign(force) * np.sign(np.trapezoid(shear, x))  # the traction's sign, as a force on the block
    return x, -normal, -towards * shear


def below_block(x: Floats) -> tuple[Floats, ...]:
    """The reference's pressure and shear (n,) Pa at places x (n,) m."""
    rows = table("block_strain_pull_right.csv")
    sign = np.sign(np.trapezoid(rows["shear_on_block_Pa"], rows["x_m"]))
    return tuple(np.interp(x, rows["x_m"], v) for v in (rows["normal_pressure_Pa"], sign * rows["shear_on_block_Pa"]))


def block_error(what: int, spacing: float, support: float, L2: bool = False) -> float:
    """Difference of pressure or shear away from the corners: the largest at a node, or in the mean square."""
    x, *found = pressure_and_shear(block("block_rigid", spacing, support))
    inside, line = np.abs(x) <= AWAY, np.linspace(-AWAY, AWAY, 801)
    if L2:
        return relative_L2(line, np.interp(line, x, found[what]), below_block(line)[what])
    wanted = below_block(x)[what]
    return float(np.abs(found[what] - wanted)[inside].max() / np.abs(wanted[inside]).max())


def reaction(case: str, axis: int, *settings: str) -> float:
    """Force (N/m) on the block from below, its sign turned to that of the load."""
    return -block(case, 0.2, 1.5, *settings).result.reactions[-1].force[axis]


def _blocks() -> Iterator[Row]:
    for what, L2 in (("pressure", 3e-2), ("shear", 6e-2)):
        axis = int(what == "shear")
        for support in (1.5, 2.0):
            fine, papers = (f"block_rigid, {spacing} m, support {support}" for spacing in (0.05, 0.2))
            value = partial(block_error, axis, 0.05, support)
            yield Row(fine, f"largest difference of {what}", value, 0.0, BLOCK, 2e-2)
            value = partial(block_error, axis, 0.2, support, True)
            yield Row(papers, f"L2 difference of {what}", value, 0.0, BLOCK, L2)
    for case in ("block_rigid", "block_foundation"):
        for axis, load in ((1, -720.0), (0, 120.0)):
            yield Row(case, f"force along {'xy'[axis]} [N/m]", partial(reaction, case, axis), load, "equilibrium", 1e-8)
    value = partial(reaction, "block_rigid", 0, LEFT)
    yield Row("block_rigid, pushed to the left", "force along x [N/m]", value, -120.0, "equilibrium", 1e-8)


HALF_LENGTH = 5e-3  # m
CURVES = {"pressure": ("normal_pressure_MPa", 1e6), "shear": ("shear_MPa", 1e6), "slip": ("slip_mm", 1e-3)}


def crack_error(friction: float, what: str) -> float:
    """Largest difference of pressure, shear or slip at least a spacing from the tips, relative to the largest."""
    solution = solved("compression30", f"cracks.flaw.contact.friction={friction}", "numerics.spacing=0.75")
    s = np.linspace(-1.0, 1.0, 201) * (HALF_LENGTH - 0.75e-3)
    normal, shear = solution.tractions(s + HALF_LENGTH)
    found = {"pressure": -normal, "shear": np.abs(shear), "slip": np.abs(solution.jump(s + HALF_LENGTH)[1])}[what]
    rows, (column, unit) = table(f"closed_crack_theta30_friction{friction:g}.csv"), CURVES[what]
    wanted = np.abs(np.interp(s, rows["s_mm"] * 1e-3, rows[column])) * unit
    return float(np.abs(found - wanted).max() / wanted.max())


def _cracks() -> Iterator[Row]:
    for friction, what in ((0.0, "pressure"), (0.0, "slip"), (0.3, "pressure"), (0.3, "shear"), (0.3, "slip")):
        source, value = f"closed_crack_theta30_friction{friction:g}.csv", partial(crack_error, friction, what)
        yield Row(f"compression30, friction {friction}", f"largest difference of {what}", value, 0.0, source, 5e-3)


A, PRIME, LIMIT, AMPLITUDE = 0.01, 1e10 / (1.0 - 0.25**2), 0.5 * 20e6, 30e6  # m, Pa, Pa: friction's shear, Pa
HISTORY = AMPLITUDE * 0.2 * np.concatenate([np.arange(1, 6), np.arange(4, -6, -1), np.arange(-4, 6)])
"""Shear (Pa) of cyclic_friction, along a crack |x| < a in a plate that is pressed by a constant pressure."""


def slipping(shear: Floats) -> Floats:
    """w (n,) Pa, the part of the shear (n,) that friction does not bear: slip is 4 w / E' sqrt(a^2 - x^2).

    Uniform w leaves the pressure as it is, so that Coulomb's law holds at all points at once: w is dragged along by the
    shear with a play of friction's (Brokate, Sprekels 1996, Hysteresis and Phase Transitions).
    """
    w = [0.0]
    for tau in shear:
        w.append(float(np.clip(w[-1], tau - LIMIT, tau + LIMIT)))
    return np.array(w[1:])


@cache
def cycle(*factors: float) -> tuple[list[LoadState], Floats]:
    """cyclic_friction under factors, its own if none are given: its states, and K_II (n,) Pa sqrt(m) at the end."""
    settings = [f"loading.history={list(factors)}"] if factors else []
    scene = make_scene(load_case(CASES / "cyclic_friction.yaml", settings))
    in_turn = LoadsInTurn(scene, beginning(scene.case).cracks)
    found = [in_turn.solution(number) for number in range(scene.case.n_loads)]
    if not factors:
        np.testing.assert_allclose(AMPLITUDE * np.array([each.factor for each in found]), HISTORY, atol=1.0)
    return list(found), np.array([each.tips[1].K[1] for each in found])


def slip_of_cycle() -> float:
    """Largest difference of the mean slip from pi a w / E' in any step, relative to the largest slip."""
    t, weights = gauss(40)  # x = -a cos(theta): smooth at the tips
    s, weights = A * (1.0 - np.cos(np.pi * t)), 0.5 * np.pi * weights * np.sin(np.pi * t)
    found = np.array([weights @ jump_of(state.configuration, state.outcome.u, s)[1] for state in cycle()[0]])
    wanted = np.pi * A / PRIME * slipping(HISTORY)
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def K_of_cycle() -> float:
    """Largest difference of K_II from w sqrt(pi a), relative to the largest."""
    wanted = np.sqrt(np.pi * A) * slipping(HISTORY)
    return float(np.abs(cycle()[1] - wanted).max() / np.abs(wanted).max())


def dissipated() -> float:
    """Largest difference of what friction takes from 2 pi a^2 tau_f / E' times the way of w, over all of it."""
    found = np.array([state.energy.dissipated for state in cycle()[0]])
    wanted = 2.0 * np.pi * A**2 * LIMIT / PRIME * np.cumsum(np.abs(np.diff(slipping(HISTORY), prepend=0.0)))
    return float(np.abs(found - wanted).max() / wanted[-1])


def one_or_twenty() -> float:
    """Relative difference of the end states that one increment and twenty lead to."""
    once, often = (cycle(*factors)[0][-1].outcome.u for factors in ((1.0,), tuple(np.linspace(0.05, 1.0, 20).tolist())))
    return float(np.abs(once - often).max() / np.abs(once).max())


def balance() -> float:
    """Largest relative error of the energy balance of any step."""
    return max(state.energy.error for state in cycle()[0])


def _cycle() -> Iterator[Row]:
    formula = "infinite plate: a plate of 15 crack lengths slips 0.2 % more"
    yield Row("cyclic_friction", "mean slip in all steps", slip_of_cycle, 0.0, formula, 5e-3)
    yield Row("cyclic_friction", "K_II in all steps", K_of_cycle, 0.0, formula, 1e-2)
    yield Row("cyclic_friction", "dissipated energy in all steps", dissipated, 0.0, formula, 5e-3)
    yield Row("cyclic_friction", "one increment or twenty", one_or_twenty, 0.0, "nothing turns back", 1e-9)
    yield Row("cyclic_friction", "energy balance", balance, 0.0, "work = strain energy + dissipation", 1e-3)


@pytest.mark.parametrize("row", parameters(_interfaces(), _blocks(), _cracks(), _cycle()))
def test_value_is_within_its_tolerance(row: Row, record_property: Record) -> None:
    row.check(record_property)
