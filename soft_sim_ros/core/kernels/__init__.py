"""Compiled inner loops (numba). Plain functions of arrays; no Python object in any of them."""
