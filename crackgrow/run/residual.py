"""What a solved configuration misses of equilibrium; whether its fields are finite, and their products will be."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.units import place_text
from crackgrow.contact.solve import ContactOutcome
from crackgrow.contact.system import ContactSystem
from crackgrow.cover.cover import Cover
from crackgrow.errors import NotSolvedError, SolveError
from crackgrow.linear import SymmetricMatrix

LARGEST = 1e100
"""Forces and stiffnesses, in SI, beyond which energies may overflow."""

LARGEST_STRAIN = 1e60
"""Displacements over the spacing beyond which stresses and their squares may overflow."""

UNSTRESSED = 1e-6
"""Forces below this fraction of the terms that they are the sum of are no forces."""

WORST_RESIDUAL = 1e-5
"""Relative equilibrium residual beyond which a solution is refused."""

LOST_DIGITS = 1e-9
"""Of the terms of a force: what round-off leaves of them at worst."""


def checked_residual(
    cover: Cover, matrix: SymmetricMatrix, contact: ContactSystem, loads: Floats, outcome: ContactOutcome
) -> tuple[float, float]:
    """Equilibrium residual K u + C' m + G' W p - f, relative to the largest of its parts, and the largest terms (N/m).

    These are what stress forces are the sums of. Where nothing is stressed all parts are round-off, and the terms give
    the size. Raises NotSolvedError where it is too large.
    """
    internal, terms = matrix @ outcome.u, matrix.sizes(outcome.u)
    reactions = contact.system.constraints.T @ outcome.multipliers
    tractions = contact.gap_of.T @ (contact.weights * outcome.points.normal)
    tractions = tractions + contact.slip_of.T @ (contact.weights * outcome.points.tangential)
    parts = (internal, reactions, tractions, loads)
    size, most = max(np.abs(part).max(initial=0.0) for part in parts), float(terms.max(initial=0.0))
    size = max(size, UNSTRESSED * most)
    if size == 0.0:
        return 0.0, most
    left = np.abs(internal + reactions + tractions - loads)
    dof = int(np.argmax(left))
    found, of_terms = float(left[dof] / size), float(terms[dof] / size)
    if found <= WORST_RESIDUAL:
        return found, most
    near = place_text(cover.lattice.to_map(_place_of(cover, dof // 2)), 4)
    what = f"the equilibrium residual is {found:.2g}, more than {WORST_RESIDUAL:g}, near {near}"
    if found > LOST_DIGITS * of_terms:
        raise NotSolvedError(
            f"{what}: no state was found in which forces balance there; use smaller load increments or a spacing"
        )
    raise NotSolvedError(
        f"{what}: the system is too ill conditioned there, with terms {of_terms:.1g} times the forces; move what lies "
        "close together (a tip, a crack, an outline, a lattice line) a little, or change numerics.spacing"
    )


def _place_of(cover: Cover, function: int) -> Floats:
    """The node of a physical patch (2,), or the tip that a singular function belongs to, in lattice coordinates."""
    if function < len(cover.patches.nodes):
        return np.asarray(cover.patches.nodes[function])
    first = [tip.first_function for tip in cover.tips]
    return cover.tips[int(np.searchsorted(first, function, side="right")) - 1].point


def check_magnitude(field: str, values: Floats, largest: float, unit: str) -> None:
    """Raise SolveError, naming the `field`, unless all values are finite and none is larger than `largest`."""
    size = float(np.abs(values).max(initial=0.0))
    if not size <= largest:  # false for what is not a number, too
        raise SolveError(
            f"{field}: a value is {size:.3g} {unit}, wanted: finite, at most {largest:g} {unit}; "
            "check the units and sizes of loads, lengths and moduli"
        )
