"""The scopes of an SDF file: a world or a model with its named frames, the models within it, and includes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from functools import cached_property
from pathlib import Path

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.formats.geometry import IDENTITY, Frame, direction, from_quaternion, from_rpy, numbers
from mbproj.formats.xml import Includes, XmlElement, inside

#: The elements that define a named frame.
FRAMES = ("link", "joint", "frame")


@dataclass(eq=False)
class Scope:
    """A world or a model: the elements in it that define frames, by name, and the models within it."""

    name: str
    element: XmlElement
    above: Scope | None
    frames: dict[str, XmlElement] = field(default_factory=dict)
    models: dict[str, Scope] = field(default_factory=dict)
    rest: list[XmlElement] = field(default_factory=list)

    def walk(self) -> Iterator[Scope]:
        """Yield this scope and all models below it, in the order of the text."""
        yield self
        for model in self.models.values():
            yield from model.walk()

    def all(self, tag: str) -> Iterator[tuple[str, XmlElement]]:
        """Yield the scope's own links, joints or frames, with their names."""
        return ((name, element) for name, element in self.frames.items() if element.tag == tag)

    @property
    def path(self) -> str:
        """The names of the models from the outermost one to this scope; "" for the world, or a model outside one."""
        if self.above is None:
            return ""
        return f"{self.above.path}::{self.name}" if self.above.path else self.name

    @cached_property
    def static(self) -> bool:
        """Whether this model, or one around it, is static."""
        is_static = text(self.element, "static") in ("true", "1")
        return is_static or (self.above is not None and self.above.static)


def text(element: XmlElement, tag: str, default: str = "") -> str:
    """The text of a child element."""
    child = element.first(tag)
    return default if child is None or not child.text else child.text


def number(element: XmlElement, tag: str, default: float = 0.0) -> float:
    """The number in a child element. Raises InputError where it is none."""
    child = element.first(tag)
    return default if child is None or not child.text else float(numbers(child.text, 1, child.place, f"<{tag}>")[0])


def vector(element: XmlElement, tag: str, default: str) -> Array:
    """Three numbers in a child element."""
    child = element.first(tag)
    return numbers(text(element, tag, default), 3, (child or element).place, f"<{tag}>")


def pose_in(element: XmlElement) -> Frame:
    """The <pose> of an element: a place, with roll, pitch and yaw in rad or degrees, or a quaternion x y z w."""
    pose = element.first("pose")
    if pose is None or not pose.text:
        return IDENTITY
    quaternion = pose.get("rotation_format") == "quat_xyzw"
    values = numbers(pose.text, 7 if quaternion else 6, pose.place, "<pose>")
    if quaternion:
        turned = direction(values[[6, 3, 4, 5]], pose.place, "the quaternion")
        return Frame(values[:3], from_quaternion(turned))
    turns = np.radians(values[3:]) if pose.get("degrees") in ("true", "1") else values[3:]
    return Frame(values[:3], from_rpy(*turns))


def scopes_of(root: XmlElement, path: Path) -> tuple[Scope, list[XmlElement]]:
    """The scope of the first world, or of the first model outside a world, and the further worlds and models of the
    file. Raises InputError, all problems at once, where a name is missing or repeated, or an include cannot be read."""
    models = root.all("world", "model")
    if not models:
        raise InputError(Problem("the file has no <model> and no <world>", root.place, "an SDF has one of them"))
    files = _Files(path.resolve().parent)
    scope = files.scope(models[0], None, (path.resolve(),))
    if files.problems:
        raise InputError(files.problems)
    return scope, models[1:]


