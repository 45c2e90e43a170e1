"""What a step is held against: one factorization from nothing and one solve of its matrix, by the program's own solver.

`floor` and `condensation` are the only places that know how a configuration factorizes and how it condenses.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array, eye_array, kron
from scipy.sparse.linalg import splu

from crackgrow.case.model import Case
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.load_level import LoadLevel
from crackgrow.run.scene import make_scene
from crackgrow.solid.linear_solver import ConstrainedSystem
from crackgrow.solid.places import places_of_unknowns

Floats = NDArray[np.float64]

YARDSTICK = 150
"""Nodes along a side of the square grid whose Laplacian is the yardstick."""


@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """The bare factorization and one solve, in CPU seconds."""

    factorize: float
    solve: float
    u: Floats  # (n_dofs,) m, under all loads, without contact tractions


def from_nothing(case: Case) -> Configuration:
    """The first configuration of a case, assembled without any before it."""
    growing = tuple(GrowingCrack(crack, np.zeros(len(crack.points), dtype=np.int64)) for crack in case.cracks)
    return assemble(make_scene(case), growing)


def floor(configuration: Configuration) -> Floor:
    """Factorize the held stiffness as the step does, with nothing known before, and solve for its loads once."""
    stiff = configuration.contact.system.stiffness
    held, loads = configuration.held, configuration.loads(LoadLevel(1.0))

    start = time.process_time()
    places = places_of_unknowns(configuration.cover)
    system = ConstrainedSystem(stiff, held.matrix, places)
    factorized = time.process_time()
    u, _ = system.solve(loads, held.given)
    return Floor(factorized - start, time.process_time() - factorized, u)


def condensation(configuration: Configuration) -> tuple[float, Floats]:
    """CPU seconds of the condensation onto all contact points, and the jumps (2n, 2n) that unit tractions take away."""
    start = time.process_time()
    contact = replace(configuration.contact)  # without what was found before
    jumps = contact.rock
    return time.process_time() - start, jumps


def yardstick() -> float:
    """CPU seconds of work that the program has no part in: SuperLU factorizes the Laplacian of a square grid.

    The floor is held against it, so that a slower solver is not taken for a faster step.
    """
    line = diags_array(
        [-np.ones(YARDSTICK - 1), 2.01 * np.ones(YARDSTICK), -np.ones(YARDSTICK - 1)], offsets=[-1, 0, 1]
    )
    one = eye_array(YARDSTICK)
    laplacian = csc_array(kron(line, one) + kron(one, line))
    start = time.process_time()
    splu(laplacian, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return time.process_time() - start
