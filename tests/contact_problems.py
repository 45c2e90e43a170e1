"""Contact problems that several tests and benchmarks solve: made up, and of real rock with many contact points."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.contact.coulomb import ContactLaw
from crackgrow.contact.problem import ContactProblem
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import assemble
from crackgrow.run.load_level import LoadLevel
from crackgrow.run.scene import make_scene

Floats = NDArray[np.float64]

APART = 1.25
"""Spacings: distance of contact points."""

THICK = 3
"""Spacings: of the rock on either side of the faces."""


def contact_law(friction: Floats, cohesion: Floats, compliance: Floats, **more: Any) -> ContactLaw:
    """A law (n,) by point; what is left out, or None, does nothing: slip breaks cohesion, and no more."""
    zeros = np.zeros(len(friction))
    usual = {"shear_compliance": compliance, "residual_friction": friction, "kept": zeros, "dilation": zeros}
    usual |= {"weakening": zeros, "tension": zeros}
    usual |= {name: value for name, value in more.items() if value is not None}
    rows = (
        (zeros, np.ones(len(friction))),
        (friction, usual["residual_friction"]),
        (cohesion, np.where(usual["kept"], cohesion, 0.0)),
        (usual["tension"], zeros),
        (usual["dilation"],) * 2,
    )
    along, weakening = usual["shear_compliance"], usual["weakening"]
    linear = zeros + np.inf, zeros, zeros + 1.0
    return ContactLaw(compliance, along, weakening, zeros > 0.0, *(np.stack(row) for row in rows), *linear)


def crack_problem(n: int, friction: float, cohesion: float, ratio: float, coupling: float, seed: int) -> ContactProblem:
    """Straight crack on (-1, 1) in an infinite plane: exact opening kernel, constant pressure per cell.

    The normal and tangential rows are coupled by a random block that leaves the whole positive definite (coupling
    below one); the diagonal carries an elastic compliance `ratio` times smaller than that of the solid, none for
    infinity.
    """
    rng = np.random.default_rng(seed)
    x = (2.0 * np.arange(n) + 1.0) / n - 1.0
    distance = np.abs(x[:, None] - x)
    np.fill_diagonal(distance, np.exp(-1.0) / n)  # mean of the logarithm over one cell
    root = np.sqrt(np.outer(1.0 - x**2, 1.0 - x**2))
    K = 2.0 / n * np.log((1.0 - np.outer(x, x) + root) / distance)
    values, vectors = np.linalg.eigh(K)
    half = vectors * np.sqrt(values) @ vectors.T
    Q = rng.normal(size=(n, n))
    C = half @ (Q * (coupling / np.linalg.norm(Q, 2))) @ half
    A = np.block([[K, C], [C.T, K]]) + np.diag(np.tile(K.diagonal() / ratio, 2))
    waves = np.cos(np.pi * np.arange(1, 9)[:, None] * x + rng.uniform(0.0, 6.0, (8, 1)))
    free = np.concatenate([K @ (rng.normal(size=8) @ waves - 1.0), K @ (rng.normal(size=8) @ waves + 0.5)])
    return ContactProblem(A, free, np.full(n, friction), np.full(n, cohesion))


def random_problem(n: int, friction: float, seed: int) -> ContactProblem:
    """Random positive definite compliance with a column scaling, as quadrature weights make it: not symmetric."""
    rng = np.random.default_rng(seed)
    B = rng.normal(size=(2 * n, 2 * n))
    coupling = np.block([[np.ones((n, n)), np.full((n, n), 0.2)], [np.full((n, n), 0.2), np.ones((n, n))]])
    weight = rng.uniform(0.5, 2.0, n)
    A = ((B @ B.T / (2 * n)) * coupling + np.eye(2 * n)) * np.tile(weight, 2)
    return ContactProblem(A, rng.normal(size=2 * n) - 0.3, np.full(n, friction), rng.uniform(0.0, 0.3, n))


def rock_problem(kind: str, n_points: int) -> tuple[ContactProblem, Floats]:
    """All contact points of a strip of rock, without friction coefficient or cohesion, and their lengths (n,) m.

    `kind` is that of `strip`. Its edges are moved so that faces open, stick and slip.
    """
    case = strip(kind, n_points)
    growing = tuple(map(GrowingCrack.given, case.cracks))
    configuration = assemble(make_scene(case), growing)
    contact, n = configuration.contact, configuration.faces.n
    u, _ = contact.system.solve(configuration.loads(LoadLevel(1.0)), configuration.held.given)
    free = contact.operator @ u
    return ContactProblem(
        contact.compliance(np.arange(n), np.ones(n, dtype=bool)), free, np.ones(n), np.zeros(n)
    ), contact.weights


def smooth(compliance: Floats, free: Floats) -> ContactProblem:
    """Points without friction: gaps of compliance (n, n) and free gaps (n,), and slips that nothing resists."""
    n = len(free)
    zero = np.zeros((n, n))
    A = np.block([[compliance, zero], [zero, np.diag(np.diag(compliance))]])
    return ContactProblem(A, np.append(free, np.zeros(n)), np.zeros(n))


def with_law(problem: ContactProblem, friction: float, cohesion: float) -> ContactProblem:
    """The same rock with other faces."""
    n = problem.n_points
    return ContactProblem(problem.compliance, problem.free, np.full(n, friction), np.full(n, cohesion))


def strip(kind: str, n_points: int) -> Case:
    """A long strip of rock between two rigid edges that has about `n_points` contact points along it.

    `kind` is "interface", two blocks on each other, or "crack", a wavy one. The upper edge is moved in waves.
    """
    length = APART * n_points
    upper = {"shape": _rectangle(length, 0, THICK), "material": {"young": 10000, "poisson": 0.3}}
    lower = {"shape": _rectangle(length, -THICK, 0), "material": {"young": 10000, "poisson": 0.3}}
    document: dict[str, Any] = {
        "title": f"A strip with {n_points} contact points",
        "units": {"length": "m", "stress": "MPa"},
        "plane": "strain",
    }
    if kind == "interface":
        document["bodies"] = {"upper": upper, "lower": lower}
        document["interfaces"] = [{"between": ["upper", "lower"], "contact": {"friction": 0.4, "cohesion": 0}}]
        held, moved = "lower", "upper"
    else:
        x = np.arange(2.0, length - 1.9, 2.0)
        wave = np.column_stack([x, np.sin(2.0 * np.pi * x / 24.0)]).tolist()
        crack = {"path": {"points": wave}, "tips": "none", "contact": {"friction": 0.4, "cohesion": 0}}
        document["bodies"] = {"rock": {**upper, "shape": _rectangle(length, -THICK, THICK)}}
        document["cracks"] = {"wave": crack}
        held = moved = "rock"
    moving = {"x": f"0.004*sin({20 / length}*x)+0.002", "y": f"0.003*sin({31 / length}*x)-0.002"}
    document["supports"] = [
        {"on": {"body": held, "edge": "bottom"}, "displacement": {"x": 0, "y": 0}},
        {"on": {"body": moved, "edge": "top"}, "displacement": moving},
    ]
    document["numerics"] = {"spacing": 1}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "strip.yaml"
        file.write_text(yaml.safe_dump(document))
        return load_case(file)


def _rectangle(length: float, low: float, high: float) -> dict[str, Any]:
    return {"rectangle": {"center": [length / 2, (low + high) / 2], "width": length, "height": high - low}}
