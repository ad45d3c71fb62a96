"""SE(3), dual numbers and small matrices, in space and in a plane."""
