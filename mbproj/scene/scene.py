"""A scene: read from a file, a text or parts, or an InputError with all problems; changed, written and shown."""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field, replace
from functools import cached_property, partial
from html import escape
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

from mbproj.base.cases import cases_in
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem
from mbproj.base.registry import calling, load
from mbproj.base.settings import Settings
from mbproj.base.text import text_of
from mbproj.scene.blocks.coordinates import with_coordinates
from mbproj.scene.blocks.expectations import expectations_of, unsampled
from mbproj.scene.changes import changed
from mbproj.scene.fields.reading import Reading, declares_units, in_text_order, items_of, number_at
from mbproj.scene.grammar import SCENE, SIMULATION
from mbproj.scene.records import Body, Expectation, Force, Joint, JointForce, KeyPath, Marker, Motion, Quantity, Vector
from mbproj.scene.settings import Merged, by_name, check_settings, merge, place_of, read_options, settings_of, values_of
from mbproj.scene.text.document import MAX_BYTES, compose, read_text
from mbproj.scene.text.nodes import MappingNode, ScalarNode, describe, document, flow, from_value, mapping

if TYPE_CHECKING:
    from mbproj.functions.elements import Controller, Element, ScalarState, Signal
    from mbproj.functions.space_curve import SpaceTrack, Track
    from mbproj.scene.text.reading_cache import ReadingCache


#: The blocks whose expressions may name signals, states and coordinates.
WITH_EXPRESSIONS = ("forces", "signals", "states", "controllers")
_NOTHING: Mapping[str, Any] = {}
#: The most characters of a text that stays in memory after it was read.
KEPT_CHARACTERS = 100_000


@dataclass(frozen=True)
class Scene:
    """A whole scene file. `text` is the file as read, `path` its path (None for text from elsewhere). `overrides` are
    the changes of --set, `places` the place of each key, `notes` those on legal input that may be a mistake. `elements`
    come from Python; the file has none."""

    title: str
    gravity: Annotated[Vector, Quantity("m/s^2", "direction")]
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    markers: tuple[Marker, ...]
    parameters: Mapping[str, float]
    settings: Settings
    text: str = field(repr=False)
    path: Path | None
    overrides: Mapping[str, str]
    places: Mapping[KeyPath, Place] = field(repr=False, compare=False)
    forces: tuple[Force, ...] = ()
    motions: tuple[Motion, ...] = ()
    expectations: tuple[Expectation, ...] = ()
    notes: tuple[Problem, ...] = field(default=(), repr=False, compare=False)
    signals: tuple[Signal, ...] = ()
    states: tuple[ScalarState, ...] = ()
    controllers: tuple[Controller, ...] = ()
    elements: tuple[Element, ...] = ()
    curves: tuple[Track | SpaceTrack, ...] = ()

    def place(self, *path: str | int) -> Place | None:
        """The place of the value at `path`, or of the nearest value around it."""
        for length in range(len(path), -1, -1):
            if path[:length] in self.places:
                return self.places[path[:length]]
        return None

    @cached_property
    def given_settings(self) -> Mapping[str, object]:
        """The settings that Python gave beside those of the text, by name."""

        return given_settings(self)

    @staticmethod
    def build(
        *,
        bodies: Mapping[str, object],
        gravity: Sequence[object],
        curves: Mapping[str, object] | None = None,
        joints: Mapping[str, object] | None = None,
        forces: Mapping[str, object] | None = None,
        motions: Mapping[str, object] | None = None,
        signals: Mapping[str, object] | None = None,
        states: Mapping[str, object] | None = None,
        controllers: Mapping[str, object] | None = None,
        markers: Mapping[str, object] | None = None,
        expect: Mapping[str, object] | None = None,
        parameters: Mapping[str, object] | None = None,
        simulation: Mapping[str, object] | None = None,
        title: str | None = None,
    ) -> Scene:
        """The scene of these blocks, each of items by name: `mbproj.Body(...)` and others, or mappings. Numbers may be
        of NumPy, text with a unit, expressions. Raises InputError, whose problems name the arguments."""
        blocks = locals()

        return build(blocks)

    def with_(self, changes: Mapping[str, object] = MappingProxyType({}), /, **named: object) -> Scene:
        """The scene with other parameters, or values by their paths: `scene.with_(**{"bodies.bar3.mass": 2})`. Settings
        that were given in Python stay. Raises InputError as `read_scene`."""

        return with_changes(self, {**changes, **named})

    def __repr__(self) -> str:

        return as_text(self)

    def _repr_html_(self) -> str:

        return as_html(self)

    def to_yaml(self) -> str:
        """A text from which the same scene is read: its own text, or one with its changes. Raises ValueError where the
        scene has elements from Python."""

        return to_yaml(self)


