"""Compiles elements, signals and controllers to arrays, and resolves the names in their functions."""

from mbproj.model.compile.elements.arrays import with_elements

__all__ = ["with_elements"]
