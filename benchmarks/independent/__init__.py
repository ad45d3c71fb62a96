"""Formulations that share nothing with the package, to check the references against."""
