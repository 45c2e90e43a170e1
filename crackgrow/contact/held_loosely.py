"""Contact of pieces that nothing but contact holds: springs whose far ends follow them."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crackgrow.contact.anderson import accelerated
from crackgrow.contact.law import ContactMemory
from crackgrow.contact.solve import ContactOutcome, solve_contact
from crackgrow.contact.system import ContactSystem
from crackgrow.errors import FreePieceError
from crackgrow.solid.rigid_modes import FreePiece, Springs

Floats = NDArray[np.float64]

MOST_PULLS: Final = 60
"""Solves after which springs that still carry force are given up."""

LAST_PULLS: Final = 8
"""The springs' force has to halve within so many solves, or within one for each spring if those are more: so many
Anderson's method needs to know how the force depends on their ends."""

SLACK: Final = 1e-10
"""Springs with a force below this part of the loads are slack."""

NEARLY_SLACK: Final = 1e-5
"""The same where round-off lets the springs' force fall no further: the solution carries a note."""


def solve_contact_held_loosely(
    contact: ContactSystem,
    springs: Springs,
    pieces: tuple[FreePiece, ...],
    loads: Floats,
    given: Floats,
    memory: ContactMemory | None = None,
) -> ContactOutcome:
    """As `solve_contact` where the system's stiffness contains `springs` on pieces that contact alone holds.

    The springs' far ends follow the rock until they carry no force (the proximal point method, Rockafellar 1976): the
    solution is that of the rock without springs. Raises FreePieceError where contact does not hold a piece.
    """
    memory = memory or ContactMemory.fresh(len(contact.weights))
    outcome: ContactOutcome | None = None
    ends, drifts = [np.zeros(len(springs.dofs))], []
    left: list[float] = []  # of the loads, in the springs
    patience = max(LAST_PULLS, len(springs.dofs))
    for _ in range(MOST_PULLS):
        pulled = loads.copy()
        np.add.at(pulled, springs.dofs, springs.stiffness * ends[-1])
        outcome = solve_contact(contact, pulled, given, memory)
        if left and left[-1] <= SLACK:  # this was once more: the error left has fallen again
            return outcome
        drifts.append(outcome.u[springs.dofs] - ends[-1])
        ends.append(accelerated(ends, drifts))
        pressed = contact.weights @ np.abs(outcome.normal_traction)
        force = float(np.abs(springs.stiffness * drifts[-1]).max())
        left.append(force / max(float(np.abs(loads).sum()), float(pressed)) if force > 0.0 else 0.0)
        if left[-1] <= min(left):
            best = outcome
        if len(left) > patience and left[-1] > SLACK and min(left[-patience:]) > 0.5 * min(left[:-patience]):
            break
    if min(left) <= NEARLY_SLACK:
        note = f"pieces held by contact are out of balance by {min(left):.1g} of the loads: very unlike stiffnesses"
        return replace(best, notes=(*best.notes, note))
    drift = drifts[int(np.argmin(left))]
    piece = pieces[int(springs.piece[int(np.argmax(np.abs(drift)))])]
    what = f"{piece} is free to move: contact does not hold it"
    raise FreePieceError(what, "it needs supports, friction or another load")
