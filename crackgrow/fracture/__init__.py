"""Fracture: stress at a tip, stress intensity, growth criteria, the advance of cracks."""
