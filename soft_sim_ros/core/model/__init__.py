"""A compiled scene: immutable arrays, and the segments they are made of."""
