"""Primitives of curves: what follows one in a plane or in space, and two that touch."""
