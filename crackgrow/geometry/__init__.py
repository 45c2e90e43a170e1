"""Plane geometry: polylines and the planar arrangement of lines that cuts the lattice."""
