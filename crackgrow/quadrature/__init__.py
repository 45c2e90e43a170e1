"""Quadrature: rules on lines, squares and triangles, and the points of all manifold elements and edges."""
