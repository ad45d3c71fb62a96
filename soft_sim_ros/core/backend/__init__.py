"""Compiled code: just in time, kept on disk, made by several processes; structs by reference."""
