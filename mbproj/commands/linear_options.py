"""The state at which a mechanism is linearised: its options, and the motion that they name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, SupportsFloat

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.base.registry import LINEARISED_AT, SCENE_START, STEADY
from mbproj.commands.options import Option, Part, one_of, results_file

if TYPE_CHECKING:
    from pathlib import Path

    from mbproj.commands.arguments import Quantity
    from mbproj.equations.assembly.assemble import State
    from mbproj.linear.equilibrium.balance import SteadyTurn
    from mbproj.linear.equilibrium.find import Equilibrium
    from mbproj.linear.reference import LinearReference
    from mbproj.model.system import Conditions, System
    from mbproj.scene.scene import Scene

At = Annotated[
    "Quantity",
    Option(
        Part.WHAT,
        "Where to linearise.",
        None,
        "|".join([*LINEARISED_AT, "TIME"]),
        complete=one_of(lambda: LINEARISED_AT),
    ),
]
FromResults = Annotated[
    "str | Path | None",
    Option(
        Part.WHAT,
        "Take the state at --at TIME from this results file [default: from a run].",
        results_file(),
        "RESULTS",
        names=("--from",),
    ),
]
Steady = Annotated[
    "str | None", Option(Part.WHAT, "With --at steady: how fast it turns, A.angle=60rpm.", None, "NAME=RATE")
]


def reference_of(
    scene: Scene, system: System, where: Quantity, results: str | Path | None, steady: str | None
) -> LinearReference:
    """The motion that the options name. Raises InputError, at the option, where there is none."""
    from mbproj.linear.equilibrium.start import start_state
    from mbproj.linear.reference import reference_at
    from mbproj.linear.states import state_at, stored_state
    from mbproj.results.reader import open_results

    if (steady is not None) != (where == STEADY):
        hint = "give both: --at steady --steady A.angle=60rpm"
        raise InputError(Problem("one of --at steady and --steady lacks the other", Place("--steady"), hint))
    if where in LINEARISED_AT and results is not None:
        raise InputError(Problem("it needs a time", Place("--from"), "give one of its samples: --at TIME"))
    if where == SCENE_START:
        return reference_at(system, start_state(scene, system), SCENE_START)
    if where in LINEARISED_AT:
        return rest_of(scene, system, 0.0, steady)[0].reference
    time = _time(where)
    at = where if isinstance(where, str) else f"{time:g} s"
    if results is None:
        return reference_at(system, state_at(scene, system, time), at)
    with placed_at(Place("--from")), open_results(results) as opened:
        return reference_at(system, stored_state(system, opened, time), at)


def rest_of(scene: Scene, system: System, time: float, steady: str | None, starts: int = 0) -> tuple[Equilibrium, ...]:
    """The equilibrium, or the steady turn, of motions held at a time, and others from as many other `starts`. Raises
    InputError at the option, NoEquilibrium where nothing balances the forces."""
    from mbproj.linear.equilibrium.find import equilibrium, other_equilibria
    from mbproj.linear.equilibrium.start import assembled_start
    from mbproj.linear.equilibrium.steady import refuse_unsteady

    start = assembled_start(scene, system)
    turning, held = _steady_of(system, start, steady)
    rest = equilibrium(system, start, time, turning, held)
    if turning is not None:
        refuse_unsteady(rest, turning, held)
    return (rest, *other_equilibria(system, rest, starts, turning, held))


def _steady_of(system: System, start: State, text: str | None) -> tuple[SteadyTurn | None, Conditions]:
    """The steady turn that NAME=RATE names, and the coordinates held in it; None without a text. Raises InputError at
    the option."""
    from mbproj.equations.rank.row_space import NO_CONDITIONS
    from mbproj.linear.equilibrium.steady import steady_turn
    from mbproj.scene.fields.quantities import Number, given_number

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
    from mbproj.scene.fields.quantities import Number, given_number

    try:
        return given_number(where, "--at", Number("s", minimum=0.0))
    except InputError as error:
        if any(letter.isdigit() for letter in str(where)):
            raise
        hint = f"give {', '.join(LINEARISED_AT)} or a time, 0.5 s say"
        raise InputError(Problem(f"unknown place '{where}'", Place("--at"), hint)) from error
