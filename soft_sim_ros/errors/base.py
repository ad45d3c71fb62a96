"""The base of all errors of this package."""

from __future__ import annotations


class SoftSimError(Exception):
    """Base of all errors of this package."""