@dataclass(eq=False)
class _Files:
    """Reads scopes, with those of included files, which must be in the folder."""

    folder: Path
    includes: Includes = field(default_factory=Includes)
    problems: list[Problem] = field(default_factory=list)

    def scope(self, element: XmlElement, above: Scope | None, files: tuple[Path, ...], name: str = "") -> Scope:
        scope = Scope(name or element.get("name"), element, above)
        self._fill(scope, element, files)
        return scope

    def _fill(self, scope: Scope, element: XmlElement, files: tuple[Path, ...]) -> None:
        for child in element.children:
            try:
                if child.tag == "include":
                    self._include(scope, child, files)
                elif child.tag == "model":
                    self._add(scope, child.get("name"), child, self.scope(child, scope, files))
                elif child.tag in FRAMES:
                    self._add(scope, child.get("name"), child, None)
                else:
                    scope.rest.append(child)
            except InputError as error:
                self.problems += error.problems

    def _add(self, scope: Scope, name: str, element: XmlElement, model: Scope | None) -> None:
        taken = scope.frames.get(name) or (scope.models[name].element if name in scope.models else None)
        if not name or taken is not None or "::" in name:
            what = f"a second '{name}' beside that of line {taken.place.line}" if taken else "no name of its own"
            raise InputError(Problem(f"<{element.tag}> has {what}", element.place, "give each a name of its own"))
        if model is None:
            scope.frames[name] = element
        else:
            scope.models[name] = model

    def _include(self, scope: Scope, element: XmlElement, files: tuple[Path, ...]) -> None:
        """Add the model of another file, with the name, the pose and other elements that the include gives it."""
        uri = text(element, "uri")
        file = self._file(uri, element.place, files[-1].parent)
        root = self.includes.read(file, element.place, files, _short_name(uri, file))
        models = root.all("model")
        if root.tag != "sdf" or not models:
            raise InputError(Problem(f"'{uri}' has no <model>", element.place, "an SDF with one is included"))
        model = _overridden(models[0], element)
        if element.get("merge") in ("true", "1"):
            self._merge(scope, model, (*files, file))
            return
        name = text(element, "name") or model.get("name")
        self._add(scope, name, model, self.scope(model, scope, (*files, file), name))

    def _file(self, uri: str, place: Place, base: Path) -> Path:
        """The file of a URI. model://NAME, or the name of a folder, means NAME/model.sdf in the model's folder."""
        scheme, _, rest = uri.rpartition("://")
        if scheme not in ("", "model", "file", "package"):
            raise InputError(Problem(f"'{uri}' is no file", place, "mbproj reads no network: copy it to the folder"))
        if not rest:
            raise InputError(Problem("<include> has no <uri>", place, "name a file of the folder"))
        for name in (f"{rest}/model.sdf", f"../{rest}/model.sdf"):
            try:
                if (base / name).is_file():
                    return inside(name, place, self.folder, base)
            except (OSError, ValueError):
                break
        return inside(rest, place, self.folder, base)

    def _merge(self, scope: Scope, model: XmlElement, files: tuple[Path, ...]) -> None:
        """Add the elements of a model to the scope itself, with a new frame in the place of the model's own frame."""
        if model.get("placement_frame"):
            problem = Problem("a merged include has no placement frame", model.place, "give the pose of its own frame")
            raise InputError(problem)
        proxy = f"_merged__{model.get('name')}__model__"
        model_pose = model.first("pose")
        said = {"relative_to": "__model__"} | (dict(model_pose.attributes) if model_pose else {})
        placed = XmlElement("pose", said, model.place, [], model_pose.text if model_pose else "")
        frame = XmlElement("frame", {"name": proxy, "attached_to": _first_link(model)}, model.place, [placed])
        self._add(scope, proxy, frame, None)
        for child in model.children:
            if child.tag not in (*FRAMES, "model", "include"):
                continue
            pose = child.first("pose")
            if child.tag != "joint" and not child.get("attached_to"):
                if pose is None:
                    child.children.append(XmlElement("pose", {"relative_to": proxy}, child.place))
                elif not pose.get("relative_to"):
                    pose.attributes["relative_to"] = proxy
            for each in child.walk():
                for key in ("expressed_in", "relative_to", "attached_to"):
                    if each.get(key) == "__model__":
                        each.attributes[key] = proxy
        self._fill(scope, XmlElement("model", {}, model.place, model.all(*FRAMES, "model", "include")), files)


def _first_link(model: XmlElement) -> str:
    link = model.first("link")
    return model.get("canonical_link") or (link.get("name") if link else "")


def _short_name(uri: str, file: Path) -> str:
    return file.name if "/" not in uri else f"{file.parent.name}/{file.name}"


def _overridden(model: XmlElement, include: XmlElement) -> XmlElement:
    """The model with the elements of the include in the place of its own."""
    replaced = {child.tag for child in include.children} & {"pose", "static", "placement_frame"}
    children = [child for child in model.children if child.tag not in replaced]
    children += [child for child in include.children if child.tag in ("pose", "static", "plugin")]
    attributes = dict(model.attributes)
    if "placement_frame" in replaced:
        attributes["placement_frame"] = text(include, "placement_frame")
    return XmlElement("model", attributes, model.place, children, model.text)


def unknown(name: str, scope: Scope, place: Place) -> InputError:
    """The error of a name that no frame in the scope has."""
    able = [*scope.frames, *scope.models]
    return InputError(Problem(f"unknown frame '{name}'", place, choose_from(name, able)))


# --- Frames of an SDF by name -----------------------------------------------------------------------------------------
# The pose of each, and the link that each is part of.
# A pose is relative to the frame that it names, which may be in another model: `model::frame`. In a model it is
# relative to the model unless it names one; that of a joint is relative to its child, that of a frame to what it is
# attached to.


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
        pose, named = pose_in(scope.element), scope.element.first("pose")
        relative = _relative(named)
        if relative and scope.above is not None:
            pose = self.pose_in_model(scope.above, relative, scope.element.place).then(pose)
        elif relative and relative not in ROOTS:
            what = f"unknown frame '{relative}': nothing is around the model"
            raise InputError(Problem(what, scope.element.place, "leave 'relative_to' out"))
        placement = scope.element.get("placement_frame")
        if placement:
            pose = pose.then(self.pose_in_model(scope, placement, scope.element.place).inverse())
        return pose

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
    pose = shape.first("pose")
    named = "" if pose is None else pose.get("relative_to") or pose.get("frame")
    if not named:
        return pose_in(shape)
    return at.inverse().then(frames.pose(scope, named, shape.place)).then(pose_in(shape))
