"""`register_projection`: a projection method of one's own, which runs in the full formulation and in all studies."""

from __future__ import annotations

from collections.abc import Sequence

from mbproj.errors import InputError, Problem
from mbproj.projection.methods.method import Method
from mbproj.registry import PROJECTIONS, ProjectionEntry

#: Options that a scene may give to a method.
OPTIONS = ("alpha", "gains")


def register_projection(
    name: str, method: type[Method], *, summary: str, equations: str = "", options: Sequence[str] = ()
) -> None:
    """Adds a projection method to those that a scene may name.

    `method` is a class derived from `Projection`, which is made with its `options`, of "alpha" and "gains", as
    arguments. `summary` is the line on it, `equations` says where it is from. Raises InputError where the name is taken
    or cannot be one, TypeError where `method` is no such class.
    """
    if not (isinstance(method, type) and issubclass(method, Method)):
        raise TypeError(f"a projection method is a class derived from mbproj.Projection, found {method!r}")
    missing = sorted(getattr(method, "__abstractmethods__", ()))
    if missing:
        raise TypeError(f"{method.__name__} has no method '{missing[0]}'")
    for option in options:
        if option not in OPTIONS:
            raise InputError(Problem(f"a method has no option '{option}'", hint=f"options are: {', '.join(OPTIONS)}"))
    entry = ProjectionEntry("", equations, summary, tuple(options), not method.stabilises, factory=method)
    PROJECTIONS.add(name, entry, method)
