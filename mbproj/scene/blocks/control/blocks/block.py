"""Blocks: signals with states of their own, which the reader replaces by plain signals, states and controllers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TypeAlias

from mbproj.dataclass import dataclass
from mbproj.elements.controlled import Controller, ScalarState, Signal
from mbproj.functions.program import Program
from mbproj.scene.blocks.control.expression import unit_name
from mbproj.scene.expressions.dimensions import Found, describe
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.expressions.units import BARE
from mbproj.scene.fields.reading import Unfit

#: An expression and its dimension.
Given: TypeAlias = "tuple[Program, Found]"


@dataclass(frozen=True)
class Expanded:
    """The signals, states and controllers that replace a block."""

    signals: tuple[Signal, ...]
    states: tuple[ScalarState, ...] = ()
    controllers: tuple[Controller, ...] = ()


class ControlBlock(ABC):
    """A signal with states of its own."""

    @abstractmethod
    def expanded(self, name: str, unit: str | None) -> Expanded:
        """The signals, states and controllers that replace the block `name`. `unit` is the unit of its value, where the
        scene gives that. Raises Unfit for units that do not fit each other."""


def unit_like(of: Given, unit: str | None, *values: Value | None) -> str:
    """The unit of a block's value that has the dimension of its input `of`: `unit` where it is given, else the SI unit
    of that dimension, or of the `values`. Raises Unfit where the dimensions differ."""
    dimension = None if of[1].certain == BARE else of[1].certain
    for value in values:
        if value is None or value.dimension in (None, BARE):
            continue
        if dimension is not None and value.dimension is not None and not dimension.agrees(value.dimension):
            raise Unfit(f"has an input that is {describe(dimension)}, and a number that is {describe(value.dimension)}")
        dimension = dimension or value.dimension
    return unit_name(dimension) if unit is None else unit


def number_of(value: Value | None, otherwise: float) -> float:
    """The number of a value, or `otherwise` where it is left out."""
    return otherwise if value is None else value.number
