"""How much of the loads acts."""

from __future__ import annotations

from typing import NamedTuple


class LoadLevel(NamedTuple):
    """A place on the way of the loads."""

    factor: float  # of the loads that are scaled
    holding: float = 1.0  # how much of those that are held acts

    def towards(self, last: LoadLevel, share: float) -> LoadLevel:
        """The place after a share of the way to the `last` one, which is the last one itself after all of it."""
        return last if share == 1.0 else LoadLevel(*(a + share * (b - a) for a, b in zip(self, last, strict=True)))
