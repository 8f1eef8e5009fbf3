"""The start of a scene: its picture, and the lines on its stops, frictions and ropes."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING

from mbproj.base.errors import InputError, Problem
from mbproj.scene.meshes import meshes_of

if TYPE_CHECKING:
    from mbproj.commands.report.scene import RopeAtStart
    from mbproj.equations.assembly.assemble import State
    from mbproj.model.system import System
    from mbproj.motion.contacts import AtStart, RubsAtStart
    from mbproj.scene.scene import Scene

FORMATS = ("png", "svg", "pdf", "html")


def check_start(path: Path) -> None:
    """Raises InputError where the name is of no picture or page, or the file may not be written."""
    from mbproj.results.output_files import PAGE, check_replaceable, picture

    ending = path.suffix[1:].lower()
    if ending not in FORMATS:
        message = f"--picture: '{path}' is not the name of a picture"
        raise InputError(Problem(message, hint=f"end it in one of .{', .'.join(FORMATS)}"))
    kind = PAGE if ending == "html" else picture(ending)
    check_replaceable(path, kind, hint="choose another with --picture")


def draw_start(path: Path, scene: Scene, system: System, state: State) -> None:
    """Write the picture or the page."""
    from mbproj.results.output_files import PAGE, write_text
    from mbproj.show.appearance.motion import motion_at

    motion = motion_at(system, state.q)
    if path.suffix.lower() == ".html":
        from mbproj.show.page.pages import start_of
        from mbproj.show.page.write import html

        page = start_of(scene, motion, scene.title or path.stem)
        write_text(path, html(page.title, page.data, page.packer), PAGE)
        return
    from mbproj.show.appearance.mechanism import look_of, view_of
    from mbproj.show.figures.mechanism import draw_start as drawn
    from mbproj.show.figures.style import save

    look = look_of(scene, motion, meshes_of(scene))
    save(drawn(look, view_of(scene, motion, look), motion), path)


#: The most frictions that are named, and the part of its largest force below which a friction bears only round-off.
NAMED, NOTHING = 8, 1e-12


def stops(at_start: Mapping[str, AtStart]) -> list[str]:
    """The number of stops, and those that touch."""
    touching = ", ".join(f"'{name}'" for name, entry in at_start.items() if entry["touches"])
    said = f"touching at the start: {touching}" if touching else "none touches at the start"
    return [f"  {len(at_start)} stops, {said}"] if at_start else []


def frictions(at_start: Mapping[str, RubsAtStart], where: str = "") -> list[str]:
    """The number of dry frictions, and those that stick. `where` is a phrase such as "at the start"."""
    if not at_start:
        return []
    sticking = [f"'{name}' bears {_share_of_load(entry)}" for name, entry in at_start.items() if entry["sticks"]]
    more = [f"and {len(sticking) - NAMED} more"] if len(sticking) > NAMED else []
    said = f"sticking{where}: {', '.join([*sticking[:NAMED], *more])}" if sticking else f"none sticks{where}"
    count = "1 dry friction" if len(at_start) == 1 else f"{len(at_start)} dry frictions"
    return [f"  {count}, {said}"]


def ropes(at_start: Mapping[str, RopeAtStart]) -> list[str]:
    """The length of each rope, and its angles of wrap."""
    lines = []
    for name, rope in list(at_start.items())[:NAMED]:
        around = ", ".join(f"{degrees(wrap['angle']):.4g} deg around '{wrap['body']}'" for wrap in rope["wraps"])
        lines.append(f"  rope '{name}': {rope['length']:.6g} m{f', wrapped {around}' if around else ''}")
    return [*lines, f"  and {len(at_start) - NAMED} ropes more"] if len(at_start) > NAMED else lines


def _share_of_load(entry: RubsAtStart) -> str:
    """The force that a friction bears, relative to the largest that it can."""
    size, most = abs(entry["force"]), entry["static"]
    return f"{size if size > NOTHING * most else 0.0:.4g} of {most:.4g} {'N m' if entry['unit'] == 'rad' else 'N'}"
