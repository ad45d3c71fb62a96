"""The version, for whatever says it: setup.py, recordings, pages."""

__version__ = "0.1.0"
