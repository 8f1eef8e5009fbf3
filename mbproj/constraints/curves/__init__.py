"""Primitives of curves: a point that follows a curve in a plane or in space, and two curves that touch."""
