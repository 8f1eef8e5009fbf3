"""Where a mechanism rests and how it rings: equilibrium, modes, linear models, on the tangent space of the constraints.

Everything here takes its derivatives from `mbproj.dynamics.derivatives`. SciPy is imported where it is needed.
"""
