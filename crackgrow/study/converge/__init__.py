"""Whether a case's own setting is good enough: the case on three settings, what they tend to, and what each misses."""
