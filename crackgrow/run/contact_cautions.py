"""What makes a step's contact tractions doubtful: waves that no rock makes."""

from __future__ import annotations

from collections.abc import Iterator

from crackgrow.contact.ripple import worst_ripple
from crackgrow.run.caution import Cause, Caution
from crackgrow.run.judging import StepSolution


def contact_cautions(solution: StepSolution) -> Iterator[Caution]:
    """What the user should know of the contact of a step."""
    outcome, faces, surfaces = solution.outcome, solution.faces, solution.cover.surfaces
    worst = worst_ripple(faces, outcome.normal_traction, outcome.tangential_traction)
    if worst is not None and worst.part > Cause.RIPPLE.limit:
        place = f"'{surfaces[worst.surface].name}'"
        yield Caution(
            Cause.RIPPLE,
            f"contact tractions on {place} oscillate by {100.0 * worst.part:.2g} % of their "
            "mean pressure within two spacings, and K_I with them: contact points are closer than the displacement can "
            "follow; use numerics.contact.discretization mortar (with a spacing of 1.25 or more), or a softer contact",
            place,
            worst.part,
        )
