"""What the system lets this process have. Nothing here loads what takes long."""

from __future__ import annotations

import math


def allowed(what: str) -> float:
    """The limit RLIMIT_`what` of this process; infinity where there is none, or the system knows no such limits."""
    try:
        import resource  # of POSIX alone
    except ImportError:
        return math.inf
    limit, _ = resource.getrlimit(getattr(resource, f"RLIMIT_{what}"))
    return math.inf if limit == resource.RLIM_INFINITY else limit
