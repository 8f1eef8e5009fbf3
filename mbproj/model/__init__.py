"""Compiles a scene to the System (arrays) and to the Guess from which assembly starts."""

from mbproj.model.compile.guess import Guess, initial_guess
from mbproj.model.compile.mechanism import compile_system
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import Names, System

__all__ = ["Guess", "Names", "PrimitiveSet", "System", "compile_system", "initial_guess"]
