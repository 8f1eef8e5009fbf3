"""From the scene to the System (arrays) and the Guess that assembly starts from."""

from mbproj.model.compile.guess import Guess, initial_guess
from mbproj.model.compile.mechanism import compile_system
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import Names, System

__all__ = ["Guess", "Names", "PrimitiveSet", "System", "compile_system", "initial_guess"]
