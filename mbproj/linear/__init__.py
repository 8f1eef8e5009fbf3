"""Equilibria, modes and linear models of a mechanism, on the tangent space of the constraints."""
