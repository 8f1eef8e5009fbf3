"""`mbproj branches` and `mbproj.branches`: all assemblies of a mechanism at a pose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.errors import ExitCode, InputError, Place, Problem, choose_from
from mbproj.base.thresholds import THRESHOLDS
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.figure_options import check_picture, look
from mbproj.commands.kinds import Count
from mbproj.commands.options import NOTHING, File, Option, Part, force_option, json_option, option
from mbproj.commands.report.text import json_text
from mbproj.equations.assembly.assemble import State, assemble, moved_by
from mbproj.equations.assembly.assemblies import Assemblies, Assembly, assemblies, conditions, freedom_left
from mbproj.equations.assembly.compiled import compile_system
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.system import Conditions, System
from mbproj.results.output_files import SCENE, make_folder, write_text
from mbproj.scene.changes import Changes, text_with_changes
from mbproj.scene.fields.quantities import Number, given_number
from mbproj.scene.scene import Scene, read_scene_text
from mbproj.scene.settings import placed_in
from mbproj.show.appearance.motion import motion_at

if TYPE_CHECKING:
    from mbproj.commands.arguments import SceneLike

#: The most joint coordinates that are printed for an assembly; --json has all.
SHOWN = 8
#: The most coordinates that a message names.
NAMED = 8
EXAMPLES = (
    ("List both assemblies of a four-bar at its crank's angle.", "mbproj branches planar_four_bar.yaml --hold A.angle"),
    (
        "Write each as a scene that starts there.",
        "mbproj branches planar_four_bar.yaml --hold A.angle --write starts",
    ),
)
Hold = Annotated[
    "str | Sequence[str]",
    Option(
        Part.WHAT,
        "Hold a joint's coordinate at a value, A.angle=30deg, or at its start; repeatable.",
        None,
        "NAME[=VALUE]",
        many=True,
    ),
]
Starts = Annotated[
    "int | None",
    Option(Part.EFFORT, "Search from N random poses [default: until each was found often].", Count(1), "N"),
]


@declared
def branches(
    scene: SceneLike,
    *,
    hold: Hold = (),
    starts: Starts = None,
    parameters: Mapping[str, object] = NOTHING,
) -> Assemblies:
    """Finds all assemblies of a scene, in which its joints close.

    They satisfy its motions at the start and hold the coordinates of --hold; no degree of freedom may be left. The
    search begins from random poses within the bodies' reach. The report tells how rare an assembly is that it may have
    missed.

    In Python `scene` and `parameters` are as in `run`. Raises InputError where the scene is wrong or degrees of freedom
    are left.
    """
    asked = read(branches, locals())
    system, state, held = _ready(asked.scene, asked.hold)
    return assemblies(system.at_positions, state, held, asked.starts)


WRITE = option(
    Part.OUTPUT,
    "--write",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Write each assembly as a scene that starts there.",
)
PICTURE = option(
    Part.OUTPUT,
    "--picture",
    type=File(".png", ".svg", ".pdf", path_type=Path),
    metavar="FILE",
    help="Draw them side by side.",
)


@command_of(branches, EXAMPLES, WRITE, PICTURE, look, force_option, json_option)
def command(asked: Asked[Assemblies], write: Path | None, picture: Path | None, force: bool, as_json: bool) -> int:
    what = asked.scene
    check_picture(picture, force=force, option="--picture")
    if write is not None:
        check_starts(what, write)
    system, state, held = _ready(what, asked.given["hold"])
    all_assemblies = assemblies(system.at_positions, state, held, asked.given.get("starts"))
    written: list[str] = []
    if write is not None:
        written = [str(path) for path in write_starts(what, system, all_assemblies, held, write, force=force)]
    if picture is not None:
        _draw(what, system, all_assemblies, picture, force=force)
    if as_json:
        drawn = None if picture is None else str(picture)
        told = _facts(system, all_assemblies)
        click.echo(json_text({"scene": asked.path, **told, "written": written, "picture": drawn}))
    else:
        click.echo("\n".join(_lines(what.title or asked.path, system, all_assemblies)))
        for path in [*written, *([] if picture is None else [str(picture)])]:
            click.echo(path)
        if all_assemblies.is_unsure:
            rare = f"assemblies that draw less than {100.0 * all_assemblies.share:.2g} % of the starts may be missed"
            more = f"search from more poses, --starts {4 * all_assemblies.starts}"
            click.echo(f"note: {rare}; {more}", err=True)
    return int(ExitCode.DONE)


def _ready(scene: Scene, hold: Sequence[str]) -> tuple[System, State, Conditions]:
    """Compile and assemble a scene, and return also the held coordinates. Raises InputError where degrees of freedom
    are left."""
    with placed_in(scene):
        system = compile_system(scene)
        state = assembled_start(scene, system)
    return system, state, _held_coordinates(scene, system, state, hold)


def _held_coordinates(scene: Scene, system: System, state: State, hold: Sequence[str]) -> Conditions:
    """The coordinates that the scene's joints fix at the start, and those of `hold`. Raises InputError where degrees of
    freedom are left."""
    names, units = list(system.names.coordinates), system.names.coordinate_units
    start = initial_guess(scene, system).start
    wanted: dict[int, float | None] = dict(zip(start.index.tolist(), start.value.tolist(), strict=True))
    for text in hold:
        name, equals, value = (part.strip() for part in text.partition("="))
        if name not in names:
            raise InputError(Problem(f"there is no coordinate '{name}'", Place("--hold"), choose_from(name, names)))
        index = names.index(name)
        wanted[index] = given_number(value, f"--hold {name}", Number(units[index])) if equals else None
    held = conditions(system, state, iter(wanted.items()))
    left = freedom_left(system.at_positions, state, held)
    if left:
        count = f"{left} degrees of freedom are" if left > 1 else "1 degree of freedom is"
        free = [name for index, name in enumerate(names) if index not in wanted]
        able = f"hold {left} of the coordinates {', '.join(free[:NAMED])}" if free else "drive them by 'motions'"
        raise InputError(Problem(f"{count} left: assemblies cannot be counted", Place("--hold"), able))
    return held


def _draw(what: Scene, system: System, all_assemblies: Assemblies, picture: Path, *, force: bool) -> None:
    """Draw the assemblies side by side, at the same scale."""
    import numpy as np

    from mbproj.scene.meshes import meshes_of
    from mbproj.show.appearance.mechanism import look_of, view_of
    from mbproj.show.appearance.motion import PoseHistory
    from mbproj.show.figures.mechanism import draw_side_by_side
    from mbproj.show.figures.style import save

    each = [motion_at(system, assembly.q) for assembly in all_assemblies.assemblies]
    position, orientation = (
        np.concatenate([getattr(one, name) for one in each]) for name in ("position", "orientation")
    )
    motion = PoseHistory(np.arange(float(len(each))), position, orientation)
    look = look_of(what, motion, meshes_of(what))
    save(draw_side_by_side(look, view_of(what, motion, look), motion), picture, force=force)


def _facts(system: System, all_assemblies: Assemblies) -> dict[str, Any]:
    """The assemblies as a dictionary for JSON, with stable keys."""
    names = system.names.coordinates
    return {
        "assemblies": [
            {
                "coordinates": dict(zip(names, each.coordinates.tolist(), strict=True)),
                "bodies": _poses(system, each),
                "found": each.hits,
                "distance_to_singular": each.distance,
                "singular": each.is_singular,
                "at_start": number == 0,
            }
            for number, each in enumerate(all_assemblies.assemblies)
        ],
        "units": dict(zip(names, system.names.coordinate_units, strict=True)),
        "starts": all_assemblies.starts,
        "closed": all_assemblies.closed,
        "share": all_assemblies.share,
        "missed": THRESHOLDS.missed,
    }


def _poses(system: System, each: Assembly) -> dict[str, dict[str, list[float]]]:
    motion = motion_at(system, each.q)
    return {
        name: {"position": motion.position[0, k].tolist(), "orientation": motion.orientation[0, k].tolist()}
        for k, name in enumerate(system.names.bodies)
    }


def _lines(title: str, system: System, all_assemblies: Assemblies) -> list[str]:
    """The report on the assemblies, line by line."""
    from mbproj.commands.report.text import columns

    names = list(system.names.coordinates)[:SHOWN]
    rows = [
        [
            f"{number}{' (the start)' if number == 1 else ''}",
            *(f"{0.0 if abs(value) < 1e-12 else value:.6g}" for value in each.coordinates[: len(names)]),
            str(each.hits),
            "singular: assemblies meet here" if each.is_singular else f"{each.distance:.2g}",
        ]
        for number, each in enumerate(all_assemblies.assemblies, 1)
    ]
    more = len(system.names.coordinates) - len(names)
    return [
        f"{title}: {len(all_assemblies.assemblies)} assembl{'y' if len(all_assemblies.assemblies) == 1 else 'ies'}",
        columns(["", *names, "found", "distance"], rows),
        *([f"  and {more} more coordinates, which --json has"] if more > 0 else []),
        f"  {all_assemblies.closed:,} of {all_assemblies.starts:,} random starts led to one; {_doubt(all_assemblies)}",
    ]


def _doubt(all_assemblies: Assemblies) -> str:
    share = f"{100.0 * all_assemblies.share:.2g} % of such starts or more"
    return f"one that draws {share} was missed with a probability of at most {THRESHOLDS.missed:g}"


# --- Assemblies written as scenes -------------------------------------------------------------------------------------
# The text stays, except that bodies start at other poses and held coordinates have their values.


HINT = "choose another folder with --write"


def check_starts(scene: Scene, folder: Path) -> None:
    """Make the folder. Raises InputError where it cannot be made, or parameters were changed."""
    if scene.overrides:
        problem = Problem("--set has changed parameters, which the file does not have", Place("--write"))
        raise InputError(problem)
    make_folder(folder, HINT)


def write_starts(
    scene: Scene, system: System, all_assemblies: Assemblies, held: Conditions, folder: Path, *, force: bool
) -> Iterator[Path]:
    """Write DIR/<scene>_<number>.yaml for each assembly, from 1 on. Raises InputError where the text cannot be changed
    so that the scene starts there."""
    stem = folder / (scene.path.stem if scene.path is not None else "scene")
    for number, each in enumerate(all_assemblies.assemblies, 1):
        try:
            text = text_with_changes(scene.text, _changes(scene, system, each, held))
            read = read_scene_text(text, str(scene.path))
            rebuilt = compile_system(read)
            reached = assemble(rebuilt, initial_guess(read, rebuilt))
        except (ValueError, InputError) as error:
            raise InputError(Problem(f"assembly {number} cannot be written: {error}", Place("--write"))) from error
        if max(moved_by(reached.q, each.q)) > THRESHOLDS.same_pose:
            problem = Problem(f"assembly {number} cannot be written: from there the scene closes elsewhere")
            raise InputError(problem)
        yield write_text(Path(f"{stem}_{number}.yaml"), text, SCENE, force=force, hint=HINT)


def _changes(scene: Scene, system: System, each: Assembly, held: Conditions) -> Changes:
    """The start of each body, and the values of held joint coordinates, as changes of the text."""
    motion = motion_at(system, each.q)
    bodies: dict[str, Changes] = {
        body.name: {"start": _pose(motion.position[0, k].tolist(), motion.orientation[0, k].tolist())}
        for k, body in enumerate(scene.bodies)
    }
    joints: dict[str, dict[str, str | None]] = {}
    for index, value in zip(held.index.tolist(), held.value.tolist(), strict=True):
        joint, _, coordinate = system.names.coordinates[index].rpartition(".")
        joints.setdefault(joint, {})[coordinate] = repr(value)
    return {"bodies": bodies, **({"joints": joints} if joints else {})}


def _pose(position: list[float], orientation: list[float]) -> Changes:
    return {"position": repr(position), "orientation": f"{{quaternion: {orientation!r}}}"}
