"""Numerics chosen for a tolerance, and runs that know their error."""
