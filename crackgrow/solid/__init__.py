"""The solid: elasticity, stiffness, loads, supports, the linear solve, and stress at points."""
