"""`mbproj check` and `mbproj.check`: a report on a scene, which tells whether it closes and can run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import ExitCode
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.figure_options import look
from mbproj.commands.options import NOTHING, File, Part, RunSettings, json_option, option
from mbproj.commands.report.text import json_text
from mbproj.joints.table import COORDINATE_UNITS, INERTIA_UNITS, JOINTS

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbproj.base.settings import Settings
    from mbproj.commands.arguments import SceneLike
    from mbproj.commands.report.scene import SceneCheck
    from mbproj.model.system import System
    from mbproj.scene.records import Body, Joint
    from mbproj.scene.scene import Scene

#: The most rows of bodies, joints or coordinates that are listed.
MOST_ROWS = 40
EXAMPLES = (
    ("Say whether the joints close, and how many degrees of freedom there are.", "mbproj check five_bar.yaml"),
    ("Check the scene with another value of a parameter.", "mbproj check five_bar.yaml --set length=1.2"),
)


PICTURE = option(
    Part.OUTPUT,
    "--picture",
    type=File(".html", ".png", ".svg", ".pdf", path_type=Path),
    metavar="FILE",
    help="Draw the start, assembled: a .png, .svg or .pdf, or an .html page.",
)


@declared
def check(
    scene: SceneLike,
    *,
    parameters: Mapping[str, object] = NOTHING,
    **settings: Unpack[RunSettings],
) -> SceneCheck:
    """Reads and assembles a scene without running it.

    Exit code 0: it can run; 2: the input is wrong or does not close; 4: its equations have no unique solution.

    In Python it returns whether the scene can run, and its degrees of freedom. `scene`, `parameters` and the settings
    are as in `run`. Raises InputError where the scene is wrong or does not close. Equations without a unique solution
    are listed in `problems`.
    """
    from mbproj.commands.report.scene import assembled, checked

    what = read(check, locals()).scene
    return checked(what, *assembled(what))


@command_of(check, EXAMPLES, PICTURE, look, json_option)
def command(asked: Asked[SceneCheck], picture: Path | None, as_json: bool) -> int:
    from mbproj.commands.report import scene as fast_forces
    from mbproj.commands.report.scene import assembled, checked
    from mbproj.commands.report.start import check_start, draw_start
    from mbproj.commands.report.text import show_notes
    from mbproj.motion.stiffness import stable_steps

    if picture is not None:
        check_start(picture)
    what = asked.scene
    system, state = assembled(what)
    if picture is not None:
        draw_start(picture, what, system, state)
    report = checked(what, system, state)
    facts = {"scene": asked.path, **report.facts}
    if as_json:
        click.echo(json_text(facts))
    else:
        *start, verdict = _start(what, facts)
        stiff = fast_forces.lines(report.fast, stable_steps(report.fast))
        lines = [*_sizes(what, system, facts), *report.diagnosis.lines(), *start, *stiff, verdict]
        click.echo("\n".join([what.title or Path(asked.path).stem, *lines]))
        show_notes(report.notes)
        for problem in report.problems:
            click.echo(str(problem), err=True)
    return int(ExitCode.DONE if report.can_run else ExitCode.CHECK_FAILED)


def _joint(joint: Joint, carried_out: bool) -> str:
    kind = JOINTS[joint.type]
    if carried_out:
        return f"{joint.type}: {joint.bodies[0]} and {joint.bodies[1]} move as one"
    free = f", free: {', '.join(_coordinates_of(joint))}" if kind.coordinates else ""
    return f"{joint.type} of {joint.bodies[0]} and {joint.bodies[1]}{free}"


def _coordinates_of(joint: Joint) -> Iterator[str]:
    """Yield the coordinates of a joint, with their reflected inertias."""
    for name, row in JOINTS[joint.type].coordinates.items():
        unit = INERTIA_UNITS[COORDINATE_UNITS[row[0]]]
        inertia = joint.reflected_inertia.get(name, 0.0)
        yield f"{name} (reflected inertia {inertia:.6g} {unit})" if inertia else name


def _body(body: Body) -> str:
    x, y, z = (_number(coordinate) for coordinate in body.position)
    return f"{body.name}: {body.mass:.6g} kg, centre of mass at [{x}, {y}, {z}] m"


def _shortened(lines: list[str]) -> list[str]:
    """The first `MOST_ROWS` lines, and the number of the others."""
    left = len(lines) - MOST_ROWS
    return lines if left <= 0 else [*lines[:MOST_ROWS], f"    ... and {left} more"]


def _sizes(scene: Scene, system: System, facts: dict[str, Any]) -> list[str]:
    width = max((len(joint.name) for joint in scene.joints), default=0)
    moving = system.names.joints
    joints = [f"    {joint.name:{width}}  {_joint(joint, joint.name not in moving)}" for joint in scene.joints]
    return [
        f"  {len(scene.bodies)} bodies, {len(scene.joints)} joints, {len(scene.markers)} markers{_driven(scene)}",
        *_shortened([f"    {_body(body)}" for body in scene.bodies]),
        *_shortened(joints),
        f"  {facts['coordinates']} coordinates, {facts['constraints']} constraints{_rank(facts)} degrees of freedom"
        f"{_positions(facts)}{': kinematic' if facts['kinematic'] else ''}",
    ]


def _rank(facts: dict[str, Any]) -> str:
    rank, freedom = facts["rank"], facts["degrees_of_freedom"]
    return f"{'' if rank is None else f' of rank {rank}'}: {'unknown' if freedom is None else freedom}"


def _positions(facts: dict[str, Any]) -> str:
    """The number of freedoms of the pose, where rolling bodies make it larger than that of velocities; else ""."""
    positions = facts["positions"]
    return "" if positions == facts["degrees_of_freedom"] else f" ({positions} positions)"


def _driven(scene: Scene) -> str:
    """The numbers of forces and motions, as far as there are any."""
    counts = {"forces": len(scene.forces), "motions": len(scene.motions)}
    return "".join(f", {count} {what}" for what, count in counts.items() if count)


def _number(value: float) -> str:
    """A coordinate or speed as text; round-off becomes 0."""
    return "0" if abs(value) < 1e-12 else f"{value:.6g}"


def _loads(scene: Scene) -> str:
    """The loads on the mechanism, and whether any constraint depends on time."""
    forces = ", ".join(["gravity", *(f"'{force.name}'" for force in scene.forces)])
    motions = ", ".join(f"'{motion.name}'" for motion in scene.motions)
    driven = f"driven by {motions}" if motions else "no motions, so that no constraint depends on time"
    return f"  loads: {forces}; {driven}"


def _formulation(scene: Scene, facts: dict[str, Any]) -> list[str]:
    """The formulation, the reason for it, and the order in which the equations are eliminated."""
    if facts["formulation"] is None:
        return []
    lines = [
        f"  {facts['formulation']} formulation: {facts['formulation_why']}",
        _loads(scene),
    ]
    order = facts["elimination"]
    if order:
        loops = (
            f", {order['core_joints']} joints in loops by block Cholesky ({order['core_numbers']} numbers, "
            f"{order['core_fill']} of them fill)"
            if order["core_joints"]
            else ""
        )
        lines.append(f"  elimination: {order['eliminated_bodies']} bodies from the leaves{loops}")
    return lines


def _expectations(scene: Scene) -> list[str]:
    """The scene's expectations, line by line."""
    from mbproj.commands.report.summary import expected_text, subject

    if not scene.expectations:
        return []
    width = max(len(each.name) for each in scene.expectations)
    rows = [f"    {each.name:{width}}  {subject(each)}: {expected_text(each)}" for each in scene.expectations]
    return [f"  {len(rows)} expectations", *_shortened(rows)]


