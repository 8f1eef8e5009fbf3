"""The settings that functions take, named as the options of `mbproj run`: one typed list for all functions."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypedDict, TypeVar

from mbproj.api.arguments import Quantity
from mbproj.errors import choose_from
from mbproj.settings import settings_taken

Function = TypeVar("Function", bound=Callable[..., Any])


class RunSettings(TypedDict, total=False):
    """Settings of a run: numbers in SI units, or text with a unit. The scene's own settings complete them."""

    duration: Quantity | None
    step: Quantity | None
    tolerance: Quantity | None
    integrator: str | None
    projection: str | None
    formulation: str | None
    kinematic: bool | None
    acceleration: str | None
    impact_law: str | None
    output_step: Quantity | None
    break_times: Sequence[Quantity] | None
    start: str | None
    adjust_joints: Quantity | None
    projection_tolerance: Quantity | None
    projection_test: str | None
    project_position: bool | None
    project_velocity: bool | None
    projection_fallback: str | None
    energy_row: bool | None
    momentum_row: bool | None
    every: int | None
    threshold: Quantity | None
    max_iterations: int | None
    alpha: Quantity | None
    gains: Sequence[Quantity] | None


def options_of(settings: Mapping[str, Any], function: str, *others: str) -> dict[str, object]:
    """The settings that are not None. Raises TypeError for one that the function does not take, with the most similar
    name; `others` are the function's own arguments."""
    known = [*settings_taken(function), *others]
    for name in settings:
        if name not in known:
            raise TypeError(f"{function}() has no argument '{name}'; {choose_from(name, known)}")
    return {name: value for name, value in settings.items() if value is not None}


def with_settings(function: Function) -> Function:
    """Give a function a signature that lists each setting, so that prompts complete them and `help` shows them."""
    signature = inspect.signature(function)
    own = [each for each in signature.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
    each = (
        inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=None,
            annotation=RunSettings.__annotations__[name].__forward_arg__,
        )
        for name in settings_taken(function.__name__)
    )
    function.__signature__ = signature.replace(parameters=[*own, *each])  # type: ignore[attr-defined]
    return function