def read_scene(
    path: str | Path, parameters: Mapping[str, object] = _NOTHING, simulation: Mapping[str, object] = _NOTHING
) -> Scene:
    """The scene in the file at `path`.

    `parameters` replaces parameters of the scene, or any value by its path, as "bodies.bar1.mass" (text of an
    expression, a number, or an array of NumPy). `simulation` replaces settings, by their names in `base.settings`;
    None is as if not given. Raises InputError with every problem, in text order.
    """
    return _taken_apart(read_text(Path(path)), str(path), Path(path)).scene(parameters, simulation)


def read_scene_text(
    text: str | Mapping[str, object],
    name: str = "<text>",
    parameters: Mapping[str, object] = _NOTHING,
    simulation: Mapping[str, object] = _NOTHING,
) -> Scene:
    """The scene in `text`, which messages call `name`; otherwise as `read_scene`. `text` may also be a mapping with
    names, numbers, lists and mappings, as a YAML reader returns it. Raises TypeError where `name` is no text."""
    if not isinstance(name, str):
        raise TypeError("the second argument is what messages call the text: give parameters={...} by its name")
    if isinstance(text, Mapping):
        text = document(mapping(text))
    if len(text_of(text, "a scene that is no mapping")) > MAX_BYTES:
        raise InputError(Problem(f"the text is longer than {MAX_BYTES // 1_000_000} million characters", Place(name)))
    return _taken_apart(text.removeprefix("\ufeff"), name, None).scene(parameters, simulation)


class SceneText:
    """A scene's text, parsed once. `scene` returns scenes with other values, for which it parses no YAML again.

    Messages call it `name`. Raises InputError where it is no YAML, or no mapping."""

    def __init__(self, text: str, name: str, path: Path | None = None) -> None:
        with _without_cycles():
            root, self._problems = compose(text, name)
        if not isinstance(root, MappingNode):
            wrong = f"a scene is a mapping of keys, found {describe(root)}"
            problem = Problem(wrong, root.place, "it begins with 'mbproj: 1'")
            raise InputError(in_text_order([*self._problems, problem]))
        self.root, self.text, self.path = root, text, path
        self._name = name
        self._is_read = False
        self._cache: ReadingCache | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        """Other processes parse the text once more."""
        return SceneText, (self.text, self._name, self.path)

    @property
    def whole(self) -> str:
        """All data that determine its scenes: the text, and the numbers of the files that it names."""
        _, from_files, _ = _with_matrices(self.root, self.path)
        return "\n".join([self.text, *(f"{path}: {numbers}" for path, numbers in from_files.items())])

    def units(self) -> Mapping[KeyPath, str]:
        """The SI units of the scene's numbers, by their paths, where they are known."""
        reading = _reading(self.root)
        SCENE.read(self.root, (), reading)
        return reading.units

    def numbers(self, paths: Sequence[str], parameters: Mapping[str, object] = _NOTHING) -> list[float]:
        """The numbers at these paths, in SI, with these changes; NaN where the scene has none there, or no constant."""
        root, _ = _changed(self.root, parameters)
        reading = _reading(root)
        SCENE.read(root, (), reading)
        return [number_at(root, path, reading) for path in paths]

    def scene(self, parameters: Mapping[str, object] = _NOTHING, simulation: Mapping[str, object] = _NOTHING) -> Scene:
        """The scene with these changes, as `read_scene` takes them."""
        root, wrong_changes = _changed(self.root, parameters)
        root, from_files, wrong_files = _with_matrices(root, self.path)
        # The first reading stores nothing, since most texts are read once; nor do readings of several cases, or with
        # other units, in which expressions that name them are checked again.
        of_cases, other_units = cases_in(parameters) is not None, declares_units(parameters)
        cache = None if other_units else self._cache
        if cache is None and self._is_read and not of_cases and not other_units:
            from mbproj.scene.text.reading_cache import ReadingCache

            cache = ReadingCache()
        places = {**(self._cache.places if self._cache else {}), (): root.place}
        problems = [*self._problems, *wrong_changes, *wrong_files]
        reading = replace(_reading(root), places=places, problems=problems, cache=cache)
        with _without_cycles():
            blocks: Mapping[str, Any] | None = SCENE.read(root, (), reading)
        settings = _settings(root, blocks, simulation, reading)
        if blocks is not None and not blocks.keys().isdisjoint(WITH_EXPRESSIONS):
            blocks = load("mbproj.scene.blocks.signals:with_known_names")(blocks, settings, reading)
        if blocks is not None and not any(path.split(".")[0] == "simulation" for path in parameters):
            _check_times(blocks, reading)
        if reading.problems or blocks is None or settings is None:
            raise InputError(in_text_order(reading.problems))
        if cache is not None and not cache.is_full:
            cache.close(reading.names, reading.items, reading.places)
            self._cache = cache
        self._is_read = self._is_read or not of_cases
        return Scene(
            title=blocks.get("title", ""),
            gravity=blocks["gravity"],
            bodies=tuple(blocks["bodies"].values()),
            curves=tuple(blocks.get("curves", {}).values()),
            joints=tuple(_connected(blocks)),
            forces=tuple(_on_coordinates(blocks.get("forces", {}), blocks.get("joints", {}))),
            motions=tuple(blocks.get("motions", {}).values()),
            markers=tuple(blocks.get("markers", {}).values()),
            expectations=tuple(expectations_of(blocks)),
            parameters=blocks.get("parameters", {}),
            signals=tuple(blocks.get("signals", {}).values()),
            states=tuple(blocks.get("states", {}).values()),
            controllers=tuple(blocks.get("controllers", {}).values()),
            settings=settings,
            text=self.text,
            path=self.path,
            overrides={**{key: _as_text(value) for key, value in parameters.items()}, **from_files},
            places=reading.places,
            notes=tuple(in_text_order(reading.notes)),
        )


