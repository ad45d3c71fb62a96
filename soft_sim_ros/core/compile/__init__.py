"""From a scene to its model: bodies, elements, loads and ports as segments and arrays."""
