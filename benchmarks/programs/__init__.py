"""Adapters: one program each, from a case and settings to the path of the tip and its cost."""
