"""Constraint primitives (Haug 1989, ch. 9): a value, its gradient and its curvature, each defined once."""
