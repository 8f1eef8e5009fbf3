"""`mbproj loads` and `mbproj.loads`: the forces with which actuators make a mechanism follow a motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import click
import numpy as np

from mbproj.base.errors import InputError, Place, Problem
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.figure_options import check_picture, plot_option
from mbproj.commands.info import cells
from mbproj.commands.kinds import Assignments, Positive
from mbproj.commands.options import (
    NOTHING,
    Argument,
    File,
    Option,
    Part,
    force_option,
    json_option,
    option,
    output_option,
    quiet_option,
)
from mbproj.commands.report.text import columns, json_text
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.files import ACTUATORS

if TYPE_CHECKING:
    from mbproj.commands.arguments import SceneLike
    from mbproj.results.record import Results
    from mbproj.scene.scene import Scene
    from mbproj.studies.inverse.given_motion import GivenMotion
    from mbproj.studies.inverse.loads import ActuatorLoads, Smoothing

EXAMPLES = (
    ("The torque at a joint along a recorded motion.", "mbproj loads results.h5 --actuator A.angle -o torque.csv"),
    ("What the drive takes along a measured motion.", "mbproj loads inline_four.yaml --given measured.csv"),
)
#: The first bytes of an HDF5 file.
HDF5 = b"\x89HDF\r\n\x1a\n"
#: The forms in which a motion may be given.
Motion: TypeAlias = "GivenMotion | Results | str | Path"
Moved = Annotated["SceneLike | Results", Argument(File(".yaml", ".yml", ".h5", path_type=Path), "SCENE|RESULTS")]
Given = Annotated[
    "Motion | None",
    Option(
        Part.WHAT,
        "Motion of joint coordinates or markers: a CSV table or results [default: that of a run].",
        File(".csv", ".h5", path_type=Path),
        "MOTION",
    ),
]
Actuators = Annotated[
    "str | Sequence[str]",
    Option(
        Part.WHAT,
        "An actuator, repeatable: a motion, a joint coordinate A.angle, a force, push.x "
        "[default: the motions, or what is given].",
        None,
        "NAME",
        names=("--actuator",),
        many=True,
    ),
]
Weights = Annotated[
    "Mapping[str, float]",
    Option(
        Part.WHAT,
        "Weight of an actuator's squared force where actuators outnumber freedoms, repeatable [default: 1].",
        Assignments(lambda name, value, place: Positive("").of(value, f"{place} {name}"), "--weight boom=2"),
        "NAME=W",
        names=("--weight",),
        many=True,
    ),
]


@declared
def loads(
    scene: Moved,
    given: Given = None,
    *,
    actuators: Actuators = (),
    weights: Weights = NOTHING,
    smooth: Mapping[str, float] = NOTHING,
    parameters: Mapping[str, object] = NOTHING,
) -> ActuatorLoads:
    """Finds the forces of actuators along a motion: inverse dynamics.

    The motion is that of results, of a run of a scene, or given for joint coordinates or markers of a scene. A force or
    torque is positive where it increases its coordinate. With more actuators than degrees of freedom, the weighted sum
    of squares of the forces is least.

    In Python `scene` is as in `run`, or results. `given` is a CSV file, results, or a `GivenMotion`. `actuators` are by
    default the scene's motions, or the given coordinates. `smooth` gives, by unit ("rad", "m"), the root mean square
    change that a spline may make to the given motion. Where a unit has none, it is estimated.

    Raises InputError where the motion leaves a freedom open or takes a force that no actuator has. Raises
    SimulationError where the joints do not close along it.
    """
    from mbproj.commands.arguments import scene_of
    from mbproj.commands.run import run
    from mbproj.results.reader import open_results
    from mbproj.results.record import Results
    from mbproj.scene.scene import read_scene_text
    from mbproj.scene.settings import placed_in
    from mbproj.studies.inverse.loads import loads_of_given, loads_of_results

    asked = read(loads, locals())
    if isinstance(scene, Results) or is_results(scene):
        if given is not None or parameters:
            message = "results have their motion and their parameters"
            raise InputError(Problem(message, Place("--given"), "give the scene, or leave both out"))
        of = scene if isinstance(scene, Results) else open_results(Path(str(scene)))
        stored = read_scene_text(of.scene_text, str(of.scene_path or of.path), of.overrides)
        return loads_of_results(stored, of, asked.actuators, asked.weights)
    what = scene_of(scene, parameters, {})
    if given is None:
        return loads_of_results(what, run(what), asked.actuators, asked.weights)
    with placed_in(what):
        return loads_of_given(what, _motion(what, asked.given), asked.actuators, asked.weights, smooth)


def _motion(scene: Scene, motion: Motion) -> GivenMotion:
    from mbproj.equations.assembly.compiled import compile_system
    from mbproj.results.reader import open_results
    from mbproj.results.record import Results
    from mbproj.studies.inverse.given_motion import GivenMotion, from_csv, from_results

    system = compile_system(scene)
    if isinstance(motion, GivenMotion):
        return motion
    if isinstance(motion, Results):
        return from_results(system, motion)
    if is_results(motion):
        with open_results(Path(motion)) as opened:
            return from_results(system, opened)
    return from_csv(system, Path(motion))


def is_results(path: object) -> bool:
    """Whether `path` is the path of an HDF5 file."""
    if not isinstance(path, (str, Path)) or "\n" in str(path):
        return False
    try:
        with Path(path).open("rb") as file:
            return file.read(len(HDF5)) == HDF5
    except OSError:
        return False


OVER = option(Part.WHAT, "--over", metavar="JOINT.COORDINATE", help="The coordinate that tells the place in the cycle.")
SMOOTH = option(
    Part.ACCURACY,
    "--smooth",
    multiple=True,
    metavar="SIZE",
    help="Root mean square by which a spline may change given angles (0.1 deg) or lengths (1 mm); 0: it goes through "
    "all samples [default: estimated].",
)
OUTPUT = output_option(None, File(".csv", path_type=Path), "CSV table of all samples.")


@command_of(loads, EXAMPLES, OVER, SMOOTH, OUTPUT, plot_option, json_option, quiet_option, force_option)
def command(
    asked: Asked[ActuatorLoads],
    over: str | None,
    smooth: tuple[str, ...],
    output: Path | None,
    picture_path: Path | None,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> None:
    from mbproj.results.output_files import check_replaceable, csv
    from mbproj.results.table_files import write_csv

    source = str(asked.given["scene"])
    if smooth and "given" not in asked.given:
        raise click.UsageError("--smooth is for a motion that is given; add --given, or leave it out")
    if output is not None:
        check_replaceable(output, csv(["time (s)"]), force=force)
    check_picture(picture_path, force=force)
    acting = asked.result(smooth=_smoothing(smooth))
    if over is not None:
        acting.cycle(over)
    if as_json:
        click.echo(json_text(facts(acting, source, over)))
    elif not quiet:
        click.echo("\n".join(lines(acting, source, over)))
    if output is not None:
        headings, rows = table(acting)
        write_csv(output, headings, rows.tolist(), form=".17g", kind=csv(["time (s)"]), force=force)
    if picture_path is not None:
        _draw(acting, over, picture_path, source, force=force)
    for path in (output, picture_path):
        if path is not None and not (as_json or quiet):
            click.echo(path)


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
