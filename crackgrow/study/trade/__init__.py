"""What accuracy costs: a scene over a grid of settings, errors against a finer run, and time."""
