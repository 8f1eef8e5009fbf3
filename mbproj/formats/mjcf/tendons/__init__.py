"""Tendons of an MJCF model: their paths, the coordinates of a scene that measure them, the forces along them."""
