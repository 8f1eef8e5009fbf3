"""The result of an import: bodies, joints, forces, and a table with rows on all other elements of the model."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from enum import Enum
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place, shortened
from mbproj.formats.geometry import Frame
from mbproj.scene.records import GROUND


class Same(Enum):
    """Whether the scene moves as the model does, in spite of the row of the table."""

    YES = "yes"
    UNTIL = "until then"
    NO = "no"


@dataclass(frozen=True)
class GivenSignal:
    """An expression of the time t in s, and its place."""

    text: str
    place: Place = Place("")

    @property
    def constant(self) -> float | None:
        """The number where the expression is one; None for others."""
        try:
            return float(self.text)
        except ValueError:
            return None


Signals = Mapping[str, GivenSignal]


@dataclass(frozen=True)
class ImportOptions:
    """The options of an import. `key` is the keyframe to start at, or `pose` the joint coordinates by name (rad, m).
    `controls` are signals of actuators by name, which then act, `motions` those of driven joints. `contacts` makes
    stops where spheres may meet planes. `loops` is the file of loops. With `meet` the two frames that a joint of an SDF
    names coincide. `folder` is the scene's, from which meshes are named; None: the model's."""

    key: str | None = None
    pose: Mapping[str, float] = field(default_factory=dict)
    controls: Signals | None = None
    motions: Signals = field(default_factory=dict)
    contacts: bool = False
    loops: Path | None = None
    meet: bool = False
    folder: Path | None = None


@dataclass(frozen=True)
class Said:
    """A row of the table: an element, its place, what happens to it, whether the motion is still that of the model."""

    element: str
    place: Place | None
    what: str
    same: Same


@dataclass(frozen=True)
class Agreement:
    """How far a scene is from the model in the program that reads it. Each number is the largest of a body.

    At the start: the distance of centres of mass (m) and the angle (rad) between orientations; the differences of
    velocities (m/s, rad/s), and these as a part of the largest. At `states` states, the start and others beside it: the
    differences of accelerations (m/s², rad/s²), and these as a part of the largest. `without` names what is left out
    on both sides."""

    position: float
    angle: float
    velocity: float
    angular_velocity: float
    velocity_relative: float
    acceleration: float
    angular_acceleration: float
    acceleration_relative: float
    states: int
    without: tuple[str, ...]


class Quantity(NamedTuple):
    """A number with its SI unit, which the scene shows."""

    value: float
    unit: str


class Bare(str):
    """A text that is written without quotes: an expression, a word."""


@dataclass(frozen=True, eq=False)
class ImportedBody:
    """A body: inertia (3, 3) about its centre of mass in its axes; its pose in global axes, columns of `rotation`.

    `velocity` is global, `angular_velocity` in body axes. `look` is the key `appearance` of the scene."""

    name: str
    mass: float
    inertia: Array
    position: Array
    rotation: Array
    place: Place | None = None
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    angular_velocity: Array = field(default_factory=lambda: np.zeros(3))
    look: Mapping[str, Any] = field(default_factory=dict)

    def local(self, point: Array) -> Array:
        """A global point as a vector from the centre of mass, in body axes."""
        return np.asarray(self.rotation.T @ (point - self.position))


ORIGIN = ImportedBody(GROUND, 0.0, np.zeros((3, 3)), np.zeros(3), np.eye(3))


@dataclass(frozen=True, eq=False)
class Connection:
    """A joint: `points` (2, 3), `axes` (2, 3) or none, `turns` (2, 3, 3) or none, each in the axes of its own body.

    `keys` are the other keys of the joint in the scene. A coupler has no bodies and no points."""

    name: str
    type: str
    bodies: tuple[str, ...] = ()
    points: Array | None = None
    axes: Array | None = None
    turns: Array | None = None
    keys: Mapping[str, Any] = field(default_factory=dict)
    place: Place | None = None


@dataclass(eq=False)
class ImportedMechanism:
    """A model in the form of a scene. `parts` are its bodies in order from the ground. `tree` has the names of the
    joints in its tree, and of those that only measure; other joints close loops. `between` are massless bodies that the
    model does not have. `followers` has, by coupler, the massless body that it moves and the joint of that. `adjust` is
    how far joints may move because numbers are rounded. `compare` compares the scene, which a version of mbproj writes,
    with the model in the program that reads it, and adds rows on that; None where there is no such program."""

    title: str
    kind: str
    file: str
    gravity: Array
    parts: dict[str, ImportedBody] = field(default_factory=dict)
    joints: dict[str, Connection] = field(default_factory=dict)
    forces: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    motions: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    signals: dict[str, Bare] = field(default_factory=dict)
    states: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    markers: dict[str, tuple[str, Array]] = field(default_factory=dict)
    said: list[Said] = field(default_factory=list)
    tree: set[str] = field(default_factory=set)
    between: set[str] = field(default_factory=set)
    followers: dict[str, tuple[str, str]] = field(default_factory=dict)
    adjust: str = ""
    compare: Callable[[ImportedMechanism, str], Agreement | None] | None = None

    def part(self, name: str) -> ImportedBody:
        """The body with this name, or the ground."""
        return ORIGIN if name == GROUND else self.parts[name]

    def mark(self, wanted: str, body: str, point: Array) -> None:
        """Add a marker at a global point (3,) of a body."""
        name = ImportedNames(frozenset(self.markers)).unused(wanted)
        self.markers[name] = (body, self.part(body).local(point))

    def insert(self, part: ImportedBody, before: str) -> None:
        """Add a massless body, in the order before the body that it carries."""
        parts = list(self.parts.items())
        at = next((index for index, (name, _) in enumerate(parts) if name == before), len(parts))
        parts.insert(at, (part.name, part))
        self.parts = dict(parts)
        self.between.add(part.name)

    def say(self, element: str, place: Place | None, what: str, same: Same) -> None:
        """Add a row to the table."""
        self.said.append(Said(element, place, what, same))

    def join(
        self,
        name: str,
        kind: str,
        bodies: tuple[str, str],
        point: Array,
        axes: Array | None = None,
        keys: Mapping[str, Any] | None = None,
        place: Place | None = None,
    ) -> Connection:
        """Add a joint of the tree and return it; its point (3,) and axes, (3,) or (2, 3), are global at the pose."""
        ends = [self.part(body) for body in bodies]
        points = np.array([end.local(point) for end in ends])
        local_axes = None
        if axes is not None:
            both = np.broadcast_to(axes, (2, 3))
            local_axes = np.array([end.rotation.T @ axis for end, axis in zip(ends, both, strict=True)])
        self.joints[name] = Connection(name, kind, bodies, points, local_axes, None, keys or {}, place)
        self.tree.add(name)
        return self.joints[name]


#: The most characters of a name: a key of YAML has at most 1024, and lines of a scene should have at most 100.
LONGEST_NAME = 80


class ImportedNames:
    """Gives out names that are valid in mbproj, each once, and remembers which names it has changed."""

    def __init__(self, reserved: frozenset[str] = frozenset()) -> None:
        self._taken = set(reserved)
        self.renamed: dict[str, str] = {}

    def unused(self, wanted: str) -> str:
        """A name that is not taken, as near to the wanted one as can be."""
        plain = re.sub(r"[^A-Za-z0-9_-]+", "_", wanted)[:LONGEST_NAME] or "unnamed"
        if not re.match(r"[A-Za-z_]", plain):
            plain = f"_{plain}"
        name, count = plain, 2
        while name in self._taken:
            name, count = f"{plain}_{count}", count + 1
        self._taken.add(name)
        if name != wanted:
            self.renamed[wanted] = name
        return name

    @staticmethod
    def beginning(names: Sequence[str]) -> str:
        """The common beginning of the names, without separators at its end."""
        alike = takewhile(lambda letters: len(set(letters)) == 1, zip(*names, strict=False))
        return "".join(letters[0] for letters in alike).rstrip("_-.")


def said_of(mechanism: ImportedMechanism, kind: str, names: ImportedNames) -> Iterator[Said]:
    """Yield the rows of the table on names that were changed."""
    changed = [f"'{_shorten(old)}' is '{new}'" for old, new in names.renamed.items() if old]
    if changed:
        what = f"changed to what a scene can have, each once: {shortened(changed, 4)}"
        yield Said(f"names of {kind}", None, what, Same.YES)


def _shorten(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else f"{name[:LONGEST_NAME]}..."


# --- Joints that close loops ------------------------------------------------------------------------------------------
# Joints that close loops, with a frame of each of two links that need not meet where the model begins.


@dataclass(frozen=True, eq=False)
class Loop:
    """A joint of the scene's `type` between frames of two links, given in theirs, with an `axis` in both frames."""

    name: str
    type: str
    links: tuple[str, str]
    frames: tuple[Frame, Frame]
    axis: Array
    place: Place


def add_loops(
    mechanism: ImportedMechanism,
    loops: list[Loop],
    frames: Mapping[str, Frame],
    called: Mapping[str, str],
    names: ImportedNames,
) -> None:
    """Add the joints of loops, with a point and an axis in each body. `frames` are the global poses of the links."""
    for loop in loops:
        bodies = (called[loop.links[0]], called[loop.links[1]])
        if bodies[0] == bodies[1]:
            mechanism.say(f"loop '{loop.name}'", loop.place, f"left out: both ends are on '{bodies[0]}'", Same.YES)
            continue
        points, axes, turns = np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3, 3))
        for side, (link, local) in enumerate(zip(loop.links, loop.frames, strict=True)):
            held, part = frames[link].then(local), mechanism.part(bodies[side])
            points[side], turns[side] = part.local(held.position), part.rotation.T @ held.rotation
            axes[side] = turns[side] @ loop.axis
        name = names.unused(loop.name)
        with_axis = axes if loop.type not in ("spherical", "fixed") else None
        with_turns = turns if loop.type == "fixed" else None
        mechanism.joints[name] = Connection(name, loop.type, bodies, points, with_axis, with_turns, {}, loop.place)
