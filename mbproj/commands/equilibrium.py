"""`mbproj equilibrium`, `mbproj.equilibrium` and `equilibria`: where a mechanism rests, whether that is stable, and the
reactions of its joints there."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.kinds import Count, NotNegative
from mbproj.commands.linear_options import rest_of
from mbproj.commands.options import (
    NOTHING,
    Option,
    Part,
    json_option,
    option,
    output_option,
    quiet_option,
    results_file,
)
from mbproj.commands.report.text import json_text
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.scenes import EQUILIBRIUM

if TYPE_CHECKING:
    from mbproj.commands.arguments import Quantity, SceneLike
    from mbproj.linear.equilibrium.find import Equilibrium

#: The most reactions in the report.
SHOWN_REACTIONS = 20
EXAMPLES = (
    ("Find where it rests, and write equilibrium.h5.", "mbproj equilibrium five_bar.yaml"),
    ("Look for others from 20 other poses.", "mbproj equilibrium five_bar.yaml --starts 20"),
    ("Begin a run there.", 'mbproj run five_bar.yaml --start equilibrium --duration "1 s"'),
)
At = Annotated["Quantity", Option(Part.WHAT, "When motions are held.", NotNegative("s"), "TIME")]
Steady = Annotated["str | None", Option(Part.WHAT, "Turn steadily about a joint: A.angle=60rpm.", None, "NAME=RATE")]
STARTS = Option(Part.EFFORT, "Look for others from N other poses.", Count(), "N")
Starts = Annotated[int, STARTS]


@declared
def equilibrium(
    scene: SceneLike, *, at: At = 0, steady: Steady = None, parameters: Mapping[str, object] = NOTHING
) -> Equilibrium:
    """Finds where a scene rests: no velocity, all forces balance, no state changes.

    Goes downhill from the start. Tells whether the equilibrium is stable, which directions are neutral, and the
    reactions of the joints. Motions are held at their values at --at. The results file has one sample.

    In Python `scene` and `parameters` are as in `run`. With `steady` it is a steady turn about a joint. Raises
    InputError where the scene is wrong. Raises `mbproj.linear.equilibrium.solve.NoEquilibrium`, a SimulationError,
    where nothing balances the forces.
    """
    return _equilibria(read(equilibrium, locals()), 0)[0]


@declared
def equilibria(
    scene: SceneLike,
    *,
    starts: Starts = 20,
    at: At = 0,
    steady: Steady = None,
    parameters: Mapping[str, object] = NOTHING,
) -> tuple[Equilibrium, ...]:
    """Finds the equilibrium, and others from as many other `starts`. The other arguments are as in `equilibrium`."""
    asked = read(equilibria, locals())
    return _equilibria(asked, asked.starts)


def _equilibria(asked: Any, starts: int) -> tuple[Equilibrium, ...]:
    from mbproj.equations.assembly.compiled import compile_system
    from mbproj.scene.settings import placed_in

    with placed_in(asked.scene):
        return rest_of(asked.scene, compile_system(asked.scene), asked.at, asked.steady, starts)


WRITE = option(Part.OUTPUT, "--write", is_flag=True, help="Write the pose into SCENE, as the start of its joints.")
OUTPUT = output_option("equilibrium.h5", results_file(), "Results file.")


@command_of(equilibrium, EXAMPLES[:2], STARTS.alone("starts", 0), WRITE, OUTPUT, json_option, quiet_option)
def command(asked: Asked[Equilibrium], starts: int, write: bool, output: str, as_json: bool, quiet: bool) -> None:
    from mbproj.linear.equilibrium.solve import NoEquilibrium
    from mbproj.linear.equilibrium.start import write_pose
    from mbproj.results.crash_safety import check_output
    from mbproj.results.output_files import check_rewritable
    from mbproj.studies.record import record_equilibrium

    with placed_at(Place("--output")):
        check_output(Path(output))
    if write and asked.given.get("steady"):
        raise InputError(Problem("a steady turn is no pose at rest", Place("--write"), "leave out one of the two"))
    what, scene = asked.scene, asked.path
    if write:
        check_rewritable(what.path)
    try:
        rest, *more = _equilibria(asked.read(), starts)
    except NoEquilibrium as error:
        if as_json:
            relative = error.balance.relative
            click.echo(
                json_text({"scene": scene, "converged": False, "residual": {"relative": relative}, "why": str(error)})
            )
        raise
    with placed_at(Place("--output")):
        record_equilibrium(
            what, output, rest, {"converged": True, "residual_relative": rest.reference.imbalance.relative}
        )
    written = write_pose(what, rest) if write else None
    if as_json:
        click.echo(json_text(numbers(rest, more, scene, output, written)))
    elif not quiet:
        click.echo(report(rest, more, what.title or scene))
        click.echo(output)
        if written:
            click.echo(f"{written}: the joints start there now")


def numbers(
    rest: Equilibrium, more: list[Equilibrium], scene: str, output: str, written: Path | None
) -> dict[str, Any]:
    """The equilibrium as a dictionary for JSON, with stable keys."""
    from mbproj.linear.equilibrium.start import observed

    system, block = rest.whole, observed(rest)
    force, torque = (block[f"joints/reaction_{kind}"][0] for kind in ("force", "torque"))
    reactions = {
        name: {"force": force[joint], "torque": torque[joint]} for joint, name in enumerate(system.names.joints)
    }
    return report_of(
        EQUILIBRIUM,
        rest,
        scene=scene,
        output=output,
        converged=True,
        unstable_along=rest.unstable or None if rest.stable is False else None,
        reactions=reactions,
        others=more,
        written=written,
    )


def report(rest: Equilibrium, more: list[Equilibrium], title: str) -> str:
    """The report on the equilibrium."""
    from mbproj.commands.report.start import frictions
    from mbproj.commands.report.text import table
    from mbproj.linear.equilibrium.start import observed

    system, off = rest.whole, rest.reference.imbalance
    where = "turns steadily" if rest.reference.where == "steady" else "rests"
    units = dict(zip(system.names.coordinates, system.names.coordinate_units, strict=True))
    coordinates = {name: f"{_number(value)} {units[name]}" for name, value in rest.coordinates.items()}
    of_states = dict(zip(system.names.states, system.names.state_units, strict=True))
    states = {name: f"{_number(value)} {of_states[name]}" for name, value in rest.states.items()}
    force = observed(rest)["joints/reaction_force"][0]
    reactions = {
        name: f"[{', '.join(_number(part) for part in force[joint])}] N"
        for joint, name in list(enumerate(system.names.joints))[:SHOWN_REACTIONS]
    }
    lines = [
        f"{title}: {where} at t = {rest.reference.motion.t:.6g} s, found in {rest.steps} steps",
        f"  forces left: {off.force:.1e} N, {off.torque:.1e} N m ({off.relative:.1e} of the largest)",
        f"  {_stability(rest)}",
        *([f"  one of a {rest.family}-dimensional family: rolling bodies may rest elsewhere"] if rest.family else []),
        *([f"  neutral, kept as they were: the motions {'; '.join(rest.neutral)}"] if rest.neutral else []),
        *([f"  held at its speed by {rest.drive[0]:.6g} N m"] if len(rest.drive) else []),
        *(["  joint coordinates", *table(coordinates, "    ")] if coordinates else []),
        *(["  states", *table(states, "    ")] if states else []),
        *(["  reactions on body 2", *table(reactions, "    ")] if reactions else []),
    ]
    lines += frictions(rest.frictions)
    for other in more:
        told = ", ".join(f"{name} {_number(value)}" for name, value in list(other.coordinates.items())[:6])
        lines.append(f"  another, {_stability(other)}: {told}")
    return "\n".join(lines)


def _stability(rest: Equilibrium) -> str:
    if rest.stable is None:
        return f"whether it is stable cannot be told: {rest.unstable}"
    return "stable" if rest.stable else f"not stable, along the motion {rest.unstable}"


def _number(value: float) -> str:
    return "0" if abs(value) < 1e-12 else f"{value:.6g}"
