"""Linear models x' = A x + B u, y = C x + D u of a mechanism at a reference, with names and units."""
