"""Reduces linear equations: to axes in which they are constant, to the tangent space, and to motions without slip."""
