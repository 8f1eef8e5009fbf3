"""What a reader of another format makes of a model: bodies, joints, forces, and what is said of the rest."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from enum import Enum
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.scene.records import GROUND


class Same(Enum):
    """Whether the scene's motion is the model's in spite of what is said."""

    YES = "yes"
    UNTIL = "until then"
    NO = "no"


@dataclass(frozen=True)
class Signal:
    """An expression of the time t in s, and where it stands."""

    text: str
    place: Place = Place("")

    @property
    def constant(self) -> float | None:
        """Its number where it is one."""
        try:
            return float(self.text)
        except ValueError:
            return None


Signals = Mapping[str, Signal]


@dataclass(frozen=True)
class Wishes:
    """What a user asks of an import: the keyframe, or the joint coordinates by name (rad, m), to start at; `controls`
    of actuators by name, which then act, and `motions` of joints; `contacts`: stops where spheres may meet planes; the
    file where the `loops` stand; that the two frames which a joint of an SDF names `meet`; the `folder` of the scene,
    from which its meshes are named, that of the model unless given."""

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
    """A row of the table: an element, its place, what happens with it, whether the motion is still the model's."""

    element: str
    place: Place | None
    what: str
    same: Same


class Quantity(NamedTuple):
    """A number in the SI unit `unit`, which the scene shows."""

    value: float
    unit: str


class Bare(str):
    """Text that stands in the scene as it is: an expression, a word."""


@dataclass(frozen=True, eq=False)
class ImportedBody:
    """A body: inertia (3, 3) about its centre of mass in its axes; its pose in global axes, columns of `rotation`.

    `velocity` is global, `angular_velocity` in body axes. `look` is its `appearance` as the scene has it."""

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
        """A global point from the centre of mass in body axes."""
        return np.asarray(self.rotation.T @ (point - self.position))


ORIGIN = ImportedBody(GROUND, 0.0, np.zeros((3, 3)), np.zeros(3), np.eye(3))


@dataclass(frozen=True, eq=False)
class Connection:
    """A joint: `points` (2, 3), `axes` (2, 3) or none, `turns` (2, 3, 3) or none, each in the axes of its own body.

    `keys` is what else the scene says of it. A coupler has no bodies and no points."""

    name: str
    type: str
    bodies: tuple[str, ...] = ()
    points: Array | None = None
    axes: Array | None = None
    turns: Array | None = None
    keys: Mapping[str, Any] = field(default_factory=dict)
    place: Place | None = None


@dataclass(eq=False)
class Mechanism:
    """A model as a scene can say it. `parts` are in the order from the ground; `tree` has the names of the joints that
    make its tree, and of those that only measure, the others close loops. `between` are massless bodies that the model
    has not; `followers` those that a coupler moves, each with its joint. `adjust` is how far joints may move where its
    numbers are rounded."""

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

    def part(self, name: str) -> ImportedBody:
        """A body, or the ground."""
        return ORIGIN if name == GROUND else self.parts[name]

    def mark(self, wanted: str, body: str, point: Array) -> None:
        """Adds a marker at a global point (3,) of a body."""
        name = ImportedNames(frozenset(self.markers)).own(wanted)
        self.markers[name] = (body, self.part(body).local(point))

    def insert(self, part: ImportedBody, before: str) -> None:
        """Adds a body, in the order before another one that it carries."""
        parts = list(self.parts.items())
        at = next((index for index, (name, _) in enumerate(parts) if name == before), len(parts))
        parts.insert(at, (part.name, part))
        self.parts = dict(parts)
        self.between.add(part.name)

    def say(self, element: str, place: Place | None, what: str, same: Same) -> None:
        """A row of the table."""
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
        """A joint of the tree, with its point (3,) and its axes, (3,) or (2, 3), in global axes at the pose."""
        ends = [self.part(body) for body in bodies]
        points = np.array([end.local(point) for end in ends])
        own = None
        if axes is not None:
            both = np.broadcast_to(axes, (2, 3))
            own = np.array([end.rotation.T @ axis for end, axis in zip(ends, both, strict=True)])
        self.joints[name] = Connection(name, kind, bodies, points, own, None, keys or {}, place)
        self.tree.add(name)
        return self.joints[name]


#: Names have so many characters at most: a key of YAML has 1024 at most, and a line of a scene 100 where it can.
LONGEST_NAME = 80


class ImportedNames:
    """Names that mbproj can have, each once; what was changed is kept."""

    def __init__(self, reserved: frozenset[str] = frozenset()) -> None:
        self._taken = set(reserved)
        self.renamed: dict[str, str] = {}

    def own(self, wanted: str) -> str:
        """A name that is not taken, as near to the wanted one as can be."""
        plain = re.sub(r"[^A-Za-z0-9_-]+", "_", wanted)[:LONGEST_NAME] or "unnamed"
        if not re.match(r"[A-Za-z_]", plain):
            plain = f"_{plain}"
        found, count = plain, 2
        while found in self._taken:
            found, count = f"{plain}_{count}", count + 1
        self._taken.add(found)
        if found != wanted:
            self.renamed[wanted] = found
        return found

    @staticmethod
    def beginning(names: Sequence[str]) -> str:
        """The letters that the names begin with, without a sign at their end."""
        alike = takewhile(lambda letters: len(set(letters)) == 1, zip(*names, strict=False))
        return "".join(letters[0] for letters in alike).rstrip("_-.")


def said_of(mechanism: Mechanism, kind: str, names: ImportedNames) -> Iterator[Said]:
    """Rows on names that were changed."""
    changed = [f"'{_cut(old)}' is '{new}'" for old, new in names.renamed.items() if old]
    if changed:
        shown = ", ".join(changed[:4]) + (f", and {len(changed) - 4} more" if len(changed) > 4 else "")
        yield Said(f"names of {kind}", None, f"changed to what a scene can have, each once: {shown}", Same.YES)


def _cut(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else f"{name[:LONGEST_NAME]}..."
