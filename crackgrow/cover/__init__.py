"""The cover: lattice, mathematical patches, manifold elements, physical patches and the numbering of functions."""
