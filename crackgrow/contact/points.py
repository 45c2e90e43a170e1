"""The rock as n contact points see it, whatever the loads and the law: the compliance A and l rigid motions.

It is condensed to the compliance between all points where these are few; see `sparse_points` where they are many.

Where supports hold loose pieces to be solved for single tractions, and loads, turn them far: of A and of the free jumps
all is taken off that is a motion, or works on one, and springs as soft as the rock are put in its place. Digits would
be lost in what they turn.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.errors import NotSolvedError

ROWS_AT_ONCE = 256
"""Rows of a large compliance that are worked on together."""

UNSEEN: Final = 1e-12  # motions that contact points see by less, relative to what they see best, are not seen


class RockPoints:
    """The rock as n contact points see it."""

    jump: Floats  # (2 n, l) B: gap and slip in each of the rigid motions
    force: Floats  # (l, 2 n) F, N/m per Pa: what tractions do on each of them
    weights: Floats  # (2 n,) m: W

    @property
    def compliance(self) -> Floats:
        """A (2 n, 2 n) m/Pa."""
        raise NotImplementedError

    @property
    def scale(self) -> Floats:
        """(2 n,) m/Pa: the diagonal of A or an estimate of it, which weighs jumps against tractions."""
        raise NotImplementedError

    def softer(self, softness: Floats) -> RockPoints:
        """The points with so much more elastic contact (2 n,) m/Pa."""
        raise NotImplementedError

    def release(self) -> None:
        """Let go of what is large, and can be made again."""
        for name in ("settled", "stuck", "tied"):
            self.__dict__.pop(name, None)

    @property
    def reach(self) -> Floats:
        """(2 n,) m/Pa: the sum of every row's absolute values, as far as it is known."""
        raise NotImplementedError

    @cached_property
    def balance(self) -> Floats:
        """Amplitudes (l, l) of motions whose jumps, as tractions, are a unit of force on each; pseudoinverse."""
        return np.asarray(np.linalg.pinv(self.force @ self.jump, rcond=UNSEEN, hermitian=True))


@dataclass(frozen=True, eq=False)
class CondensedPoints(RockPoints):
    """Points on rock that is condensed to the compliance between all of them.

    Arrays are seen read-only, not copied. Raises NotSolvedError for a value that is not finite and a diagonal entry of
    the compliance that is not positive.
    """

    matrix: Floats  # (2 n, 2 n) m/Pa: A; need not be symmetric
    jump: Floats = field(default_factory=lambda: np.zeros((0, 0)))  # left out: no motions
    force: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    weights: Floats = field(default_factory=lambda: np.zeros(0))  # left out: one

    def __post_init__(self) -> None:
        m = len(self.matrix)
        object.__setattr__(self, "matrix", read_only("compliance", self.matrix))
        if self.jump.shape == (0, 0):
            object.__setattr__(self, "jump", np.zeros((m, 0)))
            object.__setattr__(self, "force", np.zeros((0, m)))
        if not self.weights.size:
            object.__setattr__(self, "weights", np.ones(m))
        diagonal = self.matrix.diagonal()
        if not np.all(diagonal > 0.0):
            point = int(np.flatnonzero(~(diagonal > 0.0))[0])
            raise NotSolvedError(
                f"contact compliance diagonal: entry {point} is {diagonal[point]:.6g}, must be positive: the system is "
                "too ill conditioned, for cracks, tips or outlines too close to each other"
            )

    @property
    def compliance(self) -> Floats:
        """A (2 n, 2 n) m/Pa."""
        return self.matrix

    @cached_property
    def scale(self) -> Floats:
        """(2 n,) m/Pa: the diagonal of A."""
        return self.matrix.diagonal()

    @cached_property
    def reach(self) -> Floats:
        """(2 n,) m/Pa: the sum of every row's absolute values."""
        return absolute_product(self.matrix, np.ones(len(self.matrix)))

    def softer(self, softness: Floats) -> CondensedPoints:
        """The points with so much more elastic contact (2 n,) m/Pa."""
        compliance = self.compliance.copy()
        compliance[np.diag_indices_from(compliance)] += softness
        return CondensedPoints(compliance, self.jump, self.force, self.weights)

    @cached_property
    def settled(self) -> tuple[CondensedPoints, Floats, Floats]:
        """The points without what supports do that hold loose pieces to be solved for.

        And what tractions move more without them (l, 2 n), and what pulls move less (2 n, l).
        """
        B, F, A, balance = self.jump, self.force, self.compliance, self.balance
        moving, pushed = balance @ (F @ A), (A @ B) @ balance
        pushed -= B @ (moving @ B @ balance)
        softness = float(np.median(A.diagonal() - (B * moving.T).sum(axis=1) - (pushed * F.T).sum(axis=1)))
        moving -= softness * balance @ F  # with F = B' W the projection is one of symmetric A W^-1
        moves = np.hstack([B, pushed]) @ np.vstack([moving, F])
        np.subtract(A, moves, out=moves)  # it is large
        return CondensedPoints(moves, B, F, self.weights), moving, pushed


def absolute_product(A: Floats, x: Floats) -> Floats:
    """(n,) |A| x of A (n, m), in blocks of rows: large ones are never held twice."""
    found = np.empty(len(A))
    for start in range(0, len(A), ROWS_AT_ONCE):
        some = slice(start, start + ROWS_AT_ONCE)
        found[some] = np.abs(A[some]) @ x
    return found


def read_only(name: str, value: Floats) -> Floats:
    """The array, that can't be changed. Raises NotSolvedError where it is not finite."""
    view = np.ascontiguousarray(value, dtype=np.float64).view()
    if not np.isfinite(view).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(view))[0])
        raise NotSolvedError(
            f"contact {name}: entry {place} is {view[place]}, must be finite: check supports and loads"
        )
    view.flags.writeable = False
    return view
