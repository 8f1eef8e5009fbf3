"""The state at which a mechanism is linearised, as --at, --from and --steady name it."""

from __future__ import annotations

from pathlib import Path
from typing import SupportsFloat

from mbproj.dynamics import State
from mbproj.dynamics.rank.lasting import NO_CONDITIONS
from mbproj.errors import InputError, Place, Problem, placed_at
from mbproj.linear.equilibrium.balance import SteadyTurn
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.started import assembled_start, start_state
from mbproj.linear.equilibrium.steady import refuse_unsteady, steady_turn
from mbproj.linear.reference import LinearReference, reference_at
from mbproj.linear.states import state_at, stored_state
from mbproj.model import System
from mbproj.model.system import Conditions
from mbproj.registry import LINEARISED_AT, SCENE_START, STEADY
from mbproj.results import open_results
from mbproj.scene.fields.option_numbers import given_number
from mbproj.scene.fields.quantities import Number
from mbproj.scene.read import Scene


def reference_of(
    scene: Scene, system: System, where: SupportsFloat | str, results: str | Path | None, steady: str | None
) -> LinearReference:
    """The motion that the options name. Raises InputError, at the option, where there is none."""
    if (steady is not None) != (where == STEADY):
        hint = "give both: --at steady --steady A.angle=60rpm"
        raise InputError(Problem("one of --at steady and --steady lacks the other", Place("--steady"), hint))
    if where in LINEARISED_AT and results is not None:
        raise InputError(Problem("it needs a time", Place("--from"), "give one of its samples: --at TIME"))
    if where == SCENE_START:
        return reference_at(system, start_state(scene, system), SCENE_START)
    if where in LINEARISED_AT:
        return _balanced(scene, system, steady)
    time = _time(where)
    at = where if isinstance(where, str) else f"{time:g} s"
    if results is None:
        return reference_at(system, state_at(scene, system, time), at)
    with placed_at(Place("--from")), open_results(results) as opened:
        return reference_at(system, stored_state(system, opened, time), at)


def _balanced(scene: Scene, system: System, steady: str | None) -> LinearReference:
    """The motion at the equilibrium, or in the steady turn."""
    start = assembled_start(scene, system)
    turning, held = steady_of(system, start, steady)
    rest = equilibrium(system, start, 0.0, turning, held)
    if turning is not None:
        refuse_unsteady(rest, turning, held)
    return rest.reference


def steady_of(system: System, start: State, text: str | None) -> tuple[SteadyTurn | None, Conditions]:
    """The steady turn that NAME=RATE names, and the coordinates held in it; None without a text. Raises InputError at
    the option."""
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


def _time(where: SupportsFloat | str) -> float:
    try:
        return given_number(where, "--at", Number("s", minimum=0.0))
    except InputError as error:
        if any(letter.isdigit() for letter in str(where)):
            raise
        hint = f"give {', '.join(LINEARISED_AT)} or a time, 0.5 s say"
        raise InputError(Problem(f"unknown place '{where}'", Place("--at"), hint)) from error
