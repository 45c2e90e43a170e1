"""The contact problem as some of its points see it, while all others stay on their branches of the law.

Let the equations of an active set be fulfilled but for residuals r of those of the points S,

    p = p0 + P r,    du_S = du0 + D r,    D = -A_S P.

So the points S are in a contact problem of their own, with the compliance -D P_S^-1, a Schur complement. Where pieces
of rock are seen by the points S alone P_S has as many singular values that are zero, and their motions remain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.contact.equations import ActiveEquations
from crackgrow.contact.loose import UNSEEN, balancing, split
from crackgrow.contact.problem import ContactProblem, ContactSolution, Motions


@dataclass(frozen=True, slots=True, eq=False)
class Condensed:
    """A contact problem of some points of another one, whose rows they have there, and how the others follow."""

    problem: ContactProblem | None  # None: the others, on their branches, leave no compliance that is positive
    at: Ints  # (2 s,)
    unknowns: Floats  # (2 n + l,) of the other problem where its equations are fulfilled
    sensitivity: Floats  # (2 n + l, 2 s) P: their derivatives by r
    jump: Floats  # (2 s,) m: du0
    jumps: Floats  # (2 s, 2 s) D

    @classmethod
    def onto(
        cls, equations: ActiveEquations, unknowns: Floats, points: Bools, before: Condensed | None = None
    ) -> Condensed | None:
        """The problem of `points` (n,), while others stay on the branches of the equations, which have some `unknowns`.

        `before` is that of some of these points. None where the equations are singular.
        """
        whole, m = equations.problem, equations.problem.free.size
        at = np.flatnonzero(np.tile(points, 2))
        if equations.singular:
            return None
        known = np.isin(at, before.at) if before is not None else np.zeros(len(at), dtype=bool)
        sensitivity = np.empty((len(unknowns), len(at)))
        sensitivity[:, ~known] = equations.sensitivity(at[~known])
        if before is not None:
            sensitivity[:, known] = before.sensitivity
        du, jumps = whole.jump(unknowns)[at], -whole.compliance[at] @ sensitivity[:m]
        motions = None
        if whole.motions is not None:
            jumps += whole.motions.jump[at] @ sensitivity[m:]
            others = ~np.isin(equations.branches.rows, at)
            kept = split(equations.branches.of_motions(whole.motions.jump)[others])[1]
            force = kept @ whole.motions.force[:, at]
            motions = Motions(whole.motions.jump[at] @ kept.T, force, force @ unknowns[at]) if len(kept) else None
        left, sizes, right = np.linalg.svd(sensitivity[at])
        rank = len(at) - (0 if motions is None else len(motions.pull))
        if int((sizes > UNSEEN * sizes[0]).sum()) != rank:
            return cls(None, at, unknowns, sensitivity, du, jumps)
        compliance = -((jumps @ right[:rank].T) / sizes[:rank]) @ left[:, :rank].T
        if motions is not None:  # what the motions do on others, too, and springs along them, as soft as the rock
            force = (motions.force @ left[:, rank:]) @ left[:, rank:].T
            motions = Motions(motions.jump, force, force @ unknowns[at])
            compliance += motions.jump @ (float(np.median(whole.scale[at])) * balancing(motions)) @ force
        some = np.flatnonzero(points)
        laws = whole.friction[some], whole.cohesion[some], whole.dilation[some], whole.slipped[some]
        definite = bool((compliance.diagonal() > 0.0).all())
        free = du + compliance @ unknowns[at]
        small = ContactProblem(compliance, free, *laws, motions) if definite else None
        return cls(small, at, unknowns, sensitivity, du, jumps)

    def most_sensitive(self, points: Bools) -> Ints:
        """As many more as there are `points` (n,): those whose tractions are most sensitive to their residuals."""
        changes = np.abs(self.sensitivity[: 2 * len(points)]).max(axis=1).reshape(2, -1).max(axis=0)
        return np.argsort(np.where(points, -1.0, changes))[: -1 - points.sum() : -1]

    def expanded(self, found: ContactSolution) -> Floats:
        """All unknowns (2 n + l,) of the other problem with a solution of this one."""
        assert self.problem is not None
        p, scale = found.traction, self.problem.scale
        more = np.concatenate([p - self.unknowns[self.at], (self.problem.jump(found.unknowns) - self.jump) / scale])
        both = np.vstack([self.sensitivity[self.at], self.jumps / scale[:, None]])
        x = self.unknowns + self.sensitivity @ np.linalg.lstsq(both, more)[0]
        x[self.at] = p
        return np.asarray(x)
