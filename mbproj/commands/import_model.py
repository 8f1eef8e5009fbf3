"""`mbproj import` and `mbproj.import_model`: a model in MJCF, URDF or SDF as a scene, with a table of elements that
have no counterpart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.options import Argument, Option, Part, force_option, option, output_option
from mbproj.commands.report.text import json_text
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.scenes import AGREEMENT, SAID
from mbproj.results.views import Table, Tabled

if TYPE_CHECKING:
    from mbproj.base.errors import Place
    from mbproj.formats.mechanism import Agreement, ImportedMechanism, ImportOptions, Said, Same
    from mbproj.scene.scene import Scene


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


def _from_file(what: str) -> Option:
    """The option that names a file with a line for each name."""
    return Option(Part.WHAT, what, click.Path(path_type=Path), "FILE")


Model = Annotated["str | Path", Argument(click.Path(path_type=Path))]
Keyframe = Annotated["str | None", Option(Part.WHAT, "Begin at this keyframe of the model.", None, "KEY")]
Pose = Annotated[
    "Mapping[str, float] | str | Path | None",
    _from_file("Begin at the joint coordinates in FILE, lines as 'hinge: 0.3' in rad and m."),
]
Loops = Annotated[
    "str | Path | None",
    _from_file("For a URDF: the YAML file with its loops [default: the one beside it with its name]."),
]
Meet = Annotated[bool, Option(Part.WHAT, "For an SDF: let the two frames that a joint names coincide.")]
Hold = Annotated[bool, Option(Part.WHAT, "Let actuators act with their control signal at the start.")]
Controls = Annotated[
    "Mapping[str, str | float] | str | Path | None",
    _from_file("Let actuators act with the signals in FILE, lines as 'motor: 0.3*sin(2*t)'; others hold theirs."),
]
Motions = Annotated[
    "Mapping[str, str | float] | str | Path | None",
    _from_file("Drive joints by the functions of time in FILE, lines as 'hinge: 0.2*t' in rad and m."),
]
Contacts = Annotated[bool, Option(Part.WHAT, "Make stops of spheres and capsules above planes.")]


@dataclass(frozen=True, eq=False)
class Imported(Tabled):
    """The `text` of a scene made from a model, with notes on each element of the model that has no counterpart.

    `agreement` has the differences of its start and its accelerations from MuJoCo's; None for other formats."""

    text: str
    mechanism: ImportedMechanism
    agreement: Agreement | None = None

    @property
    def scene(self) -> Scene:
        """The scene. Raises InputError where it cannot be read."""
        from mbproj.scene.scene import read_scene_text

        return read_scene_text(self.text, "scene")

    @property
    def same(self) -> bool:
        """Whether no known difference makes the scene's motion another than the model's."""
        from mbproj.formats.mechanism import Same

        return all(row.same is not Same.NO for row in self.mechanism.said)

    @property
    def table(self) -> Table:
        """A table with a row for each element: what became of it, and whether the motion is still the model's."""
        return said_table(self.mechanism.said)

    @property
    def line(self) -> str:
        """A line with the size of the scene."""
        parts, joints = len(self.mechanism.parts), len(self.mechanism.joints)
        return f"{self.mechanism.title}: {parts} bodies, {joints} joints"

    __repr__ = Tabled.__repr__


@declared
def import_model(
    model: Model,
    *,
    at: Keyframe = None,
    pose: Pose = None,
    loops: Loops = None,
    meet: Meet = False,
    hold: Hold = False,
    controls: Controls = None,
    motions: Motions = None,
    contacts: Contacts = False,
    folder: str | Path | None = None,
) -> Imported:
    """Makes a scene of MODEL, which is MJCF, URDF or SDF.

    The table lists each element without a counterpart: what becomes of it, and whether the motion of the scene is still
    that of the model.

    In Python the result has `scene`, `text`, and this table. A `pose`, `controls` and `motions` may be mappings, too.
    `folder` is where the scene will be stored, as its meshes are named relative to it; by default that of the model.
    Raises InputError where the model is wrong.
    """
    from mbproj.formats.mechanism import ImportOptions
    from mbproj.formats.signals import read_pose, signals_of

    asked = read(import_model, locals())
    start = read_pose(asked.pose) if isinstance(asked.pose, Path) else asked.pose or {}
    acting = signals_of(asked.controls, "controls") if asked.controls is not None else {} if hold else None
    driven = signals_of(asked.motions, "motions") if asked.motions is not None else {}
    home = None if folder is None else Path(folder)
    return _imported(asked.model, ImportOptions(at, start, acting, driven, contacts, asked.loops, meet, home))


def _imported(model: Path, options: ImportOptions) -> Imported:
    """Import a model as `import_model` does. Problems of the scene itself are rows of the table."""
    from mbproj.base.version import __version__
    from mbproj.formats.as_scene import without_refused
    from mbproj.formats.mechanism import Same
    from mbproj.formats.read import read_model

    mechanism = read_model(model, options)
    text, refused = without_refused(mechanism, __version__)
    for problem in refused:
        at = problem.place.line if problem.place else None
        line = "it" if at is None else f"its line {at}"
        mechanism.say("the scene itself", None, f"check refuses {line}: {problem.message}", Same.NO)
    agreement = None if refused or mechanism.compare is None else mechanism.compare(mechanism, __version__)
    return Imported(text, mechanism, agreement)


OUTPUT = output_option(None, click.Path(path_type=Path), "Write the scene to SCENE instead of stdout.", "SCENE")
STRICT = option(Part.OUTPUT, "--strict", is_flag=True, help="End with 4 where the scene's motion is not the model's.")
JSON = option(
    Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print the table as one JSON object, on stderr without -o."
)
QUIET = option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print no table.")


@command_of(import_model, EXAMPLES, OUTPUT, STRICT, JSON, QUIET, force_option, name="import")
def command(asked: Asked[Imported], output: Path | None, strict: bool, as_json: bool, quiet: bool, force: bool) -> int:
    from mbproj.results.output_files import SCENE, check_replaceable, write_text

    if output is not None:
        check_replaceable(output, SCENE, force=force)
    model_read = asked.result(folder=output.parent if output else Path())
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
    return int(ExitCode.CHECK_FAILED if strict and not model_read.same else ExitCode.DONE)


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


def said_table(said: Sequence[Said]) -> Table:
    rows = (
        {"element": each.element, "place": str(each.place or ""), "what": each.what, "same": each.same.value}
        for each in said
    )
    return Table.of(rows, "element", "place", "what", "same")
