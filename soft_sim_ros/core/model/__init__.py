"""What a compiled scene is: immutable arrays, and the segments they are made of."""
