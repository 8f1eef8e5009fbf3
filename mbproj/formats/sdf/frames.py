"""Frames of an SDF by name: the pose of each, and the link that each is part of.

A pose is relative to the frame that it names, which may be in another model: `model::frame`. In a model it is relative
to the model unless it names one; that of a joint is relative to its child, that of a frame to what it is attached to.
"""

from __future__ import annotations

from dataclasses import field

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.formats.geometry import IDENTITY, Frame
from mbproj.formats.sdf.scopes import Scope, pose_in, text, unknown
from mbproj.formats.xml import XmlElement

#: The name that stands for the link of a frame that cannot move.
WORLD = ""
#: Names of frames that every scope has.
MODEL, ROOTS = "__model__", ("world", "__root__")


@dataclass(eq=False)
class SdfFrames:
    """Finds the pose of each frame in the model of its scope, and the full name of its link, each once."""

    _poses: dict[tuple[int, str], Frame] = field(default_factory=dict)
    _links: dict[tuple[int, str], str] = field(default_factory=dict)
    _open: set[tuple[int, str, str]] = field(default_factory=set)

    def world(self, scope: Scope) -> Frame:
        """The pose of a model in the world."""
        if scope.above is None and scope.element.tag == "world":
            return IDENTITY
        key = (id(scope), MODEL)
        if key not in self._poses:
            with _Once(self._open, (*key, "pose"), MODEL, scope.element.place):
                outer = IDENTITY if scope.above is None else self.world(scope.above)
                self._poses[key] = outer.then(self._placed(scope))
        return self._poses[key]

    def _placed(self, scope: Scope) -> Frame:
        """The pose of a model in the scope around it."""
        given, named = pose_in(scope.element), scope.element.first("pose")
        relative = _relative(named)
        if relative and scope.above is not None:
            given = self.pose_in_model(scope.above, relative, scope.element.place).then(given)
        placement = scope.element.get("placement_frame")
        if placement:
            given = given.then(self.pose_in_model(scope, placement, scope.element.place).inverse())
        return given

    def pose_in_model(self, scope: Scope, name: str, place: Place) -> Frame:
        """The pose of a frame in the model of the scope. Raises InputError where nothing has the name."""
        if name in ("", MODEL):
            return IDENTITY
        if name in ROOTS:
            return self.world(scope).inverse()
        outer, _, inner = name.partition("::")
        if outer in scope.models:
            model = scope.models[outer]
            return self._placed_once(model).then(self.pose_in_model(model, inner, place))
        if name not in scope.frames:
            raise unknown(name, scope, place)
        key = (id(scope), name)
        if key not in self._poses:
            element = scope.frames[name]
            with _Once(self._open, (*key, "pose"), name, element.place):
                base = _relative(element.first("pose")) or _default(element)
                self._poses[key] = self.pose_in_model(scope, base, element.place).then(pose_in(element))
        return self._poses[key]

    def _placed_once(self, model: Scope) -> Frame:
        key = (id(model), "__placed__")
        if key not in self._poses:
            with _Once(self._open, (*key, "pose"), model.name, model.element.place):
                self._poses[key] = self._placed(model)
        return self._poses[key]

    def pose(self, scope: Scope, name: str, place: Place) -> Frame:
        """The pose of a frame in the world."""
        return IDENTITY if name in ROOTS else self.world(scope).then(self.pose_in_model(scope, name, place))

    def link(self, scope: Scope, name: str, place: Place) -> str:
        """The full name of the link that a frame is part of, WORLD where it cannot move."""
        if name in ROOTS or (scope.element.tag == "world" and name in ("", MODEL)):
            return WORLD
        if name in ("", MODEL):
            return self._canonical(scope, place)
        outer, _, inner = name.partition("::")
        if outer in scope.models:
            return self.link(scope.models[outer], inner, place)
        if name not in scope.frames:
            raise unknown(name, scope, place)
        element, key = scope.frames[name], (id(scope), name)
        if element.tag == "link":
            return WORLD if scope.static else full_name(scope, name)
        if key not in self._links:
            with _Once(self._open, (*key, "link"), name, element.place):
                held = _default(element)
                self._links[key] = self.link(scope, held, element.place)
        return self._links[key]

    def _canonical(self, scope: Scope, place: Place) -> str:
        """The link that a model's own frame is part of: the one it names, or its first."""
        named = scope.element.get("canonical_link")
        if named:
            return self.link(scope, named, place)
        for model in scope.walk():
            for name, _ in model.all("link"):
                return self.link(model, name, place)
        raise InputError(Problem(f"model '{scope.name}' has no link", scope.element.place, "add one"))


def full_name(scope: Scope, name: str) -> str:
    """The name, with the names of the models around it."""
    return f"{scope.path}::{name}" if scope.path else name


def _relative(pose: XmlElement | None) -> str:
    """The name of the frame that a pose is relative to, in today's files or those of version 1.5; "" where it has
    none."""
    return "" if pose is None else pose.get("relative_to") or pose.get("frame")


def _default(element: XmlElement) -> str:
    """The frame that an element is attached to: its child for a joint, `attached_to` or the model for others."""
    return text(element, "child") if element.tag == "joint" else element.get("attached_to") or MODEL


class _Once:
    """A context for finding a frame, which raises InputError where that needs the frame itself."""

    def __init__(self, waiting: set[tuple[int, str, str]], key: tuple[int, str, str], name: str, place: Place) -> None:
        self._waiting, self._key, self._name, self._place = waiting, key, name, place

    def __enter__(self) -> None:
        if self._key in self._waiting:
            what = f"the frames that '{self._name}' stands in go in a circle"
            raise InputError(Problem(what, self._place, "let one of them be relative to the model"))
        self._waiting.add(self._key)

    def __exit__(self, *_: object) -> None:
        self._waiting.discard(self._key)


def in_link(frames: SdfFrames, scope: Scope, at: Frame, shape: XmlElement) -> Frame:
    """The pose of a shape in its link's frame; `at` is the link's pose in the world."""
    given = shape.first("pose")
    named = "" if given is None else given.get("relative_to") or given.get("frame")
    if not named:
        return pose_in(shape)
    return at.inverse().then(frames.pose(scope, named, shape.place)).then(pose_in(shape))
