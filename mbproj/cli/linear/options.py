"""The options that say where a mechanism is linearised, and what follows from them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from mbproj.cli.completion import one_of, results_file, scene_file
from mbproj.cli.explained import Part, option
from mbproj.errors import InputError, Place, Problem, placed_at

if TYPE_CHECKING:
    from mbproj.dynamics import State
    from mbproj.linear.equilibrium.balance import Turning
    from mbproj.linear.reference import Reference
    from mbproj.model import System
    from mbproj.model.system import Conditions
    from mbproj.scene import Scene

Command = TypeVar("Command", bound=Callable[..., Any])
START, REST, STEADY = "start", "equilibrium", "steady"
WORDS = (START, REST, STEADY)


def scene_argument(command: Command) -> Command:
    """The argument SCENE and --set."""
    command = option(
        Part.WHAT, "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Change a parameter of the scene."
    )(command)
    return click.argument("scene", type=scene_file())(command)


def at_options(command: Command) -> Command:
    """--at, --steady and --from."""
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
        default=START,
        show_default=True,
        metavar="|".join([*WORDS, "TIME"]),
        shell_complete=one_of(lambda: WORDS),
        help="Where to linearise.",
    )(command)


def reference_of(scene: Scene, system: System, where: str, results: str | None, steady: str | None) -> Reference:
    """The motion that the options name. Raises InputError at the option where there is none."""
    from mbproj.linear.equilibrium.started import start_state
    from mbproj.linear.reference import reference_at
    from mbproj.linear.states import state_at, stored_state

    if (steady is not None) != (where == STEADY):
        hint = "give both: --at steady --steady A.angle=60rpm"
        raise InputError(Problem("one of --at steady and --steady lacks the other", Place("--steady"), hint))
    if where in WORDS and results is not None:
        raise InputError(Problem("it needs a time", Place("--from"), "give one of its samples: --at TIME"))
    if where == START:
        return reference_at(system, start_state(scene, system), where)
    if where in WORDS:
        return _balanced(scene, system, steady)
    time = _time(where)
    if results is None:
        return reference_at(system, state_at(scene, system, time), where)
    from mbproj.results import open_results

    with placed_at(Place("--from")), open_results(results) as opened:
        return reference_at(system, stored_state(system, opened, time), where)


def _balanced(scene: Scene, system: System, steady: str | None) -> Reference:
    """The equilibrium, or the steady turn."""
    from mbproj.linear.equilibrium.find import equilibrium
    from mbproj.linear.equilibrium.started import assembled_start
    from mbproj.linear.equilibrium.steady import refuse_unsteady

    start = assembled_start(scene, system)
    turning, held = steady_of(system, start, steady)
    found = equilibrium(system, start, 0.0, turning, held)
    if turning is not None:
        refuse_unsteady(found, turning, held)
    return found.reference


def steady_of(system: System, start: State, text: str | None) -> tuple[Turning | None, Conditions]:
    """The steady turn that NAME=RATE asks for, and what is held in it; no turn without. Raises InputError at the
    option."""
    from mbproj.dynamics.rank.nearby import NO_CONDITIONS
    from mbproj.linear.equilibrium.steady import steady_turn
    from mbproj.scene.fields.given import given_number
    from mbproj.scene.fields.quantities import Number

    if text is None:
        return None, NO_CONDITIONS
    name, equals, rate = text.partition("=")
    if not equals or not name.strip() or not rate.strip():
        raise InputError(Problem(f"'{text}' is not NAME=RATE", Place("--steady"), "e.g. --steady A.angle=60rpm"))
    number = given_number(rate.strip(), f"--steady {name.strip()}", Number("rad/s"))
    if number == 0.0:
        raise InputError(Problem("a rate of 0 is no turn", Place("--steady"), "leave it out for an equilibrium"))
    with placed_at(Place("--steady")):
        return steady_turn(system, start, name.strip(), number)


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
