"""Studies: what is learnt from several runs, such as how far apart their crack paths are."""
