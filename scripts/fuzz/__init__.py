"""Command lines, scenes and surroundings that nobody means, and what mbproj makes of them."""
