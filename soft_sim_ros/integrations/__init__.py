"""What other programs find this package by; each is imported only by the program that asks for it."""
