"""Plug-ins for other programs; each is imported by that program only."""
