"""Sweeps: one run for each combination of parameters, side by side, all of it in one table."""
