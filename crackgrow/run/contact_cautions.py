"""What makes a step's contact tractions doubtful: waves that no rock makes, and friction that leaves a choice."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from crackgrow.contact.coulomb import OPEN, SLIP, STICK
from crackgrow.contact.ripple import worst_ripple
from crackgrow.contact.second_solution import second_solution
from crackgrow.run.step import StepSolution

LARGE_RIPPLE: Final = 0.1
"""Short waves of the contact tractions, as a part of the mean pressure, from which a step carries a warning."""

WORDS: Final = {OPEN: "is open", STICK: "sticks", SLIP: "slips"}


def contact_cautions(solution: StepSolution) -> Iterator[str]:
    """What the user should know of the contact of a step."""
    outcome, faces, surfaces = solution.outcome, solution.faces, solution.cover.surfaces
    worst = worst_ripple(faces, outcome.normal_traction, outcome.tangential_traction)
    if worst is not None and worst.part > LARGE_RIPPLE:
        yield (
            f"contact tractions on '{surfaces[worst.surface].name}' oscillate by {100.0 * worst.part:.2g} % of their "
            "mean pressure within two spacings, and K_I with them: contact points are closer than the displacement can "
            "follow; use numerics.contact.discretization mortar (with a spacing of 1.25 or more), or a softer contact"
        )
    second = second_solution(solution.contact, outcome)
    if second is not None:
        point = int(second.points[0])
        x, y = solution.cover.lattice.to_metres(faces.nodes.points[[point]])[0]
        yield (
            f"friction leaves more than one solution (certainly not where it is below {second.limit:.2g}): in another "
            f"one the point ({x:.4g}, {y:.4g}) m of '{surfaces[faces.surface[point]].name}', which "
            f"{WORDS[int(outcome.state[point])]}, {WORDS[int(second.states[0])]}, its faces moved by "
            f"{second.change[0]:.2g} m; apply the loads in steps (loading.history), or lower the friction there"
        )
