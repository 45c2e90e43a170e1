"""What makes a step's contact tractions doubtful: waves that no rock makes, and friction that leaves a choice."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from crackgrow.contact.coulomb import OPEN, SLIP, STICK
from crackgrow.contact.ripple import worst_ripple
from crackgrow.contact.second_solution import second_solution
from crackgrow.run.caution import Cause, Caution
from crackgrow.run.judging import StepSolution

WORDS: Final = {OPEN: "is open", STICK: "sticks", SLIP: "slips"}


def contact_cautions(solution: StepSolution) -> Iterator[Caution]:
    """What the user should know of the contact of a step."""
    outcome, faces, surfaces = solution.outcome, solution.faces, solution.cover.surfaces
    worst = worst_ripple(faces, outcome.normal_traction, outcome.tangential_traction)
    if worst is not None and worst.part > Cause.RIPPLE.limit:
        place = f"'{surfaces[worst.surface].name}'"
        yield Cause.RIPPLE.at(place, worst.part, percent=100.0 * worst.part)
    second = second_solution(solution.contact, outcome)
    if second is not None:
        point = int(second.points[0])
        x, y = solution.cover.lattice.to_metres(faces.nodes.points[[point]])[0]
        place = f"'{surfaces[faces.surface[point]].name}'"
        here, there = WORDS[int(outcome.state[point])], WORDS[int(second.states[0])]
        told = {"below": second.limit, "x": x, "y": y, "here": here, "there": there, "change": second.change[0]}
        yield Cause.SECOND_SOLUTION.at(place, abs(second.change[0]), **told)
