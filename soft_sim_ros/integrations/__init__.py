"""What other programs find this package by: each is imported by that program only."""
