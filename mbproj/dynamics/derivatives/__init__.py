"""Exact derivatives of constraints, forces and inertia in tangent coordinates, (δr global, δθ in body axes) of each
body. Equilibrium, modes, linear models and implicit steps use them."""
