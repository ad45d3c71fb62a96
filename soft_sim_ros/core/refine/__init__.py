"""Finer numerics of a scene, and how far off the coarser ones are in space."""
