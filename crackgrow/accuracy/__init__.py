"""Size field, companion mesh and errors: which cells a step is solved on, and what it is known to."""
