"""The plan of a case in words: what is modelled and why, how large it is, what it costs, what to beware of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict

from crackgrow.case.accuracy import name_of
from crackgrow.case.changes import changes_of
from crackgrow.case.model import Case
from crackgrow.plan.cost import Cost, estimated_cost
from crackgrow.plan.overview import overview
from crackgrow.plan.sizes import Sizes, sizes_of
from crackgrow.results.gathered import Gathered
from crackgrow.results.places import length_unit
from crackgrow.results.units import counted
from crackgrow.run.warning_causes import StepWarning, WarningCause

SHOWN_SURFACES = 12  # of more the rest is summed up


def plan_text(case: Case) -> str:
    """Lines of text: the overview of the case, the model of step 0, its cost, warnings. Raises GeometryError."""
    sizes = sizes_of(case)
    cost = estimated_cost(case, sizes)
    takes = f"the whole run takes {cost.words}, within a factor of two for most scenes"
    warnings = [f"warning: {text}" for text in _warnings(sizes, cost)] or ["no warnings"]
    return "\n".join([overview(case), "model of step 0:", *_model(case, sizes), takes, *warnings])


def plan_record(case: Case) -> dict[str, object]:
    """The model of step 0, its cost and the warnings, in what JSON can hold; s, MiB, m. Raises GeometryError."""
    sizes = sizes_of(case)
    cost = estimated_cost(case, sizes)
    model = asdict(sizes)
    del model["scene_warnings"]
    return {
        "case": case.name,
        "title": case.title,
        "spacing": case.numerics.spacing,
        "model": model,
        "cost": asdict(cost),
        "warnings": _warnings(sizes, cost),
        "changes": [text for kind in changes_of(case) for text in kind],
    }


def _model(case: Case, sizes: Sizes) -> Iterator[str]:
    gathered = f" (gathered at {sizes.n_gathered})" if sizes.n_gathered else ""
    singular = f"{8 * sizes.n_singular} of tip functions at {counted(sizes.n_tips, 'tip')}{gathered}"
    dofs = [f"{2 * sizes.n_patches} of {sizes.n_patches} physical patches", *([singular] if sizes.n_singular else [])]
    yield f"  {sizes.n_dofs} dofs: {', '.join(dofs)}; {sizes.n_elements} manifold elements"
    yield f"  {counted(sizes.n_multipliers, 'multiplier')} for supports and bonds"
    if case.numerics.measured:
        name = name_of(case.numerics.target, case.numerics.goal)
        yield f"  {name}: cells are refined where that is missed, and coarsened again; these are the first"
    if len(sizes.cells) > 1:
        scale, unit = length_unit(case)
        yield "  cells: " + ", ".join(f"{n} of {side * scale:.3g} {unit}" for side, n in sizes.cells)
    kind = "mortar nodes" if case.numerics.contact.discretization == "mortar" else "Gauss points"
    sides = "normal and tangential" if any(surface.rough for surface in sizes.surfaces) else "normal alone"
    points = f"{counted(sizes.n_tractions, 'traction')} at {sizes.n_contact} {kind}, {sides}"
    yield f"  contact: {points if sizes.n_contact else 'none'}"
    for surface in sizes.surfaces[:SHOWN_SURFACES]:
        law = "with friction or cohesion" if surface.rough else "normal contact alone: neither friction nor cohesion"
        untouched = "bonded: multipliers close gap and slip" if surface.bonded else "no contact: its faces never touch"
        said = f"{counted(surface.n_points, 'point')}, {law}" if surface.touching else untouched
        yield f"    {surface.name}: {said}"
    rest = sizes.surfaces[SHOWN_SURFACES:]
    if rest:
        yield f"    {len(rest)} more: {counted(sum(surface.n_points for surface in rest), 'point')}"


def _warnings(sizes: Sizes, cost: Cost) -> list[str]:
    gathered, memory = Gathered(), cost.warning
    gathered.add(0, [*sizes.scene_warnings, *([StepWarning(WarningCause.MEMORY, memory)] if memory else [])])
    return list(gathered.sentences(with_steps=False))
