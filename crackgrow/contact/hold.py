"""Pieces of rock that contact alone holds, and why it does not where it doesn't.

Limit analysis tells whether any tractions that the faces can carry hold them, and along which motion they give way. The
pieces are rigid here. Balance of the loads along every motion that the supports leave free asks for tractions with

    p_n <= T,   |p_t| <= c - mu p_n

(static theorem, Drucker, Greenberg, Prager 1952), with mu of rough faces the most that it can be. Where there are none,
nothing holds the pieces. Where there are some, faces that slide without dilating may still let the pieces go (Drucker
1954): only the contact problem tells.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.solve import Trial
from crackgrow.contact.system import ContactSystem
from crackgrow.errors import FreePieceError, NotSolvedError
from crackgrow.solid.rigid_modes import FreePiece, RigidMotions

AMPLE = 1e6
"""Times the mean traction of the loads: more cohesion or tensile strength than that is as good as that."""

UNBALANCED = 1e-6
"""Loads out of balance by less than this fraction of them are balanced: what linear programming is good for."""


YIELDS = 1e-3
"""Jumps, and motions, of less than this fraction of the largest are none."""

BROKEN = (
    "contact has lost strength on {}, by slip or opening of the most loaded of its points first ({} of {} by then); "
    "with all of it contact could hold it"
)

SHOWN_PIECES = 3  # of more their number is told

TURNS = 0.05
"""Motions in which the rim of a piece turns by less than this fraction of how far it moves are translations."""


def check_can_hold(contact: ContactSystem, surface: Sequence[str], loads: Floats, trial: Trial | None = None) -> None:
    """Raise FreePieceError where no tractions that the faces can carry balance the loads on free pieces.

    `surface` are the names of the surfaces (n,) that the contact points lie on. In a `trial` they have lost strength.
    """
    free, law = contact.loose, contact.law
    assert free is not None
    size, length = float(np.abs(loads).sum()), float(contact.weights.sum())
    unbalanced = partial(least_unbalanced, (contact.force, free.along(loads)), size, length)
    whole = np.zeros(len(contact.weights))
    lost, opened = (whole, whole > 0.0) if trial is None else (trial.lost, trial.opened)
    friction, cohesion = law.bound_of(lost)
    held = (np.where(opened, 0.0, strength) for strength in (cohesion, law.tension_of(lost)))
    left, way = unbalanced(friction, *held)
    if left <= UNBALANCED:
        return
    piece, others = _giving_way(contact, free, way)
    moves = _in_words(free.of_piece(piece, way), piece, contact.moving @ way, friction, surface)
    names = f"{piece}" + (f" (and with it {' and '.join(str(other) for other in others)})" if others else "")
    what = (
        f"{names} is free to move: contact does not hold it, {moves}; {100.0 * left:.3g} % of the loads stay out of "
        "balance"
    )
    weaker = (law.breakable & (lost > 0.0)) | (opened & (law.cohesion[0] > 0.0))
    full = *law.bound_of(whole), law.tension[0]
    if weaker.any() and unbalanced(*full)[0] <= UNBALANCED:
        where = " and ".join(sorted({repr(surface[point]) for point in np.flatnonzero(weaker).tolist()}))
        what += f"; {BROKEN.format(where, weaker.sum(), len(weaker))}"
    raise FreePieceError(what, "it needs supports, friction or another load")


def alone(pieces: Sequence[FreePiece]) -> str:
    """What to say of pieces that contact alone holds where it is not solved."""
    named = [str(piece) for piece in pieces[:SHOWN_PIECES]]
    more = f" and {len(pieces) - len(named)} more pieces" if len(pieces) > len(named) else ""
    return (
        f"contact alone holds {', '.join(named)}{more}, perhaps only just: they need supports, friction, or loads that "
        "press their faces together"
    )


def _giving_way(contact: ContactSystem, free: RigidMotions, way: Floats) -> tuple[FreePiece, list[FreePiece]]:
    """The piece at most of whose contact points the faces part or slip, and the others that move."""
    yields = np.hypot(*np.split(contact.moving @ way, 2))
    yields = yields > YIELDS * yields.max(initial=0.0)
    of_pieces = abs((contact.operator @ free.of_pieces).toarray())
    speeds = [float(np.abs(free.of_piece(piece, way)).max()) for piece in free.pieces]
    moving = [piece for piece, speed in zip(free.pieces, speeds, strict=True) if speed > YIELDS * max(speeds)]

    def n_yielding(piece: FreePiece) -> int:
        seen = of_pieces[:, 3 * piece.number : 3 * piece.number + 3].sum(axis=1).reshape(2, -1).sum(axis=0)
        return int(np.sum(yields & (seen > 0.0)))

    first = max(moving, key=n_yielding)
    return first, [piece for piece in moving if piece is not first]


def _in_words(motion: Floats, piece: FreePiece, jumps: Floats, friction: Floats, surface: Sequence[str]) -> str:
    """How a piece moves, and along which surfaces, whose faces make jumps (2 n,).

    Limit analysis lets faces that slip part by friction times their slip.
    """
    if abs(motion[2]) > TURNS * float(np.hypot(*motion[:2])):
        return f"it turns about {piece.about(motion)}"
    (gap, slip), tolerance = np.split(jumps, 2), YIELDS * np.abs(jumps).max(initial=0.0)
    parts = gap > friction * np.abs(slip) + tolerance
    slips = (np.abs(slip) > tolerance) & ~parts
    moves, which = ("slides along", slips) if slips.any() else ("moves off", parts)
    names = sorted({surface[point] for point in np.flatnonzero(which).tolist()})
    return f"it {moves} {' and '.join(repr(name) for name in names)}"


def least_unbalanced(
    motions: tuple[Floats, Floats], size: float, length: float, friction: Floats, cohesion: Floats, tension: Floats
) -> tuple[float, Floats]:
    """The least part of the loads that the faces leave unbalanced, and the motion (l,) along which they give way.

    Of the `motions` these are what tractions do on each (l, 2 n), N/m per Pa, and what loads do (l,) N/m. `size` (N/m)
    is that of the loads, `length` (m) that of all n contact points, with friction (n,), cohesion (n,) Pa and tensile
    strength (n,) Pa. Raises NotSolvedError where linear programming fails.
    """
    from scipy.optimize import linprog  # here: loading it takes a tenth of a second, and few scenes need it
    from scipy.sparse import block_array, csr_array, diags_array, eye_array

    n, (force, pull) = len(friction), motions
    k = len(pull)
    if size == 0.0:
        return 0.0, np.zeros(k)
    pressure = size / length  # Pa, as a measure
    cohesion = np.minimum(cohesion, AMPLE * pressure)
    forces = force * (pressure / size)
    law = [[diags_array(friction), sign * eye_array(n), csr_array((n, 2 * k))] for sign in (1.0, -1.0)]
    found = linprog(
        np.repeat([0.0, 1.0], [2 * n, 2 * k]),
        A_ub=block_array(law, format="csc"),
        b_ub=np.tile(cohesion / pressure, 2),
        A_eq=block_array([[csr_array(forces), eye_array(k), -eye_array(k)]], format="csc"),
        b_eq=pull / size,
        bounds=[(None, most) for most in np.minimum(tension / pressure, AMPLE).tolist()]
        + [(None, None)] * n
        + [(0.0, None)] * (2 * k),
        method="highs",
    )
    if not found.success:
        raise NotSolvedError(f"whether contact can hold all pieces of rock was not found: {found.message}")
    return float(found.fun), np.asarray(found.eqlin.marginals)
