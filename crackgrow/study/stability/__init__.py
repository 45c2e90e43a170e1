"""Scenes at the extremes: what is compared along each axis, and what came out."""
