"""Equilibria and their branches, modes, linear systems, inverse problems, energy structure."""
