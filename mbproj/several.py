"""Numbers of several cases, for modules that must not import arrays."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


class Several:
    """The base of `mbproj.lanes.Lanes`, which are numbers of several cases."""

    __slots__ = ()


def is_several(value: Any) -> bool:
    """Return whether a value is of several cases."""
    return isinstance(value, Several)


def are_several(values: Any) -> bool:
    """Return whether values, or some of those in a sequence, are of several cases."""
    return isinstance(values, Several) or (isinstance(values, (list, tuple)) and any(map(are_several, values)))


def same_bits(value: Any, other: Any) -> bool:
    """Return whether two values are equal, and 0 of the same sign: atan2(-0.0, -1) is not atan2(0.0, -1)."""
    same: bool = value == other
    return same and (not isinstance(value, float) or math.copysign(1.0, value) == math.copysign(1.0, other))


def finite_value(compute: Callable[..., Any], values: Sequence[Any]) -> Any:
    """Return compute(*values) of arithmetic for all cases at once; None where a result is not finite."""
    import numpy as np

    with np.errstate(all="ignore"):
        value = compute(*values)
        return value if value - value == 0.0 else None


def each_case(function: Function) -> Function:
    """Return a function of one case that is called for each where it is given numbers of several."""

    @wraps(function)
    def called(*args: Any, **options: Any) -> Any:
        if not any(map(are_several, (*args, *options.values()))):
            return function(*args, **options)
        from mbproj.lanes import each_call

        return each_call(function, args, options)

    return called  # type: ignore[return-value]
