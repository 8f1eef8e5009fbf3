"""Which values of a test's parameters the default run has; the full run has all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import product
from typing import Any

import pytest

ParameterSet = type(pytest.param(None))


def _set(value: Any) -> Any:
    """What `pytest.param` makes of a value that `parametrize` takes, a tuple for several parameters."""
    if isinstance(value, ParameterSet):
        return value
    return pytest.param(*value) if isinstance(value, tuple) else pytest.param(value)


def full(value: Any) -> Any:
    """A value that the full run alone has."""
    values, marks, name = _set(value)
    return pytest.param(*values, marks=(*marks, pytest.mark.full), id=name)


def some(values: Iterable[Any], every: int, first: int = 0) -> list[Any]:
    """Each `every`-th value is in the default run, from the one at `first`."""
    return [value if at % every == first else full(value) for at, value in enumerate(values)]


def where(in_default: Callable[..., bool], values: Iterable[Any]) -> list[Any]:
    """The default run has the values of which this holds."""
    return [value if in_default(*_set(value).values) else full(value) for value in values]


def once(*axes: Sequence[Any]) -> list[Any]:
    """All combinations; in the default run as many as the longest axis has values, by which each value occurs."""
    longest = max(map(len, axes))
    kept = {tuple(at % len(axis) for axis in axes) for at in range(longest)}
    return _crossed(axes, kept)


def _crossed(axes: Sequence[Sequence[Any]], kept: set[tuple[int, ...]]) -> list[Any]:
    found = []
    for place in product(*(range(len(axis)) for axis in axes)):
        sets = [_set(axis[at]) for axis, at in zip(axes, place, strict=True)]
        values, marks = ([each for one in sets for each in one[part]] for part in (0, 1))
        crossed = pytest.param(*values, marks=marks)
        found.append(crossed if place in kept else full(crossed))
    return found
