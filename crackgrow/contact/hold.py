"""Pieces of rock that contact alone holds, where their contact problem is hard: near the loads that let them go.

The contact problem then is badly conditioned, since loose springs let pieces move far. Limit analysis tells whether the
faces can hold them at all; if they can, stiffer springs make the problem easier. The solution does not depend on them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from crackgrow.contact.held_loosely import solve_contact_held_loosely
from crackgrow.contact.law import ContactMemory
from crackgrow.contact.limit import least_unbalanced
from crackgrow.contact.solve import ContactOutcome
from crackgrow.contact.system import ContactSystem
from crackgrow.cover.cover import Cover
from crackgrow.errors import FreePieceError, SolveError
from crackgrow.solid.dissection import places_of_unknowns
from crackgrow.solid.linear_solver import ConstrainedSystem
from crackgrow.solid.rigid_modes import FreePiece, Springs, free_motions

Floats = NDArray[np.float64]

STIFFER = (3.0, 10.0, 30.0, 100.0)
"""Times the usual stiffness of the springs. Still stiffer ones yield too slowly to tell a piece that is held."""

UNBALANCED = 1e-6
"""Loads out of balance by less than this fraction of them are balanced: what linear programming is good for."""


def solve_contact_of_pieces(
    contact: ContactSystem,
    cover: Cover,
    springs: Springs,
    pieces: tuple[FreePiece, ...],
    loads: Floats,
    given: Floats,
    memory: ContactMemory | None,
) -> ContactOutcome:
    """As `solve_contact_held_loosely`, with other springs where these don't lead to a solution.

    Raises FreePieceError where contact does not hold a piece, SolveError where it may and no solution is found.
    """
    failures = []
    for stiffer in (1.0, *STIFFER):
        stiff, system = springs, contact
        if stiffer > 1.0:
            stiff = replace(springs, stiffness=stiffer * springs.stiffness)
            more = replace(springs, stiffness=(stiffer - 1.0) * springs.stiffness)
            matrix = more.added_to(contact.system.stiffness)
            solver = ConstrainedSystem(
                matrix, contact.system.constraints, places_of_unknowns(cover), contact.system.factors, loose=True
            )
            system = replace(contact, system=solver)
        try:
            outcome = solve_contact_held_loosely(system, stiff, pieces, loads, given, memory)
            told = (system.system.note,) if stiffer > 1.0 and system.system.note else ()
            return replace(outcome, notes=(*outcome.notes, *told))
        except FreePieceError:
            raise
        except SolveError as error:
            failures.append(error)
        if stiffer == 1.0:
            check_can_hold(contact, cover, pieces, loads, memory)
    names = ", ".join(str(piece) for piece in pieces)
    raise SolveError(f"contact alone holds {names}, perhaps only just: {failures[0]}") from failures[0]


def check_can_hold(
    contact: ContactSystem, cover: Cover, pieces: tuple[FreePiece, ...], loads: Floats, memory: ContactMemory | None
) -> None:
    """Raise FreePieceError where no tractions that the faces can carry balance the loads on free pieces."""
    motions = free_motions(cover, contact.system.constraints)
    law = contact.law
    friction, cohesion = (law.friction, law.cohesion) if memory is None else law.bound_of(memory.broken)
    gap, slip = contact.gap_of @ motions, contact.slip_of @ motions
    size = float(np.abs(loads).sum())
    left, way = least_unbalanced(gap, slip, contact.weights, motions.T @ loads, size, friction, cohesion)
    if left > UNBALANCED:
        moved = np.abs(motions @ way)
        piece = pieces[int(np.argmax([moved[2 * piece.functions].max() for piece in pieces]))]
        what = (
            f"{piece} is free to move: contact does not hold it, {100.0 * left:.3g} % of the loads stay out of balance"
        )
        raise FreePieceError(what, "it needs supports, friction or another load")
