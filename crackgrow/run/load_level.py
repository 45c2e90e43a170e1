"""How much of the loads acts."""

from __future__ import annotations

from typing import NamedTuple


class LoadLevel(NamedTuple):
    """A place on the way of the loads."""

    factor: float  # of the loads that are scaled
    holding: float = 1.0  # how much of those that are held acts
