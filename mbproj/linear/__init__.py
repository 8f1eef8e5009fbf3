"""Equilibria, modes and linear models of a mechanism, on the tangent space of the constraints.

All derivatives come from `mbproj.dynamics.derivatives`. SciPy is imported where it is needed.
"""