@contextmanager
def _without_cycles() -> Iterator[None]:
    """A context without the search for cycles of garbage, which took a third of the time for 10,000 bodies. Nodes and
    records have no cycles. Afterwards all objects count as old, else the next search would go through them at once."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if not gc.get_freeze_count():
            gc.freeze()
            gc.unfreeze()
        if enabled:
            gc.enable()


def _changed(root: MappingNode, parameters: Mapping[str, object]) -> tuple[MappingNode, list[Problem]]:
    """The document with these changes, and the problems of the changes."""
    changed: tuple[MappingNode, list[Problem]] = (root, [])
    if parameters:
        changed = load("mbproj.scene.changes:changed")(root, parameters)
    return changed


def _with_matrices(root: MappingNode, scene: Path | None) -> tuple[MappingNode, Mapping[str, str], list[Problem]]:
    """The document with the numbers of files that its signals name, these numbers as changes, and the problems."""
    filled: tuple[MappingNode, Mapping[str, str], list[Problem]] = (root, {}, [])
    if "signals" in root.values:
        filled = load("mbproj.scene.blocks.control_blocks:with_matrices")(root, scene)
    return filled


class _LastText(threading.local):
    """The text that a thread has read last, and its `SceneText`."""

    source: tuple[str, str, Path | None] | None = None
    taken_apart: SceneText | None = None


_last = _LastText()


def _taken_apart(text: str, name: str, path: Path | None) -> SceneText:
    """The `SceneText` of a text, or the last one where the text is the same: it may be read often with other values."""
    if _last.taken_apart is None or _last.source != (text, name, path):
        _last.source, _last.taken_apart = None, None
        taken_apart = SceneText(text, name, path)
        if len(text) > KEPT_CHARACTERS:
            return taken_apart
        _last.source, _last.taken_apart = (text, name, path), taken_apart
    return _last.taken_apart


def _connected(blocks: Mapping[str, Any]) -> Iterator[Joint]:
    """The joints, with references resolved: curves, paths of ropes, and the bodies and coordinates of couplings."""
    joints: Mapping[str, Joint] = blocks.get("joints", {})
    curves: Mapping[str, Track] = blocks.get("curves", {})
    for joint in joints.values():
        if "path" in joint.parameters:
            yield load("mbproj.scene.blocks.ropes:connected")(joint, blocks["bodies"], blocks.get("motions", {}))
        elif "curve" in joint.parameters:
            yield replace(joint, parameters={**joint.parameters, "curve": curves[joint.parameters["curve"]]})
        elif "curves" in joint.parameters:
            both = tuple(curves[name] for name in joint.parameters["curves"])
            yield replace(joint, parameters={**joint.parameters, "curves": both})
        else:
            yield joint if joint.couples is None else load("mbproj.scene.blocks.couplings:with_coupled")(joint, joints)


def _on_coordinates(forces: Mapping[str, Force], joints: Mapping[str, Joint]) -> Iterator[Force]:
    """The forces, with names for the coordinates that the scene leaves out."""
    for force in forces.values():
        yield with_coordinates(force, joints) if isinstance(force, JointForce) else force


def _check_times(blocks: Mapping[str, Any], reading: Reading) -> None:
    """Report times of expectations at which the scene's own settings give no sample; options may change these."""
    for complaint in unsampled(blocks.get("expect", {}), settings_of(by_name(blocks.get("simulation", {})))):
        reading.report(complaint.message, reading.places[complaint.path], complaint.hint)


