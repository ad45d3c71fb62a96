"""What all errors of this package have in common."""

from __future__ import annotations


class SoftSimError(Exception):
    """Base of all errors of this package."""
