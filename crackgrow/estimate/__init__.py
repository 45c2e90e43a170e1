"""The error of a solution in the energy norm, as it estimates itself."""
