"""The picture of a scene's start, for `mbproj check --picture`."""

from __future__ import annotations

from pathlib import Path

from mbproj.dynamics import State
from mbproj.errors import InputError, Problem
from mbproj.model import System
from mbproj.scene import Scene
from mbproj.scene.meshes import meshes_of

FORMATS = ("png", "svg", "pdf", "html")


def draw_start(path: Path, scene: Scene, system: System, state: State) -> None:
    """Write the picture or the page. Raises InputError where the name is of neither, or the file may not be
    replaced."""
    from mbproj.outputs import PAGE, write_text
    from mbproj.pages.appearance.motion import motion_at

    ending = path.suffix[1:].lower()
    if ending not in FORMATS:
        message = f"--picture: '{path}' is not the name of a picture"
        raise InputError(Problem(message, hint=f"end it in one of .{', .'.join(FORMATS)}"))
    motion = motion_at(system, state.q)
    if ending == "html":
        from mbproj.pages.data.pages import start_of
        from mbproj.pages.page.write import html

        page = start_of(scene, motion, scene.title or path.stem)
        write_text(path, html(page.title, page.data, page.packer), PAGE)
        return
    from mbproj.figures.kinds.mechanism import draw_start as drawn
    from mbproj.figures.save import save
    from mbproj.pages.appearance.mechanism import look_of
    from mbproj.pages.appearance.view import view_of

    look = look_of(scene, motion, meshes_of(scene))
    save(drawn(look, view_of(scene, motion, look), motion), path)
