"""`mbproj import`: a model in MJCF, URDF or SDF as a scene, with a table of elements that have no counterpart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import ExitCode
from mbproj.commands.options import Part, explained, option
from mbproj.commands.report.text import json_text
from mbproj.commands.study_options import force as force_option
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.scenes import SAID

if TYPE_CHECKING:
    from mbproj.base.errors import Place
    from mbproj.formats.mechanism import Said, Same


EVERYTHING = "everything in the model has its counterpart in the scene"
EXAMPLES = (
    ("Make a scene of a model.", "mbproj import robot.xml -o robot.yaml"),
    (
        "Begin at a keyframe, with servos that hold their place.",
        "mbproj import robot.xml --at home --hold -o held.yaml",
    ),
    (
        "Drive its actuators and joints by functions of time.",
        "mbproj import robot.xml --controls u.yaml -o r.yaml",
    ),
)


def from_file(name: str, what: str) -> Callable[[Any], Any]:
    """A decorator for an option that names a file with a line for each name."""
    return option(Part.WHAT, name, type=click.Path(path_type=Path), metavar="FILE", help=what)


@explained("import", EXAMPLES)
@click.argument("model", type=click.Path(path_type=Path))
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="SCENE",
    help="Write the scene to SCENE instead of stdout.",
)
@option(Part.WHAT, "--at", "key", metavar="KEY", help="Begin at this keyframe of the model.")
@from_file("--pose", "Begin at the joint coordinates in FILE, lines as 'hinge: 0.3' in rad and m.")
@from_file("--loops", "For a URDF: the YAML file with its loops [default: the one beside it with its name].")
@option(Part.WHAT, "--meet", is_flag=True, help="For an SDF: let the two frames that a joint names coincide.")
@option(Part.WHAT, "--hold", is_flag=True, help="Let actuators act with their control signal at the start.")
@from_file(
    "--controls", "Let actuators act with the signals in FILE, lines as 'motor: 0.3*sin(2*t)'; others hold theirs."
)
@from_file("--motions", "Drive joints by the functions of time in FILE, lines as 'hinge: 0.2*t' in rad and m.")
@option(Part.WHAT, "--contacts", is_flag=True, help="Make stops of spheres and capsules above planes.")
@option(Part.OUTPUT, "--strict", is_flag=True, help="End with 4 where the scene's motion is not the model's.")
@option(
    Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print the table as one JSON object, on stderr without -o."
)
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print no table.")
@force_option
@click.pass_context
def command(
    context: click.Context,
    model: Path,
    output: Path | None,
    key: str | None,
    pose: Path | None,
    loops: Path | None,
    meet: bool,
    hold: bool,
    controls: Path | None,
    motions: Path | None,
    contacts: bool,
    strict: bool,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> None:
    """Makes a scene of MODEL, which is MJCF, URDF or SDF.

    The table lists each element without a counterpart: what becomes of it, and whether the motion of the scene is still
    that of the model.
    """
    from mbproj.commands.python.models import imported
    from mbproj.formats.mechanism import ImportOptions
    from mbproj.formats.signals import read_pose, read_signals
    from mbproj.results.output_files import SCENE, check_replaceable, write_text
    from mbproj.results.report_schema.facts import report_of
    from mbproj.results.report_schema.scenes import AGREEMENT

    if output is not None:
        check_replaceable(output, SCENE, force=force)
    acting = read_signals(controls) if controls else {} if hold else None
    driven = read_signals(motions) if motions else {}
    folder = output.parent if output else Path()
    options = ImportOptions(key, read_pose(pose) if pose else {}, acting, driven, contacts, loops, meet, folder)
    model_read = imported(model, options)
    mechanism, text = model_read.mechanism, model_read.text
    if output is None:
        click.echo(text, nl=False)
    else:
        written = write_text(output, text, SCENE, force=force)
    to_stderr = output is None
    if as_json:
        agreement = model_read.agreement and report_of(AGREEMENT.fields, model_read.agreement)
        facts = {"scene": str(output) if output else None, AGREEMENT.key: agreement}
        click.echo(table_json(mechanism.said, **facts), err=to_stderr)
    elif not quiet:
        for line in table_lines(mechanism.said, EVERYTHING):
            click.echo(line, err=to_stderr)
        if output is not None:
            click.echo(written)
    if strict and not model_read.same:
        context.exit(int(ExitCode.CHECK_FAILED))


# --- The table of differences between a scene and a model -------------------------------------------------------------
# Each element, what becomes of it, and whether the motion is the same.


def table_lines(said: Sequence[Said], all_said: str) -> list[str]:
    """The rows of the table, equal ones combined. Where there are none, the line `all_said`."""
    if not said:
        return [all_said]
    alike: dict[tuple[str, str, Same], list[Said]] = {}
    for row in said:
        alike.setdefault((row.element.partition(" '")[0], row.what, row.same), []).append(row)
    lines = ["same motion  element, and what happens with it"]
    for (kind, what, same), entries in alike.items():
        place = "" if entries[0].place is None else f", {_place(entries[0].place)}"
        shown = entries[0].element if len(entries) == 1 else f"{len(entries)} times {kind}"
        lines += [f"{same.value:13}{shown}{place}", f"{'':15}{what}"]
    return lines


def _place(place: Place) -> str:
    return f"{Path(place.file).name}:{place.line or 1}"


def table_json(said: Sequence[Said], **facts: Any) -> str:
    """The table as one JSON object, after these facts."""
    rows = [report_of(SAID.fields, row, place=str(row.place or "")) for row in said]
    return json_text(facts | {SAID.key: rows})
