"""Writing a recommendation into its scene file: only the `simulation` block changes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mbproj.errors import InputError, Place, Problem, placed_at
from mbproj.outputs import SCENE, check_rewritable, write_text
from mbproj.scene import read_scene_text
from mbproj.scene.records import ProjectionSettings, Scene, Settings
from mbproj.scene.text.rewrite import Changes, with_simulation
from mbproj.scene.text.source import read_text
from mbproj.studies.measure.setting import Setting, shortest


def write_back(scene: Scene, settings: Settings) -> Path:
    """Writes `settings`, without the duration, into the scene's file and returns its path. Comments stay. The file is
    replaced in one operation.

    Raises InputError where the scene is no file, its block cannot be changed in place, or it cannot be written.
    """
    path = check_rewritable(scene.path)
    written = read_scene_text(scene.text, str(path)).settings
    place, changes = Place(str(path)), changes_to(written, settings)
    failed = Problem("the simulation block cannot be changed in place", place, f"write by hand: {_by_hand(changes)}")
    try:
        text = with_simulation(scene.text, changes)
        settings_read = read_scene_text(text, str(path)).settings
    except (ValueError, InputError) as error:
        raise InputError(failed) from error
    if Setting.of(settings_read) != Setting.of(settings) or settings_read.output_step != settings.output_step:
        raise InputError(failed)
    if read_text(path) != scene.text:
        raise InputError(Problem("has changed since it was read", place, f"write by hand: {_by_hand(changes)}"))
    mark = "\ufeff" if path.read_bytes().startswith(b"\xef\xbb\xbf") else ""
    with placed_at(place):
        return write_text(path, mark + text, SCENE, force=True, hint="write by hand")


def changes_to(before: Settings, after: Settings) -> Changes:
    """The changes of the `simulation` block, by key."""
    changes: dict[str, Any] = {
        name: _text(getattr(after, name))
        for name in ("integrator", "step", "tolerance", "formulation", "acceleration", "output_step")
        if getattr(after, name) != getattr(before, name)
    }
    if after.projection != before.projection:
        usual = vars(ProjectionSettings())
        own = {name: value for name, value in vars(after.projection).items() if value != usual[name]}
        others = {name: _text(own.get(name)) for name in usual if name != "method"}
        changes["projection"] = {"method": after.projection.method, **others}
    return changes


def _text(value: Any) -> str | None:
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, bool):
        return str(value).lower()
    return shortest(value) if isinstance(value, float) else str(value)


def _by_hand(changes: Changes) -> str:
    return ", ".join(f"{name}: {value}" for name, value in changes.items() if isinstance(value, str))
