"""Mesh size field, companion mesh, error estimates and marking: which cells a step is solved on, and its errors."""
