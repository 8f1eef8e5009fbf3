"""Shapes of bodies with their mass and inertia, and appearances. A shape is an entry of `shapes.SHAPES`."""
