"""Compiles a scene to the System (arrays) and to the Guess from which assembly starts."""

from mbproj.model.compile.guess import Guess, initial_guess
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import Names, System
from mbproj.registry import lazily

__all__ = ["Guess", "Names", "PrimitiveSet", "System", "initial_guess"]

__getattr__ = lazily(
    __name__,
    {
        "compile.elements.arrays": "with_elements",
        "compile.stops": "resistance",
        "contacts": "Contacts in_contact",
        "euler_parameters": "matrix_E matrix_L rotation_matrix",
        "planar": "NotPlanar Plane obstacle_in_plane planar_reduction",
        "primitive_set": "Binding bind bindings",
    },
)
