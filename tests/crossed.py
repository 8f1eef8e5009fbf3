"""Crosses of parameters: the default run has a few of the cases, in which each value meets each; the rest is `full`."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from itertools import combinations, product
from typing import Any

import pytest
from hypothesis import given, settings

Case = tuple[Hashable, ...]
FULL = pytest.mark.full
ParameterSet = type(pytest.param())


def full(*values: Any, **more: Any) -> Any:
    """Values of a `parametrize`, or one `pytest.param`, that are `full`."""
    if isinstance(values[0], ParameterSet):
        own, marks, name = values[0]
        return pytest.param(*own, marks=(*marks, FULL), id=name)
    return pytest.param(*values, marks=FULL, **more)


def some(values: Iterable[Any], every: int, first: int = 0) -> list[Any]:
    """Each `every`-th value is in the default run, from the one at `first`."""
    return [value if at % every == first else full(_set(value)) for at, value in enumerate(values)]


def where(in_default: Callable[..., bool], values: Iterable[Any]) -> list[Any]:
    """The default run has the values of which this holds."""
    return [value if in_default(*_set(value).values) else full(_set(value)) for value in values]


def once(*axes: Iterable[Any]) -> list[Any]:
    """All combinations of the axes' values; in the default run each value is there once."""
    return _combined([[_set(value) for value in axis] for axis in axes], 1, ())


def crossed(names: str, *axes: Iterable[Any], together: int = 2, dear: Iterable[Any] = ()) -> pytest.MarkDecorator:
    """Parametrizes with all combinations of the axes' values, which may be `pytest.param`.

    Those of the default run are a `cover`; the rest is `full`. `together`: so many values meet there, with 1 each is
    there once. `dear`: values that take long, such as the formulation in NumPy, and need be there only once.
    """
    return pytest.mark.parametrize(names, _combined([list(axis) for axis in axes], together, dear))


def _combined(columns: Sequence[Sequence[Any]], together: int, dear: Iterable[Any]) -> list[Any]:
    cases = list(product(*map(range, map(len, columns))))
    rare = [
        (axis, at)
        for axis, column in enumerate(columns)
        for at, value in enumerate(column)
        if any(_values(value)[0] == each for each in dear)
    ]
    keep = cover(cases, together, rare)
    return [_joined([column[at] for column, at in zip(columns, case, strict=True)], case in keep) for case in cases]


def cover(cases: Iterable[Case], together: int = 2, rare: Iterable[tuple[int, Hashable]] = ()) -> set[Case]:
    """A few of the cases, in which so many values stand beside each other wherever some case has them: greedily the
    case with the most that is new, and the first of these. A value in `rare`, as (axis, value), stands there once."""
    rare, meets = set(rare), {}
    for case in cases:
        values = list(enumerate(case))
        meets[case] = {(value,) for value in values}
        meets[case] |= {met for met in combinations(values, together) if rare.isdisjoint(met)}
    left: set[Any] = set().union(*meets.values())
    keep = set()
    while left:
        best = max(meets, key=lambda case: (len(meets[case] & left), rare.isdisjoint(enumerate(case))))
        left -= meets[best]
        keep.add(best)
    return keep


def _values(value: Any) -> Sequence[Any]:
    """Of a `pytest.param`, or of one value."""
    return value.values if isinstance(value, ParameterSet) else (value,)


def _set(value: Any) -> Any:
    """What `pytest.param` makes of a value that `parametrize` takes, a tuple for several parameters."""
    if isinstance(value, ParameterSet):
        return value
    return pytest.param(*value) if isinstance(value, tuple) else pytest.param(value)


def _joined(case: Sequence[Any], kept: bool) -> Any:
    """One case with the values, the marks and the names of its parts."""
    marks = [mark for part in case for mark in getattr(part, "marks", ())]
    named = [getattr(part, "id", None) or "-".join(map(str, _values(part))) for part in case]
    name = "-".join(named) if any(getattr(part, "id", None) for part in case) else None
    return pytest.param(
        *(value for part in case for value in _values(part)), marks=marks if kept else [*marks, FULL], id=name
    )


def campaign(*strategies: Any, few: int, many: int) -> Callable[[Callable[..., None]], Callable[[int], None]]:
    """Makes a test that tries what these strategies draw: `few` examples in the default run, `many` in a `full` case.
    They are the same in each run."""

    def decorated(check: Callable[..., None]) -> Callable[[int], None]:
        def test(examples: int) -> None:
            settings(derandomize=True, deadline=None, max_examples=examples)(given(*strategies)(check))()

        test.__doc__ = check.__doc__
        return pytest.mark.parametrize("examples", [few, full(many)])(test)

    return decorated
