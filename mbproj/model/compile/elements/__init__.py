"""Elements, signals and controllers as arrays, and what their functions name."""

from mbproj.model.compile.elements.arrays import with_elements

__all__ = ["with_elements"]
