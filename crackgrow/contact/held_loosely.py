"""Contact of pieces that nothing but contact holds: springs whose far ends follow them."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crackgrow.contact.anderson import accelerated
from crackgrow.contact.law import ContactMemory
from crackgrow.contact.solve import MOST_PULLS, ContactOutcome, solve_increment
from crackgrow.contact.system import ContactSystem
from crackgrow.errors import FreePieceError
from crackgrow.solid.rigid_modes import FreePiece, Springs

Floats = NDArray[np.float64]

LAST_PULLS: Final = 8
"""The springs' force has to halve within so many solves."""

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
    forces: list[float] = []
    slack = False
    for _ in range(MOST_PULLS):
        pulled = loads.copy()
        np.add.at(pulled, springs.dofs, springs.stiffness * ends[-1])
        outcome = solve_increment(contact, pulled, given, memory, outcome)
        if slack:  # this was once more: the error left has fallen again
            return outcome
        drifts.append(outcome.u[springs.dofs] - ends[-1])
        ends.append(accelerated(ends, drifts))
        pressed = contact.weights @ np.abs(outcome.normal_traction)
        forces.append(float(np.abs(springs.stiffness * drifts[-1]).max()))
        if forces[-1] <= SLACK * max(float(np.abs(loads).sum()), float(pressed)):
            slack = True
        elif len(forces) > LAST_PULLS and forces[-1] > 0.5 * forces[-1 - LAST_PULLS]:
            break
    assert outcome is not None
    left = forces[-1] / max(float(np.abs(loads).sum()), float(pressed))
    if left <= NEARLY_SLACK:
        note = f"pieces held by contact are out of balance by {left:.1g} of the loads: very unlike stiffnesses"
        return replace(outcome, notes=(*outcome.notes, note))
    drift = drifts[-1]
    piece = pieces[int(springs.piece[int(np.argmax(np.abs(drift)))])]
    what = f"{piece} is free to move: contact does not hold it"
    raise FreePieceError(what, "it needs supports, friction or another load")
