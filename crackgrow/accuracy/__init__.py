"""Companion mesh, error estimates and marking: the errors of a step, and which cells it is refined at."""
