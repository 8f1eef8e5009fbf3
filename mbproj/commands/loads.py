"""`mbproj loads`: the forces with which actuators make a mechanism follow a motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.cli.completion import File
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.figure_options import check_picture, plot_option
from mbproj.cli.report.text import json_text
from mbproj.cli.scene_options import parameters
from mbproj.cli.study_options import force as force_option
from mbproj.errors import InputError, Place, Problem

if TYPE_CHECKING:
    from mbproj.studies.inverse.loads import ActuatorLoads

EXAMPLES = (
    ("The torque at a joint along a recorded motion.", "mbproj loads results.h5 --actuator A.angle -o torque.csv"),
    ("What the drive takes along a measured motion.", "mbproj loads inline_four.yaml --given measured.csv"),
)


@explained("loads", EXAMPLES)
@click.argument("source", metavar="SCENE|RESULTS", type=File(".yaml", ".yml", ".h5", path_type=Path))
@option(
    Part.WHAT,
    "--given",
    type=File(".csv", ".h5", path_type=Path),
    metavar="MOTION",
    help="Motion of joint coordinates or markers: a CSV table or results [default: that of a run].",
)
@option(
    Part.WHAT,
    "--actuator",
    "actuators",
    multiple=True,
    metavar="NAME",
    help="An actuator, repeatable: a motion, a joint coordinate A.angle, a force, push.x "
    "[default: the motions, or what is given].",
)
@option(
    Part.WHAT,
    "--weight",
    "weights",
    multiple=True,
    metavar="NAME=W",
    help="Weight of an actuator's squared force where actuators outnumber freedoms, repeatable [default: 1].",
)
@option(Part.WHAT, "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Change a parameter of the scene.")
@option(Part.WHAT, "--over", metavar="JOINT.COORDINATE", help="The coordinate that tells the place in the cycle.")
@option(
    Part.ACCURACY,
    "--smooth",
    "smooth",
    multiple=True,
    metavar="SIZE",
    help="Root mean square by which a spline may change given angles (0.1 deg) or lengths (1 mm); 0: it goes through "
    "all samples [default: estimated].",
)
@option(Part.OUTPUT, "-o", "--output", type=File(".csv", path_type=Path), help="CSV table of all samples.")
@plot_option
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object with all samples.")
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@force_option
def command(
    source: Path,
    given: Path | None,
    actuators: tuple[str, ...],
    weights: tuple[str, ...],
    settings: tuple[str, ...],
    over: str | None,
    smooth: tuple[str, ...],
    output: Path | None,
    picture_path: Path | None,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> None:
    """Finds the forces of actuators along a motion: inverse dynamics.

    The motion is that of RESULTS, of a run of SCENE, or given for joint coordinates or markers of SCENE. A force or
    torque is positive where it increases its coordinate. With more actuators than degrees of freedom, the weighted sum
    of squares of the forces is least.
    """
    from mbproj.api.loads import loads_of
    from mbproj.cli.simulate.actuator_loads import facts, lines, table
    from mbproj.output_files import check_replaceable, csv, write_csv

    if smooth and given is None:
        raise click.UsageError("--smooth is for a motion that is given; add --given, or leave it out")
    if output is not None:
        check_replaceable(output, csv(["time (s)"]), force=force)
    check_picture(picture_path, force=force)
    acting = loads_of(
        source,
        given,
        actuators=actuators,
        weights=dict(map(_weight, weights)),
        smooth=_smoothing(smooth),
        parameters=parameters(settings),
    )
    if over is not None:
        acting.cycle(over)
    if as_json:
        click.echo(json_text(facts(acting, str(source), over)))
    elif not quiet:
        click.echo("\n".join(lines(acting, str(source), over)))
    if output is not None:
        headings, rows = table(acting)
        write_csv(output, headings, rows.tolist(), form=".17g", kind=csv(["time (s)"]), force=force)
    if picture_path is not None:
        _draw(acting, over, picture_path, str(source), force=force)
    for path in (output, picture_path):
        if path is not None and not (as_json or quiet):
            click.echo(path)


def _weight(text: str) -> tuple[str, float]:
    """The name and the weight of a text NAME=W. Raises InputError for another text."""
    from mbproj.scene.fields.option_numbers import given_number
    from mbproj.scene.fields.quantities import Number

    name, equals, value = text.rpartition("=")
    if not equals or not name.strip() or not value.strip():
        raise InputError(Problem(f"'{text}' is not NAME=W", Place("--weight"), "e.g. --weight boom=2"))
    return name.strip(), given_number(value.strip(), f"--weight {name.strip()}", Number(above=0.0))


def _smoothing(texts: tuple[str, ...]) -> dict[str, float]:
    """The change that smoothing may make, by unit; a single 0 is for both units."""
    from mbproj.scene.blocks.expectations import Measure
    from mbproj.scene.expressions.units import BARE
    from mbproj.scene.fields.option_numbers import given_number
    from mbproj.scene.fields.quantities import Number

    widths: dict[str, float] = {}
    for text in texts:
        value = given_number(text, "--smooth", Measure())
        if value.number == 0.0:
            widths |= {"rad": 0.0, "m": 0.0}
            continue
        if value.dimension == BARE:
            problem = Problem(
                f"'{text}' has no unit", Place("--smooth"), "give one of angles or lengths: 0.1 deg, 1 mm"
            )
            raise InputError(problem)
        unit = "rad" if value.dimension is not None and value.dimension.angle else "m"
        widths[unit] = given_number(text, "--smooth", Number(unit, above=0.0))
    return widths


def _draw(actuators: ActuatorLoads, over: str | None, path: Path, title: str, *, force: bool) -> None:
    from mbproj.figures.pages.actuators import draw_actuators
    from mbproj.figures.save import save

    cycle = None if over is None else actuators.cycle(over)
    shared = f"{title}: least sum of squares of more actuators than freedoms" if actuators.is_shared else title
    save(
        draw_actuators(
            actuators.time, actuators.names, actuators.units, actuators.force, actuators.power, cycle, shared
        ),
        path,
        force=force,
    )
