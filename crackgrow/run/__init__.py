"""Running a case: one step, the growth loop, and what they hand out."""
