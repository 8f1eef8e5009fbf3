"""Exact derivatives of constraints, forces and inertia in tangent coordinates, (δr global, δθ in body axes) of each
body: what equilibrium, modes, linear models and implicit steps share."""
