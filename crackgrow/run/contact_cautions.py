"""What makes a step's contact tractions doubtful: waves that no rock makes."""

from __future__ import annotations

from collections.abc import Iterator

from crackgrow.contact.ripple import worst_ripple
from crackgrow.run.caution import Cause, Caution
from crackgrow.run.judging import StepSolution


def contact_cautions(solution: StepSolution) -> Iterator[Caution]:
    """What the user should know of the contact of a step."""
    outcome, cover = solution.outcome, solution.cover
    worst = worst_ripple(cover, solution.faces, outcome.normal_traction, outcome.tangential_traction)
    if worst is not None and worst.part > Cause.RIPPLE.limit:
        place = f"'{cover.surfaces[worst.surface].name}'"
        yield Cause.RIPPLE.at(place, worst.part, percent=100.0 * worst.part)
