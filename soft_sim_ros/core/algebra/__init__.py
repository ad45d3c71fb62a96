"""SE(3), dual numbers and small matrices, and what of them moves in a plane."""
