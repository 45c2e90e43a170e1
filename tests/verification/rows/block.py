"""Example 2 of the paper: a block on a rigid, rough foundation, or on an elastic one that is 1e7 times stiffer."""

from __future__ import annotations

from functools import partial

import numpy as np

from crackgrow.run.result import SLIP, STATE_NAMES, STICK
from tests.verification.row import Row
from tests.verification.solutions import Floats, Solved, relative_L2, solved, table

AWAY = 1.6  # m: the corners at 2 m are singular
CODE = "block_strain_pull_right.csv, good to 3e-5"
LEFT = "loads.1.traction=[-60,0]"


def at(case: str, spacing: float, support: float, *settings: str) -> Solved:
    return solved(case, f"numerics.spacing={spacing}", f"numerics.support={support}", *settings)


def pressure_and_shear(solution: Solved) -> tuple[Floats, Floats, Floats]:
    """Places x (n,) m of the contact nodes, pressure and shear on the block towards -x (n,) Pa."""
    contact = solution.result.contact
    order = np.argsort(contact.points[:, 0])
    x, normal, shear = (v[order] for v in (contact.points[:, 0], contact.normal_traction, contact.tangential_traction))
    force = next(r.force[0] for r in solution.result.reactions if "." in r.where or "/" in r.where)
    towards = np.sign(force) * np.sign(np.trapezoid(shear, x))  # the traction's sign, as a force on the block
    return x, -normal, -towards * shear


def reference(x: Floats) -> tuple[Floats, Floats]:
    rows = table("block_strain_pull_right.csv")
    sign = np.sign(np.trapezoid(rows["shear_on_block_Pa"], rows["x_m"]))
    return tuple(np.interp(x, rows["x_m"], v) for v in (rows["normal_pressure_Pa"], sign * rows["shear_on_block_Pa"]))


def largest_difference(case: str, what: int, spacing: float, support: float) -> float:
    """Largest pointwise difference at the nodes away from the corners, relative to the largest reference there."""
    x, *found = pressure_and_shear(at(case, spacing, support))
    inside = np.abs(x) <= AWAY
    wanted = reference(x)[what]
    return float(np.abs(found[what] - wanted)[inside].max() / np.abs(wanted[inside]).max())


def mean_square_difference(case: str, what: int, spacing: float, support: float) -> float:
    x, *found = pressure_and_shear(at(case, spacing, support))
    line = np.linspace(-AWAY, AWAY, 801)
    return relative_L2(line, np.interp(line, x, found[what]), reference(line)[what])


def foundation_against_rigid(spacing: float, support: float) -> float:
    x, *elastic = pressure_and_shear(at("block_foundation", spacing, support))
    other, *rigid = pressure_and_shear(at("block_rigid", spacing, support))
    inside = np.abs(x) <= AWAY
    differences = [np.interp(x, other, r) - e for r, e in zip(rigid, elastic, strict=True)]
    return max(
        float(np.abs(d[inside]).max() / np.abs(e[inside]).max()) for d, e in zip(differences, elastic, strict=True)
    )


def reaction(case: str, axis: int, *settings: str) -> float:
    """Force (N/m) on the block from below, its sign turned to that of the load."""
    found = at(case, 0.2, 1.5, *settings).result.reactions[-1]
    return -found.force[axis]


def sticking_share(spacing: float, support: float) -> float:
    return float(np.mean(at("block_rigid", spacing, support).result.contact.state == STICK))


def state_at_right_corner(spacing: float, support: float) -> float:
    contact = at("block_rigid", spacing, support, LEFT).result.contact
    return float(contact.state[np.argmax(contact.points[:, 0])])


def _curves(spacing: float, support: float, words: str):
    for what, name in enumerate(("pressure", "shear")):
        yield Row(
            "block_rigid",
            f"{name}, abs(x) <= 1.6 m, spacing {spacing} m, support {support}: {words}",
            0.0,
            "independent code",
            CODE,
            2e-2,
            partial(largest_difference, "block_rigid", what, spacing, support),
            "at most",
        )


def _at_the_papers_spacing(support: float):
    for what, name in enumerate(("pressure", "shear")):
        yield Row(
            "block_rigid",
            f"{name}, abs(x) <= 1.6 m, at the paper's spacing 0.2 m, support {support}: L2 difference",
            0.0,
            "independent code",
            CODE,
            (3e-2, 6e-2)[what],
            partial(mean_square_difference, "block_rigid", what, 0.2, support),
            "at most",
        )
        yield Row(
            "block_rigid",
            f"{name}, abs(x) <= 1.6 m, at the paper's spacing 0.2 m, support {support}: largest difference, "
            "at the outermost nodes, two spacings from the singular corners",
            0.0,
            "independent code",
            CODE,
            0.15,
            partial(largest_difference, "block_rigid", what, 0.2, support),
            "at most",
        )


ROWS = [
    *(
        Row(
            "block_rigid",
            f"part of the contact nodes that sticks, spacing {spacing} m, support {support}",
            1.0,
            "independent code",
            CODE,
            0.0,
            partial(sticking_share, spacing, support),
            "absolute",
        )
        for spacing, support in (
            (0.2, 1.5),
            (0.2, 2.0),
            (0.05, 1.5),
            (0.05, 2.0),
            (0.025, 2.0),
        )
    ),
    *(row for support in (1.5, 2.0) for row in _curves(0.05, support, "largest difference")),
    *(row for support in (1.5, 2.0) for row in _at_the_papers_spacing(support)),
    Row(
        "block_foundation",
        "largest difference of pressure and shear from block_rigid, abs(x) <= 1.6 m",
        0.0,
        "itself",
        "the limit of a stiff foundation",
        5e-3,
        partial(foundation_against_rigid, 0.1, 2.0),
        "at most",
    ),
    *(
        Row(case, f"{name} reaction [N/m]", load, "exact", "equilibrium", 1e-8, partial(reaction, case, axis))
        for case in ("block_rigid", "block_foundation")
        for axis, name, load in ((1, "vertical", -720.0), (0, "horizontal", 120.0))
    ),
    Row(
        "block_rigid",
        "horizontal reaction, pushed to the left [N/m]",
        -120.0,
        "exact",
        "equilibrium",
        1e-8,
        partial(reaction, "block_rigid", 0, LEFT),
    ),
    Row(
        "block_rigid",
        f"pushed to the left, spacing 0.025 m: state at x = 2 m ({SLIP}: {STATE_NAMES[SLIP]})",
        SLIP,
        "itself",
        "spacing 0.0125 m: the last two nodes slip; at 0.1 and 0.05 m all stick",
        0.0,
        partial(state_at_right_corner, 0.025, 2.0),
        "absolute",
    ),
]
