"""Implements `Scene.with_` and `Scene.to_yaml`: a scene read again with changes, or written with them; and its display
in a prompt and a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from html import escape

from mbproj.errors import Place
from mbproj.scene.read import Scene, read_scene_text
from mbproj.scene.settings import merge, place_of, settings_of, values_of
from mbproj.scene.text.changes import changed
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import MappingNode, document, flow, from_value

#: The most items of a kind that a prompt shows.
SHOWN = 6


def with_changes(scene: Scene, changes: Mapping[str, object]) -> Scene:
    """The scene with these values. Settings that were given in Python stay, unless the changes name them."""
    again = _read(scene, {**scene.overrides, **changes})
    given = {name: value for name, value in scene.given_settings.items() if ".".join(place_of(name)) not in changes}
    settings = settings_of(merge(values_of(again), given)) if given else again.settings
    return replace(again, path=scene.path, settings=settings, elements=scene.elements)


def to_yaml(scene: Scene) -> str:
    """A text from which the same scene is read. Comments are lost where something was changed. Raises InputError where
    there is no such text, as for expectations after the end of a run that was made shorter in Python."""
    if scene.elements:
        raise ValueError(f"elements from Python cannot be written: {', '.join(each.name for each in scene.elements)}")
    given = {".".join(place_of(name)): value for name, value in scene.given_settings.items()}
    changes = {**scene.overrides, **{path: flow(from_value(value, Place(""))) for path, value in given.items()}}
    if not changes:
        return scene.text
    root, _ = compose(scene.text, "scene")
    assert isinstance(root, MappingNode)
    text = document(changed(root, changes)[0])
    read_scene_text(text, str(scene.path or "scene"))
    return text


def given_settings(scene: Scene) -> dict[str, object]:
    """The settings of the scene that differ from those of its text, which is read again: they were given in Python."""
    of_text = values_of(_read(scene, scene.overrides))
    return {name: value for name, value in values_of(scene).items() if of_text.get(name) != value}


def _read(scene: Scene, changes: Mapping[str, object]) -> Scene:
    return read_scene_text(scene.text, str(scene.path or "scene"), changes)


def as_text(scene: Scene) -> str:
    """The text that a prompt shows of a scene."""
    lines = _lines(scene)
    width = max(len(word) for word, _ in lines)
    return "\n".join([f"Scene: {scene.title or 'untitled'}", *(f"  {word:{width}}  {what}" for word, what in lines)])


def as_html(scene: Scene) -> str:
    """The table that a notebook shows of a scene."""
    cells = (f"<tr><th>{escape(word)}</th><td>{escape(what)}</td></tr>" for word, what in _lines(scene))
    return f"<table><caption>{escape(scene.title or 'untitled')}</caption>{''.join(cells)}</table>"


def _lines(scene: Scene) -> list[tuple[str, str]]:
    """The lines that are shown of a scene, as (word, items)."""
    settings = scene.settings
    step = f"step {settings.step:g} s" if settings.step is not None else ""
    step = f"tolerance {settings.tolerance:g}" if settings.tolerance is not None else step
    duration = f"{settings.duration:g} s" if settings.duration is not None else ""
    groups = [
        ("bodies", [f"{body.name} {body.mass:.4g} kg" for body in scene.bodies]),
        ("joints", [f"{joint.name} {joint.type}" for joint in scene.joints]),
        ("forces", [force.name for force in scene.forces]),
        ("elements", [element.name for element in scene.elements]),
        ("motions", [motion.name for motion in scene.motions]),
        ("markers", [marker.name for marker in scene.markers]),
        ("expectations", [expected.name for expected in scene.expectations]),
        ("parameters", [f"{name} = {value:.6g}" for name, value in scene.parameters.items()]),
        ("simulation", [part for part in (duration, settings.integrator, step, settings.projection.method) if part]),
    ]
    return [(word, _some(parts)) for word, parts in groups if parts]


def _some(parts: list[str]) -> str:
    more = f", ... ({len(parts)} in all)" if len(parts) > SHOWN else ""
    return ", ".join(parts[:SHOWN]) + more
