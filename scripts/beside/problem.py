"""What every program gets and what it hands over: problems, programs, their settings, what a run comes to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mbproj.formats.export.tree import Start, Tree, start_of, tree_of
from mbproj.scene.records import GROUND
from mbproj.scene.scene import Scene

Array = NDArray[np.float64]


class NotDone(Exception):
    """A setting with which a program does not finish the motion."""


class Outcome(NamedTuple):
    """What is watched, (T, W, 3), at the samples; processor time of the integration alone, s; by how much a loop is
    open at the samples, m (None: nothing can open); evaluations of the accelerations (0: they are not counted)."""

    watched: Array
    seconds: float
    opening: float | None = None
    evaluations: int = 0


@dataclass(frozen=True)
class Setting:
    """A step or a tolerance of a program. `run` takes the times of the samples (T,), of which the last is the end of
    the motion, and raises NotDone. `steps` are those of the whole motion where their number is fixed."""

    label: str
    run: Callable[[Array], Outcome]
    steps: int | None = None


@dataclass(frozen=True)
class Program:
    """A program as it is used here; its settings go from coarse to fine."""

    name: str
    settings: Callable[[], Iterator[Setting]]


@dataclass(frozen=True)
class Hand:
    """Hamilton's equations in minimal coordinates, derived by hand (`by_hand.cpp`): the number of the system, what it
    takes, the coordinates and momenta at the start, and what states (T, 2n) say of what is watched, (T, W, 3)."""

    system: int
    parts: Sequence[float]
    start: Sequence[float]
    watched: Callable[[Array], Array]


class Equations(Protocol):
    """Equations derived by hand in Python (`lagrange.py`), for SciPy."""

    @property
    def start(self) -> Array:
        """Coordinates and speeds (2n,)."""

    def slope(self, t: float, y: Array, /) -> Array:
        """y' (2n,)."""

    def watched(self, y: Array) -> Array:
        """(T, W, 3) of states (T, 2n)."""


@dataclass(frozen=True)
class Rattled:
    """What RATTLE needs besides the scene: the first body turns as two numbers of its `column` say; `moments` are those
    of bodies whose own make the mass matrix singular; a body `hinged` at the origin is seen from there; `watched` makes
    (W, 3) of that angle and of r and the columns of A of all bodies, (n, 12)."""

    watched: Callable[[float, Array], Array]
    column: tuple[int, int] = (3, 5)
    moments: Sequence[Sequence[float]] = ()
    hinged: bool = False


@dataclass(frozen=True, eq=False)
class Problem:
    """A motion to `end` s and what is watched of it, at so many samples: markers, and coordinates "joint.name".

    `exact` gives (T, W, 3) at times (T,), with NaN where nothing is measured, and how certain that is. `mbproj` has
    settings by the name of a method. `coarsest` is the longest step of a sweep, s; `tried` has steps in s by the name
    of a program in place of a sweep, "" for all others. `by_coordinates` is the same mechanism with springs on
    coordinates of joints, for programs without bushings; `alone` is one that only
    mbproj runs; `mjcf` gives MuJoCo's models by name, where a scene cannot be
    exported."""

    title: str
    scene: Scene
    end: float
    samples: int
    watch: tuple[str, ...]
    exact: Callable[[Array], tuple[Array, float]]
    errors: tuple[float, ...]
    mbproj: Mapping[str, Mapping[str, Any]]
    coarsest: float = 0.05
    tried: Mapping[str, Sequence[float]] = field(default_factory=dict)
    unit: str = "m"
    mujoco: tuple[str, ...] = ("RK4",)
    contacts: bool = False
    alone: bool = False
    by_coordinates: Scene | None = None
    mjcf: Callable[[float], Iterator[tuple[str, str]]] | None = None
    hand: Hand | None = None
    equations: Equations | None = None
    rattle: Rattled | None = None

    @cached_property
    def times(self) -> Array:
        """Of the samples, s, without the start."""
        return np.linspace(0.0, self.end, self.samples + 1)[1:]

    @cached_property
    def reference(self) -> tuple[Array, float]:
        """At the samples, and how certain it is."""
        return self.exact(self.times)

    def error(self, watched: Array) -> float:
        """The largest distance of what is watched from the reference; infinite where it is not finite,
        NaN where nothing is known."""
        exact, _ = self.reference
        if np.isnan(exact).all():
            return np.nan
        gap = np.where(np.isnan(exact), 0.0, watched - exact)
        largest = np.linalg.norm(gap, axis=-1).max()
        return float(largest) if np.isfinite(largest) else np.inf

    def steps(self, program: str) -> Iterator[tuple[float, int]]:
        """Fixed steps, s, and how many make the whole motion: three to each doubling."""
        interval = self.end / self.samples
        if self.tried:
            wanted: Iterator[float] = iter(self.tried.get(program, self.tried.get("", ())))
        else:
            wanted = (self.coarsest * 2.0 ** (-k / 3) for k in range(48))
        last = 0
        for step in wanted:
            count = max(1, round(interval / step))
            if count != last:
                yield interval / count, count * self.samples
            last = count

    @cached_property
    def start(self) -> Start:
        """Poses, velocities and frames at the start."""
        return start_of(self.scene)

    @cached_property
    def tree(self) -> Tree:
        """The joints that a tree of the bodies has, and those that close its loops."""
        return tree_of(self.scene, self.start)

    @property
    def falls_freely(self) -> bool:
        """Whether only gravity acts, on a tree of hinges and slides whose loops are closed by balls."""
        kinds = {freedom.kind for branch in self.tree.branches for freedom in branch.freedoms}
        balls = all(joint.type == "spherical" for joint in self.tree.loops)
        return balls and kinds <= {"hinge", "slide"} and not self.scene.forces and not self.scene.motions

    def places(self) -> list[tuple[str, Array]]:
        """The markers that are watched: their bodies, and where they are from the centres of mass, in body axes."""
        by_name = {marker.name: marker for marker in self.scene.markers}
        found = [by_name[name] for name in self.watch if name in by_name]
        poses = self.start.file_poses
        return [
            (
                one.body,
                np.array(one.location)
                if one.local
                else poses[one.body].rotation.T @ (np.array(one.location) - poses[one.body].position),
            )
            for one in found
        ]

    def loops(self) -> list[tuple[tuple[str, Array], tuple[str, Array]]]:
        """The two points of each ball that closes a loop: bodies, and places in their axes."""
        return [
            (
                (joint.bodies[0], self.start.frames[joint.name]["p1"]),
                (joint.bodies[1], self.start.frames[joint.name]["p2"]),
            )
            for joint in self.tree.loops
            if joint.type == "spherical" and GROUND not in joint.bodies
        ]


def opening(ends: Sequence[tuple[Array, Array]]) -> float | None:
    """The largest distance of the two points (T, 3) of loops; None without any."""
    return max((float(np.linalg.norm(one - other, axis=-1).max()) for one, other in ends), default=None)


def tolerances(tightest: int = 13) -> Iterator[float]:
    """10^-2 ... 10^-tightest, three to each decade."""
    return (10.0 ** (-k / 3) for k in range(6, 3 * tightest + 1))


def step_label(step: float) -> str:
    """A fixed step in ms."""
    return f"h = {1000 * step:.3g} ms"


def tolerance_label(tolerance: float) -> str:
    """A tolerance to two digits."""
    return f"tol = {tolerance:.1e}"
