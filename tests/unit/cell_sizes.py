"""A cover that takes its cells for others than they are: rules that go by the sizes of cells see these alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crackgrow.cover.cell_lengths import sizes_beside
from crackgrow.cover.cover import Cover


def with_sizes(cover: Cover, sizes: np.ndarray | float) -> Cover:
    """The cover with these sides of cells, spacings: one by one for all elements (n,), or one for all."""
    sizes = np.array(np.broadcast_to(sizes, cover.elements.n))
    surfaces = tuple(replace(surface, sizes=sizes_beside(surface.edges, sizes)) for surface in cover.surfaces)
    return replace(cover, elements=replace(cover.elements, size=sizes), surfaces=surfaces)