def _reading(root: MappingNode) -> Reading:
    """A new reading of a document."""
    channel = partial(calling("mbproj.scene.blocks.expression_names:dimension_in"), root, {})
    return Reading(items=items_of(root), places={(): root.place}, dimension_of=channel)


def _settings(
    root: MappingNode, blocks: Mapping[str, Any] | None, options: Mapping[str, object], reading: Reading
) -> Settings | None:
    """The settings of the scene's block with the options over them; None where one is wrong, which is reported.
    `blocks` are those of the scene, None where it has a fault."""
    block = None if blocks is None else blocks.get("simulation")
    if block is None:
        node = root.values.get("simulation", ScalarNode("", root.place))
        apart = Reading(names=reading.names)  # a second reading: its problems are reported already
        block = SIMULATION.read(node, ("simulation",), apart)
    command = Reading(names=reading.names, problems=reading.problems)
    commanded = read_options(options, command)
    if block is None or commanded is None:
        return None
    reading.places.update({way: command.places[way] for way in map(place_of, commanded)})
    merged = Merged(merge(by_name(block), commanded), commanded, reading.places)
    wrong = list(check_settings(merged))
    reading.problems.extend(wrong)
    return None if wrong else settings_of(merged.values)


def _as_text(value: object) -> str:
    """A change as a text from which the same value is read."""
    if isinstance(value, str):
        return value
    from mbproj.scene.changes import Change

    return flow(value.node if isinstance(value, Change) else from_value(value, Place("")))


# --- Implements `Scene.with_` and `Scene.to_yaml` ---------------------------------------------------------------------
# A scene read again with changes, or written with them; and its display in a prompt and a notebook.


#: The most items of a kind that a prompt shows.
SHOWN = 6


def with_changes(scene: Scene, changes: Mapping[str, object]) -> Scene:
    """The scene with these values. Settings that were given in Python stay, unless the changes name them."""
    again = _read(scene, {**scene.overrides, **changes})
    from_python = {
        name: value for name, value in scene.given_settings.items() if ".".join(place_of(name)) not in changes
    }
    settings = settings_of(merge(values_of(again), from_python)) if from_python else again.settings
    return replace(again, path=scene.path, settings=settings, elements=scene.elements)


def to_yaml(scene: Scene) -> str:
    """A text from which the same scene is read. Comments are lost where something was changed. Raises InputError where
    there is no such text, as for expectations after the end of a run that was made shorter in Python."""
    if scene.elements:
        raise ValueError(f"elements from Python cannot be written: {', '.join(each.name for each in scene.elements)}")
    from_python = {".".join(place_of(name)): value for name, value in scene.given_settings.items()}
    changes = {**scene.overrides, **{path: flow(from_value(value, Place(""))) for path, value in from_python.items()}}
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


# --- `Scene.build` ----------------------------------------------------------------------------------------------------
# A scene of parts, without a file.


#: The name in messages of a scene that was built.
NAME = "Scene.build"


def build(blocks: Mapping[str, Any]) -> Scene:
    """The scene that has these blocks; `None` is left out. Raises InputError, whose problems name the
    arguments by their paths, as 'bodies.rod.mass'."""
    values = {name: blocks[name] for name in SCENE.keys if blocks.get(name) is not None}
    try:
        return read_scene_text({"mbproj": 1, **values}, NAME)
    except InputError as error:
        raise InputError([_at_argument(problem) for problem in error.problems]) from None


def _at_argument(problem: Problem) -> Problem:
    """The problem with the item as its place: lines of a generated text mean nothing to the user."""
    place = problem.place
    if place is None or place.file != NAME or place.line is None:
        return problem
    item = (place.text or "").strip().partition(":")[0]
    return replace(problem, place=Place(f"{NAME}: {item}" if item else NAME))
