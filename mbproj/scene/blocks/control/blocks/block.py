"""What a block of `signals` is, and what it becomes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TypeAlias

from mbproj.dataclass import dataclass
from mbproj.elements.controlled import Controller, ScalarState, Signal
from mbproj.functions.program import Program
from mbproj.scene.blocks.control.expression import named
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.expressions.units import BARE, Dimension, describe
from mbproj.scene.fields.reading import Unfit

#: An expression and the dimension that its numbers give it.
Given: TypeAlias = "tuple[Program, Dimension | None]"


@dataclass(frozen=True)
class Expanded:
    """The signals, states and controllers that stand for a block."""

    signals: tuple[Signal, ...]
    states: tuple[ScalarState, ...] = ()
    controllers: tuple[Controller, ...] = ()


class Block(ABC):
    """A signal with states of its own."""

    @abstractmethod
    def expanded(self, name: str, unit: str | None) -> Expanded:
        """What it becomes under its name, with the unit of its value where that is given. Raises Unfit."""


def unit_like(of: Given, unit: str | None, *values: Value | None) -> str:
    """The unit of what follows `of`: as given, or that of numbers. Raises Unfit where these are of another one."""
    found = None if of[1] == BARE else of[1]
    for value in values:
        if value is None or value.dimension in (None, BARE):
            continue
        if found is not None and value.dimension is not None and not found.agrees(value.dimension):
            raise Unfit(f"follows {describe(found)}, and a number of it is {describe(value.dimension)}")
        found = found or value.dimension
    return named(found) if unit is None else unit


def number_of(value: Value | None, otherwise: float) -> float:
    """The number of a value that may be left out."""
    return otherwise if value is None else value.number
