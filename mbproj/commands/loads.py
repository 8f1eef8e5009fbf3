"""`mbproj loads`: the forces with which actuators make a mechanism follow a motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from mbproj.base.errors import InputError, Place, Problem
from mbproj.commands.figure_options import check_picture, plot_option
from mbproj.commands.info import cells
from mbproj.commands.options import File, Part, explained, option, parameters
from mbproj.commands.report.text import columns, json_text
from mbproj.commands.study_options import force as force_option
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.files import ACTUATORS

if TYPE_CHECKING:
    from mbproj.studies.inverse.loads import ActuatorLoads, Smoothing


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
    from mbproj.commands.python.linear import loads_of
    from mbproj.results.output_files import check_replaceable, csv
    from mbproj.results.table_files import write_csv

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
    from mbproj.scene.fields.quantities import Number, given_number

    name, equals, value = text.rpartition("=")
    if not equals or not name.strip() or not value.strip():
        raise InputError(Problem(f"'{text}' is not NAME=W", Place("--weight"), "e.g. --weight boom=2"))
    return name.strip(), given_number(value.strip(), f"--weight {name.strip()}", Number(above=0.0))


def _smoothing(texts: tuple[str, ...]) -> dict[str, float]:
    """The change that smoothing may make, by unit; a single 0 is for both units."""
    from mbproj.scene.blocks.expectations import Measure
    from mbproj.scene.expressions.units import BARE
    from mbproj.scene.fields.quantities import Number, given_number

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
    from mbproj.show.figures.designs import draw_actuators
    from mbproj.show.figures.style import save

    cycle = None if over is None else actuators.cycle(over)
    shared = f"{title}: least sum of squares of more actuators than freedoms" if actuators.is_shared else title
    save(
        draw_actuators(
            actuators.time, actuators.names, actuators.units, actuators.force, actuators.power, cycle, shared
        ),
        path,
        force=force,
    )


# --- The loads of actuators along a motion, as lines, for JSON, and as a table of all samples -------------------------


HEADINGS = ("actuator", "largest", "unit", "at t (s)", "place", "mean", "rms")
#: The most dead centres that are listed.
LISTED = 5


def facts(acting: ActuatorLoads, source: str, over: str | None) -> dict[str, Any]:
    """The loads as a dictionary for JSON."""
    actuators = {
        name: {
            "unit": unit,
            "weight": float(weight),
            "force": acting.force[:, k],
            "rate": acting.rate[:, k],
            "power": acting.power[:, k],
        }
        for k, (name, unit, weight) in enumerate(zip(acting.names, acting.units, acting.weights, strict=True))
    }
    return report_of(ACTUATORS, acting, source=source, place_of=over, largest=acting.largest(over), actuators=actuators)


def lines(actuators: ActuatorLoads, source: str, over: str | None) -> Iterator[str]:
    """Yield a table of the largest forces and powers, then notes on them."""
    count = len(actuators.names)
    yield (
        f"{source}: {actuators.freedom} {'degree' if actuators.freedom == 1 else 'degrees'} of freedom, {count} "
        f"{'actuator' if count == 1 else 'actuators'}, {len(actuators.time)} samples"
    )
    loads = actuators.largest(over)
    turns = over is not None and actuators.cycle(over).unit == "rad"
    yield columns(HEADINGS, [_row(load, over, turns) for load in loads])
    works = [load for load in loads if load.quantity == "power"]
    yield columns(
        ("work of", "put in (J)", "taken out (J)"),
        [(load.name, f"{load.put_in:.6g}", f"{load.taken_out:.6g}") for load in works],
    )
    yield "± is the uncertainty between samples"
    if actuators.is_shared:
        yield _sharing(actuators)
    if actuators.rank < actuators.freedom:
        reached = f"{actuators.rank} of {actuators.freedom} degrees of freedom"
        yield f"the actuators reach {reached}; the others take no force"
    yield f"power balance: {actuators.balance:.2g} of the largest power"
    yield from _dead(actuators)
    yield from _smoothing_lines(actuators.smoothing)


def _row(load: Any, over: str | None, turns: bool) -> tuple[str, ...]:
    place = "-" if over is None else f"{degrees(load.place):.1f}°" if turns else f"{load.place:.5g}"
    return cells(load, load.name + (" power" if load.quantity == "power" else ""), place)


def _sharing(actuators: ActuatorLoads) -> str:
    weights = dict(zip(actuators.names, actuators.weights.tolist(), strict=True))
    weighed = {name: weight for name, weight in weights.items() if weight != 1.0}
    said = ", ".join(f"{name} {weight:g}" for name, weight in weighed.items())
    mixed = "; N and N m are weighed alike" if len(set(actuators.units)) > 1 and not weighed else ""
    norm = f"least weighted sum of squares ({said})" if weighed else "least sum of squares"
    return f"more actuators than degrees of freedom that they reach: of all forces that balance, those of {norm}{mixed}"


def _dead(actuators: ActuatorLoads) -> Iterator[str]:
    if len(actuators.dead):
        listed = ", ".join(f"{time:.6g}" for time in actuators.dead[:LISTED]) + (
            ", .." if len(actuators.dead) > LISTED else ""
        )
        yield f"note: at t = {listed} s the actuators cannot move the mechanism (a dead centre): no force there"


def _smoothing_lines(smoothing: Sequence[Smoothing]) -> Iterator[str]:
    """Yield how the given columns were smoothed."""
    if smoothing:
        yield "the motion against the data that was given"
        rows = [
            (
                each.name,
                "interpolated" if each.noise == 0.0 else f"smoothed, {each.noise:.3g}",
                f"{each.largest:.3g}",
                f"{each.time:.6g}",
                f"{each.rms:.3g}",
                each.unit,
            )
            for each in smoothing
        ]
        yield columns(("column", "spline", "largest change", "at t (s)", "rms", "unit"), rows)


def table(actuators: ActuatorLoads) -> tuple[list[str], np.ndarray[Any, Any]]:
    """The headings and the rows (T, 1 + 3 k) of a CSV table."""
    headings = ["time (s)"]
    for name, unit in zip(actuators.names, actuators.units, strict=True):
        rate_unit = "rad/s" if unit == "N m" else "m/s"
        headings += [f"{name} force ({unit})", f"{name} rate ({rate_unit})", f"{name} power (W)"]
    parts = np.stack([actuators.force, actuators.rate, actuators.power], axis=2).reshape(len(actuators.time), -1)
    return headings, np.concatenate([actuators.time[:, None], parts], axis=1)
