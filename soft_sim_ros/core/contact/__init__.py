"""Contact of bodies with shapes: distances, the law of the force, its exact derivative."""
