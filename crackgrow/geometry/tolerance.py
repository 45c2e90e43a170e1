"""The tolerances of plane geometry, in lattice spacings, and of what is relative to a size.

All cutting happens in lattice units (the lattice lines are integers), so that size and units never matter.
"""

GRID = 2.0**-30
"""Every vertex of the arrangement is a whole multiple of this: about 1e-9 spacings, exact for lattice lines."""

ON_LINE = 4 * GRID
"""Two things closer than this are the same place."""

TOUCH = 1e-6
"""A tile closer to a line than this is cut together with it, so that neighbours share their vertices."""

SAME_PLACE = 1e-6
"""Places on a surface or its body's rim closer than this are one: vertices are rounded, and lengths added up."""

SAME_PART = 1e-9
"""Parts of a length: what is closer is one place, whatever the length is."""

ROUND_OFF = 1e-12
"""Parts of a size: what sums of many numbers, or a dense solve, may be off by."""
