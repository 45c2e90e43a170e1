"""The contact law of every point, and what points remember of earlier load increments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Floats


@dataclass(frozen=True, slots=True, eq=False)
class ContactLaw:
    """Law of every contact point."""

    friction: Floats  # (n,)
    cohesion: Floats  # (n,) Pa
    compliance: Floats  # (n,) m/Pa: 1/k, zero for rigid contact
    residual_friction: Floats | None = None  # (n,) of broken points; None: as before
    kept: Bools | None = None  # (n,) whether broken points that are closed cohere; None: they don't
    dilation: Floats | None = None  # (n,) tan(dilation angle); None: zero

    def bound_of(self, broken: Bools) -> tuple[Floats, Floats]:
        """Friction (n,) and cohesion (n,) where some points are `broken` (n,)."""
        friction = self.friction if self.residual_friction is None else self.residual_friction
        cohesion = np.zeros(len(broken)) if self.kept is None else np.where(self.kept, self.cohesion, 0.0)
        return np.where(broken, friction, self.friction), np.where(broken, cohesion, self.cohesion)

    @property
    def dilating(self) -> Floats:
        """Tangents (n,) of the dilation angles."""
        return np.zeros(len(self.friction)) if self.dilation is None else self.dilation

    def opening(self, slip: Floats) -> Floats:
        """What slip (n,) m, less its elastic part, opens by dilation, m."""
        return np.asarray(self.dilating * np.abs(slip))

    @property
    def breakable(self) -> Bools:
        """Which points (n,) have something to lose."""
        n = len(self.friction)
        friction, cohesion = self.bound_of(np.ones(n, dtype=bool))
        return np.asarray((friction < self.friction) | (cohesion < self.cohesion))


@dataclass(frozen=True, slots=True, eq=False)
class ContactMemory:
    """What contact points keep from one increment to the next."""

    slip: Floats  # (n,) m, less its elastic part
    broken: Bools  # (n,) has slipped or opened
    closed: Bools | None = None  # (n,) is not open; None: where it is not broken

    def coheres(self, law: ContactLaw) -> Bools:
        """Which points (n,) the bond holds."""
        _, cohesion = law.bound_of(self.broken)
        return np.asarray((cohesion > 0.0) & (~self.broken if self.closed is None else self.closed))

    @classmethod
    def fresh(cls, n: int) -> ContactMemory:
        """Memory of n points that nothing has happened to."""
        return cls(np.zeros(n), np.zeros(n, dtype=bool))
