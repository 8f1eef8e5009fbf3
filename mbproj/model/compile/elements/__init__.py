"""Compiles elements, signals and controllers to arrays, and resolves the names in their functions."""
