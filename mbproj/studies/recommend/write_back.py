"""Writing a recommendation into its scene file: only the `simulation` block changes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mbproj.errors import InputError, Place, Problem, placed_at
from mbproj.output_files import SCENE, check_rewritable, write_text
from mbproj.scene import read_scene_text
from mbproj.scene.read import Scene
from mbproj.scene.records import Settings
from mbproj.scene.text.rewrite import Changes, with_simulation
from mbproj.scene.text.source import read_text
from mbproj.settings import HOW, SETTINGS
from mbproj.studies.measure.setting import Setting, as_text


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
    recommended = [entry for entry in SETTINGS.values() if entry.decides == HOW or entry.name == "output_step"]
    differing = [entry for entry in recommended if entry.of(after) != entry.of(before)]
    changes: dict[str, Any] = {entry.key: _text(entry.of(after)) for entry in differing if len(entry.path) == 1}
    if after.projection != before.projection:
        inner = {entry.key: (entry.of(after), entry.usual) for entry in recommended if len(entry.path) == 2}
        own = {key: None if value == usual else _text(value) for key, (value, usual) in inner.items()}
        changes["projection"] = {**own, "method": after.projection.method}
    return changes


def _text(value: Any) -> str | None:
    return None if value is None else f"[{as_text(value)}]" if isinstance(value, tuple) else as_text(value)


def _by_hand(changes: Changes) -> str:
    return ", ".join(f"{name}: {value}" for name, value in changes.items() if isinstance(value, str))
