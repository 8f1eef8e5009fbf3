"""`mbproj linearize`: the linear model of a mechanism from chosen inputs to chosen outputs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.commands.linear_options import at_options, scene_argument
from mbproj.commands.options import Part, QuantityNames, explained, option, parameters, results_file
from mbproj.commands.report.text import json_text
from mbproj.commands.study_options import force as force_option
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.scenes import LINEAR

if TYPE_CHECKING:
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


@explained("linearize", EXAMPLES)
@scene_argument
@option(
    Part.WHAT,
    "--inputs",
    type=QuantityNames(),
    required=True,
    metavar="A,B,..",
    help="Forces of the scene, joint coordinates (a force along them), components push.x, motions.",
)
@option(
    Part.WHAT,
    "--outputs",
    type=QuantityNames(),
    required=True,
    metavar="A,B,..",
    help="Joint coordinates A.angle and A.angle_speed, markers tip.x and tip.velocity_x, reactions A.force_x, states.",
)
@at_options
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    default="linear.h5",
    show_default=True,
    type=results_file(path_type=Path),
    help="File, .h5, .npz or .mat.",
)
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object with the matrices.")
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@force_option
def command(
    scene: str,
    settings: tuple[str, ...],
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    where: str,
    results: str | None,
    steady: str | None,
    output: Path,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> None:
    """Writes the linear model of SCENE: x' = A x + B u, y = C x + D u.

    States are displacements and speeds that the joints allow, and states of elements. Where a motion is an input, the
    input is its second derivative; its value and rate are states. Other motions are held. `mbproj plot linear.h5` draws
    Bode plots.
    """
    from mbproj.commands.python.linear import reference_of
    from mbproj.equations.assembly.compiled import compile_system
    from mbproj.linear.state_space import linear_model
    from mbproj.results.linear_files import KINDS, write_model
    from mbproj.results.output_files import check_replaceable
    from mbproj.scene.scene import read_scene
    from mbproj.scene.settings import placed_in

    with placed_at(Place("--output")):
        if output.suffix not in KINDS:
            raise InputError(
                Problem(f"'{output}' has no ending of a linear model", hint=f"end it in {', '.join(KINDS)}")
            )
        check_replaceable(output, KINDS[output.suffix], force=force)
    what = read_scene(scene, parameters(settings))
    with placed_in(what):
        reference = reference_of(what, compile_system(what), where, results, steady)
        linear = linear_model(reference, inputs, outputs)
    write_model(output, stored(linear, what.title), what, force=force)
    if as_json:
        click.echo(json_text(numbers(linear, scene, output)))
    elif not quiet:
        click.echo(report(linear, what.title or scene))
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
