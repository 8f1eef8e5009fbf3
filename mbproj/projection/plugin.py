"""`register_projection`: adds a user's projection method, which runs in the full formulation and in all studies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem
from mbproj.plugins import blamed
from mbproj.projection.methods import Method, Projection
from mbproj.registry import PROJECTIONS, ProjectionEntry

#: The options that a scene may give to a method.
OPTIONS = ("alpha", "gains")


def register_projection(
    name: str, method: type[Method], *, summary: str, equations: str = "", options: Sequence[str] = ()
) -> None:
    """Add a projection method to those that a scene may name.

    `method` is a class derived from `Projection`, made with its `options` as arguments, which are among "alpha" and
    "gains". `summary` is the line that describes it, `equations` its source. Raises InputError where the name is taken
    or not a valid one, and TypeError where `method` is no such class.
    """
    if not (isinstance(method, type) and issubclass(method, Method)):
        raise TypeError(f"a projection method is a class derived from mbproj.Projection, found {method!r}")
    missing = sorted(getattr(method, "__abstractmethods__", ()))
    if missing:
        raise TypeError(f"{method.__name__} has no method '{missing[0]}'")
    for option in options:
        if option not in OPTIONS:
            raise InputError(Problem(f"a method has no option '{option}'", hint=f"options are: {', '.join(OPTIONS)}"))
    made = _blamed(name, method)
    entry = ProjectionEntry("", equations, summary, tuple(options), not method.stabilises, factory=made)
    PROJECTIONS.add(name, entry, method)


def _real(symbol: str, value: object, shape: tuple[int, ...]) -> Array:
    """Return the numbers that a formula returned as an array. Raises TypeError or ValueError where they are not real
    numbers in this shape: a cast would drop imaginary parts."""
    numbers = np.asarray(value)
    if numbers.shape != shape:
        raise ValueError(f"{symbol} has the shape {numbers.shape}, not {shape}")
    if numbers.dtype.kind not in "fiu":
        raise TypeError(f"{symbol} has numbers of the type {numbers.dtype}, which are not real")
    return numbers.astype(float, copy=False)


def _blamed(name: str, method: type[Method]) -> Callable[..., Method]:
    """Return a factory of the method; errors of the method name it. LinAlgError means that a correction does not
    exist."""

    def guarded(formula: str) -> Callable[..., Any]:
        def call(self: Any, *given: Array) -> Any:
            with blamed(f"'{formula}' of projection method '{name}'", np.linalg.LinAlgError):
                value = getattr(method, formula)(self, *given)
                if formula == "correction":
                    return _real("Δ", value, (given[1].shape[1],))
                if formula == "stabilised":
                    return _real("γ", value, given[0].shape)
                if not (value is None or isinstance(value, str)):
                    raise TypeError(f"it returns {value!r}, which is no text and not None")
                return value

        return call

    formulas = ("correction", "refusal") if issubclass(method, Projection) else ("stabilised",)
    own: type[Method] = type(method.__name__, (method,), {formula: guarded(formula) for formula in formulas})

    def make(**options: Any) -> Method:
        with blamed(f"projection method '{name}'"):
            return own(**options)

    return make
