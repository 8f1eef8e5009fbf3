"""Numbers of several cases: what code for one case asks about them. `mbproj.studies.case_arrays` makes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


class Cases:
    """The base of arrays and objects that have a value for each of several cases (`mbproj.studies.case_arrays`)."""

    __slots__ = ()

    def call_each(self, function: Callable[..., Any], args: Sequence[Any], options: Mapping[str, Any]) -> Any:
        """Return the results of a function that is called once for each case."""
        raise NotImplementedError


def cases_in(values: Any) -> Cases | None:
    """Return the first value of several cases among these, also in lists, tuples and mappings; None where none is."""
    if isinstance(values, Cases):
        return values
    if isinstance(values, Mapping):
        values = values.values()
    elif not isinstance(values, (list, tuple)):
        return None
    return next((cases for cases in map(cases_in, values) if cases is not None), None)


def per_case(function: Function) -> Function:
    """Return a function of one case that is called once for each where an argument is of several cases."""

    @wraps(function)
    def called(*args: Any, **options: Any) -> Any:
        cases = cases_in(args) if not options else cases_in((args, options))
        return function(*args, **options) if cases is None else cases.call_each(function, args, options)

    return called  # type: ignore[return-value]
