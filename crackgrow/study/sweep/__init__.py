"""Sweeps: one run for each combination of parameters, side by side on a Dask cluster, all of it in one table."""
