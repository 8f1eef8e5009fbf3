"""Tendons of an MJCF model: their paths, the coordinates of a scene that measure them, what acts along them."""
