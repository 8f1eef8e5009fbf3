"""The options for the state at which a mechanism is linearised."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

from mbproj.base.registry import LINEARISED_AT, SCENE_START
from mbproj.commands.options import Part, one_of, option, results_file, scene_file

Command = TypeVar("Command", bound=Callable[..., Any])


def scene_argument(command: Command) -> Command:
    """Decorate a command with the argument SCENE and --set."""
    command = option(
        Part.WHAT, "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Change a parameter of the scene."
    )(command)
    return click.argument("scene", type=scene_file())(command)


def at_options(command: Command) -> Command:
    """Decorate a command with --at, --steady and --from."""
    command = option(
        Part.WHAT, "--steady", metavar="NAME=RATE", help="With --at steady: how fast it turns, A.angle=60rpm."
    )(command)
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
        default=SCENE_START,
        show_default=True,
        metavar="|".join([*LINEARISED_AT, "TIME"]),
        shell_complete=one_of(lambda: LINEARISED_AT),
        help="Where to linearise.",
    )(command)
