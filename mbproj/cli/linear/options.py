"""The options that say where a mechanism is linearised, and what follows from them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from mbproj.cli.completion import one_of, results_file, scene_file
from mbproj.cli.explained import Part, option
from mbproj.errors import InputError, Place, Problem, placed_at

if TYPE_CHECKING:
    from mbproj.linear.reference import Reference
    from mbproj.model import System
    from mbproj.scene import Scene

Command = TypeVar("Command", bound=Callable[..., Any])
START = "start"
WORDS = (START,)


def scene_argument(command: Command) -> Command:
    """The argument SCENE and --set."""
    command = option(
        Part.WHAT, "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Change a parameter of the scene."
    )(command)
    return click.argument("scene", type=scene_file())(command)


def at_options(command: Command) -> Command:
    """--at and --from."""
    command = option(
        Part.WHAT,
        "--from",
        "results",
        type=results_file(),
        metavar="RESULTS",
        help="Take the state at --at TIME from this results file [default: from a run].",
    )(command)
    return option(
        Part.WHAT,
        "--at",
        "where",
        default=START,
        show_default=True,
        metavar="|".join([*WORDS, "TIME"]),
        shell_complete=one_of(lambda: WORDS),
        help="Where to linearise.",
    )(command)


def reference_of(scene: Scene, system: System, where: str, results: str | None) -> Reference:
    """The motion that the options name. Raises InputError at the option where there is none."""
    from mbproj.linear.reference import reference_at
    from mbproj.linear.states import start_of, state_at, stored_state

    if where in WORDS:
        if results is not None:
            raise InputError(Problem("it needs a time", Place("--from"), "give one of its samples: --at TIME"))
        return reference_at(system, start_of(scene, system), where)
    time = _time(where)
    if results is None:
        return reference_at(system, state_at(scene, system, time), where)
    from mbproj.results import open_results

    with placed_at(Place("--from")), open_results(results) as opened:
        return reference_at(system, stored_state(system, opened, time), where)


def _time(text: str) -> float:
    from mbproj.scene.fields.given import given_number
    from mbproj.scene.fields.quantities import Number

    try:
        return given_number(text, "--at", Number("s", minimum=0.0))
    except InputError as error:
        if any(letter.isdigit() for letter in text):
            raise
        hint = f"give {', '.join(WORDS)} or a time, 0.5 s say"
        raise InputError(Problem(f"unknown place '{text}'", Place("--at"), hint)) from error
