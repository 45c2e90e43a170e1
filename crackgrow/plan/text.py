"""The plan of a case in words: what is modelled and why, how large it is, what it costs, what to beware of."""

from __future__ import annotations

from dataclasses import asdict

from crackgrow.case.accuracy import name_of
from crackgrow.case.model import Case
from crackgrow.plan.cost import Cost, estimated_cost, machine_memory
from crackgrow.plan.sizes import Sizes, sizes_of
from crackgrow.results.gathered import Gathered
from crackgrow.results.log import counted
from crackgrow.results.overview import length_unit, overview
from crackgrow.run.caution import Cause, Caution

LARGEST_SUPPORT = 3.0  # up to which the cost was measured
SHOWN_SURFACES = 12  # of more the rest is summed up


def plan_text(case: Case) -> str:
    """Lines of text: the overview of the case, the model of step 0, its cost, warnings. Raises GeometryError."""
    sizes = sizes_of(case)
    cost = estimated_cost(case, sizes)
    warnings = [f"warning: {text}" for text in _warnings(sizes, cost)] or ["no warnings"]
    return "\n".join([overview(case), *_model(case, sizes), *_cost(case, cost), *warnings])


def plan_record(case: Case) -> dict[str, object]:
    """The model of step 0, its cost and the warnings, in what JSON can hold; s, MiB, m. Raises GeometryError."""
    sizes = sizes_of(case)
    cost = estimated_cost(case, sizes)
    known = asdict(sizes)
    return {
        "case": case.name,
        "title": case.title,
        "spacing": case.numerics.spacing,
        "model": {name: value for name, value in known.items() if name != "cautions"},
        "cost": {**asdict(cost), "total": cost.total},
        "warnings": _warnings(sizes, cost),
    }


def _model(case: Case, sizes: Sizes) -> list[str]:
    standard, singular = 2 * sizes.n_patches, 8 * sizes.n_singular
    gathered = f" (gathered at {sizes.n_gathered})" if sizes.n_gathered else ""
    lines = [
        "model of step 0:",
        f"  {sizes.n_dofs} dofs: {standard} of {sizes.n_patches} physical patches"
        + (f", {singular} of tip functions at {counted(sizes.n_tips, 'tip')}{gathered}" if singular else "")
        + f"; {sizes.n_elements} manifold elements",
        f"  {counted(sizes.n_multipliers, 'multiplier')} for supports and bonds",
    ]
    if case.numerics.target is not None:
        name = name_of(case.numerics.target, case.numerics.goal)
        lines.append(f"  {name}: cells are halved where that is missed, or joined; these are the first")
    if len(sizes.cells) > 1:
        scale, unit = length_unit(case)
        lines.append("  cells: " + ", ".join(f"{n} of {side * scale:.3g} {unit}" for side, n in sizes.cells))
    if sizes.n_contact:
        kind = "mortar nodes" if case.numerics.contact.discretization == "mortar" else "Gauss points"
        sides = "normal and tangential" if any(surface.rough for surface in sizes.surfaces) else "normal alone"
        lines.append(f"  contact: {counted(sizes.n_tractions, 'traction')} at {sizes.n_contact} {kind}, {sides}")
    else:
        lines.append("  contact: none")
    shown = sizes.surfaces[:SHOWN_SURFACES]
    reasons = {False: "no contact: its faces never touch", True: "bonded: multipliers close gap and slip"}
    for surface in shown:
        if surface.touching:
            law = (
                "with friction or cohesion" if surface.rough else "normal contact alone: neither friction nor cohesion"
            )
            lines.append(f"    {surface.name}: {counted(surface.n_points, 'point')}, {law}")
        else:
            lines.append(f"    {surface.name}: {reasons[surface.bonded]}")
    rest = sizes.surfaces[SHOWN_SURFACES:]
    if rest:
        lines.append(f"    {len(rest)} more: {counted(sum(surface.n_points for surface in rest), 'point')}")
    return lines


def _cost(case: Case, cost: Cost) -> list[str]:
    implicit = " (implicit directions: three solves)" if case.growth and case.growth.direction == "implicit" else ""
    later = f", {_seconds(cost.later_step)} each of {cost.n_later} more{implicit}" if cost.n_later else ""
    total = f"; {_seconds(cost.total)} in all" if cost.n_later else ""
    sure = "within a factor of two" if case.numerics.support <= LARGEST_SUPPORT else "a tenth of it perhaps"
    found = [
        f"estimated cost, {sure}: {_seconds(cost.first_step)} of CPU for the first step{later}{total}, "
        f"without files and pictures; {_memory(cost.memory)} of memory"
    ]
    if case.numerics.target is not None:
        found.append("that is of one solve on these cells: the first step takes two to six, later ones one or two")
    return found


def _memory_cautions(cost: Cost) -> list[Caution]:
    """What to say where the machine has less memory than the run takes."""
    available = machine_memory()
    if cost.memory <= Cause.MEMORY.limit * available:
        return []
    words = (
        f"the run needs about {_memory(cost.memory)} of memory, and this machine has {_memory(available)}: it would be "
        "killed or stand still; use a larger numerics.spacing, a smaller specimen, or numerics.accuracy draft"
    )
    return [Caution(Cause.MEMORY, words)]


def _warnings(sizes: Sizes, cost: Cost) -> list[str]:
    gathered = Gathered()
    gathered.add(0, [*sizes.cautions, *_memory_cautions(cost)])
    return list(gathered.sentences(with_steps=False))


def _seconds(value: float) -> str:
    if value >= 90.0:
        return f"{value / 60.0:.2g} min" if value < 5400.0 else f"{value / 3600.0:.2g} h"
    return f"{value:.2g} s"


def _memory(value: float) -> str:
    return f"{value:.0f} MiB" if value < 1000.0 else f"{value / 1024.0:.2g} GiB"