def _start(scene: Scene, facts: dict[str, Any]) -> list[str]:
    from mbproj.commands.report.start import frictions, ropes, stops
    from mbproj.commands.report.summary import projection_words, step_words

    settings = scene.settings
    duration = "no duration" if settings.duration is None else f"{settings.duration:g} s"
    step = "no step" if settings.step is None and settings.tolerance is None else step_words(settings)
    length, angle = facts["moved_by"]
    start = facts["coordinates_at_start"]
    width = max(map(len, start), default=0)
    rows = [
        f"    {name:{width}}  {_number(entry['value'])} {entry['unit']}, {_number(entry['speed'])} {entry['unit']}/s"
        for name, entry in start.items()
    ]
    return [
        f"  assembled: open by {facts['position_violation']:.1e} (m, rad), "
        f"moving apart at {facts['velocity_violation']:.1e} per s; "
        f"bodies moved from their guess by up to {length:.2g} m and {angle:.2g} rad",
        *_shortened(rows),
        *stops(facts["stops_at_start"]),
        *frictions(facts["frictions_at_start"], " at the start"),
        *ropes(facts["ropes_at_start"]),
        *_formulation(scene, facts),
        f"  {projection_words(settings.projection)}, {settings.integrator}, {step}, {duration}",
        *_expectations(scene),
        f"  can run{_missing_options(settings)}" if facts["can_run"] else "  cannot run",
    ]


def _missing_options(settings: Settings) -> str:
    """The options that a run still needs, because the scene does not have these settings."""
    sized = settings.step is not None or settings.tolerance is not None or settings.kinematic is True
    missing = {"--duration": settings.duration is None, "--step or --tolerance": not sized}
    options = [option for option, lacks in missing.items() if lacks]
    return f", given {' and '.join(options)}" if options else ""
