"""`mbproj linearize` and `mbproj.linearize`: the linear model of a mechanism from chosen inputs to chosen outputs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.base.registry import SCENE_START
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.kinds import Names
from mbproj.commands.linear_options import At, FromResults, Steady, reference_of
from mbproj.commands.options import (
    NOTHING,
    Option,
    Part,
    force_option,
    json_option,
    output_option,
    quiet_option,
    results_file,
)
from mbproj.commands.report.text import json_text
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.scenes import LINEAR

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mbproj.commands.arguments import SceneLike
    from mbproj.linear.state_space import LinearModel
    from mbproj.results.linear_files import StoredModel

EXAMPLES = (
    (
        "From a torque at one joint to the angle of another, as HDF5.",
        "mbproj linearize five_bar.yaml --inputs A.angle --outputs E.angle",
    ),
    (
        "To a marker, for MATLAB.",
        "mbproj linearize five_bar.yaml --inputs A.angle --outputs tip.x -o a.mat",
    ),
)
Inputs = Annotated[
    "str | Sequence[str]",
    Option(
        Part.WHAT,
        "Forces of the scene, joint coordinates (a force along them), components push.x, motions.",
        Names(),
        "A,B,..",
    ),
]
Outputs = Annotated[
    "str | Sequence[str]",
    Option(
        Part.WHAT,
        "Joint coordinates A.angle and A.angle_speed, markers tip.x and tip.velocity_x, reactions A.force_x, states.",
        Names(),
        "A,B,..",
    ),
]


@declared
def linearize(
    scene: SceneLike,
    inputs: Inputs,
    outputs: Outputs,
    *,
    at: At = SCENE_START,
    steady: Steady = None,
    results: FromResults = None,
    parameters: Mapping[str, object] = NOTHING,
) -> LinearModel:
    """Writes the linear model of a scene: x' = A x + B u, y = C x + D u.

    States are displacements and speeds that the joints allow, and states of elements. Where a motion is an input, the
    input is its second derivative; its value and rate are states. Other motions are held. `mbproj plot linear.h5` draws
    Bode plots.

    In Python it returns the model. `at`, `steady` and `results` tell where, as in `modes`. Raises InputError for a name
    that is no input or output.
    """
    from mbproj.equations.assembly.compiled import compile_system
    from mbproj.linear.state_space import linear_model
    from mbproj.scene.settings import placed_in

    asked = read(linearize, locals())
    with placed_in(asked.scene):
        reference = reference_of(asked.scene, compile_system(asked.scene), asked.at, asked.results, steady)
        return linear_model(reference, asked.inputs, asked.outputs)


OUTPUT = output_option("linear.h5", results_file(path_type=Path), "File, .h5, .npz or .mat.")


@command_of(linearize, EXAMPLES, OUTPUT, json_option, quiet_option, force_option)
def command(asked: Asked[LinearModel], output: Path, as_json: bool, quiet: bool, force: bool) -> None:
    from mbproj.results.linear_files import KINDS, write_model
    from mbproj.results.output_files import check_replaceable

    with placed_at(Place("--output")):
        if output.suffix not in KINDS:
            raise InputError(
                Problem(f"'{output}' has no ending of a linear model", hint=f"end it in {', '.join(KINDS)}")
            )
        check_replaceable(output, KINDS[output.suffix], force=force)
    what, linear = asked.scene, asked.result()
    write_model(output, stored(linear, what.title), what, force=force)
    if as_json:
        click.echo(json_text(numbers(linear, asked.path, output)))
    elif not quiet:
        click.echo(report(linear, what.title or asked.path))
        click.echo(output)


def stored(linear: LinearModel, title: str) -> StoredModel:
    """The model in the form of its file."""
    from mbproj.results.linear_files import StoredModel

    fields = {name: value for name, value in vars(linear).items() if name != "reference"}
    return StoredModel(**fields, where=linear.reference.where, time=linear.reference.motion.t, title=title)


def numbers(linear: LinearModel, scene: str, output: Path) -> dict[str, Any]:
    """The model as a dictionary for JSON, with stable keys."""
    from mbproj.linear.modes import is_balanced

    return report_of(LINEAR, linear, scene=scene, output=output, balanced=is_balanced(linear.reference))


def report(linear: LinearModel, title: str) -> str:
    """The report on the model, with notes."""
    from mbproj.linear.modes import is_balanced, unsteady_states

    def with_units(names: tuple[str, ...], units: tuple[str, ...]) -> str:
        return ", ".join(f"{name} ({unit})" for name, unit in zip(names, units, strict=True))

    where = linear.reference.where
    at = where if where.isalpha() else f"t = {linear.reference.motion.t:.6g} s"
    off = linear.reference.imbalance
    note = f"note: forces do not balance here: up to {off.force:.3g} N and {off.torque:.3g} N m are left"
    unsteady = unsteady_states(linear.reference)
    return "\n".join(
        [
            f"{title}: linear model with {len(linear.states)} states, at {at}",
            f"  inputs   {with_units(linear.inputs, linear.input_units)}",
            f"  outputs  {with_units(linear.outputs, linear.output_units)}",
            *([] if is_balanced(linear.reference) else [note]),
            *([f"note: {unsteady}"] if unsteady else []),
        ]
    )
