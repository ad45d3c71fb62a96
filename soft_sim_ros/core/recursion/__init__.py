"""Motion outwards, wrenches inwards; the exact derivative of both; elimination at linear cost."""
