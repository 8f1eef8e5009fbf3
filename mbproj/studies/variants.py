"""Variants of a scene: larger, moved as a whole, faster, stiffer, with other masses.

One walker goes through the records of a scene. What happens to a number follows from the `Quantity` that its field
declares in `mbproj.scene.records`, so that new fields, joints and elements need no line here.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.functions.program import COORDINATE, RATE, TIME, Op, Program, apply, number, replaced, variable
from mbproj.functions.space_curve import SpaceTrack, Track
from mbproj.functions.standard import weighted
from mbproj.joints.table import JOINTS
from mbproj.model.compile.frames import SYMBOLS, local_frames, poses_of
from mbproj.scene.blocks.signals import names_channels
from mbproj.scene.expressions.units import DAMPING, STIFFNESS, TORSION_DAMPING, TORSION_STIFFNESS, Dimension
from mbproj.scene.fields.quantities import dimension_of
from mbproj.scene.fields.rotations import from_matrix, multiply
from mbproj.scene.records import BY_KEY, GROUND, Body, Joint, Pair, Quantity, Vector
from mbproj.scene.scene import Scene

# --- The walker through the records of a scene ------------------------------------------------------------------------


class Declared(NamedTuple):
    """What is declared about a value: the name of its field; its dimension, and that of the coordinate that it is
    about; how it moves with the scene, "" for what does not, as what is in the axes of a moving body."""

    name: str
    dimension: Dimension
    coordinate: Dimension
    moves: str


#: Returns what replaces a value: a number, a tuple of numbers or functions, a function or a curve.
Change = Callable[[Any, Declared], Any]
#: The fields of a scene that make its mechanism.
MECHANISM = ("gravity", "bodies", "joints", "forces", "motions", "markers")


def changed(scene: Scene, change: Change, blocks: Sequence[str] = MECHANISM) -> Scene:
    """The scene with each value of these fields changed, wherever a record declares its quantity."""
    units = {f"{joint.name}.{name}": unit for joint in scene.joints for name, unit in joint.units.items()}
    walker = _Walker(change, units)
    return replace(scene, **{name: walker.field(scene, name, "m") for name in blocks})


@cache
def quantities(kind: type) -> Mapping[str, tuple[Quantity, ...]]:
    """The quantities that a class of records declares for its fields, by the fields' names."""
    names, texts = vars(sys.modules[kind.__module__]), {each.name: str(each.type) for each in fields(kind)}
    return {name: eval(text, names).__metadata__ for name, text in texts.items() if text.startswith("Annotated[")}


def _is_record(value: object) -> bool:
    return is_dataclass(value) and not isinstance(value, Program | Track | SpaceTrack)


@dataclass(frozen=True)
class _Walker:
    """The change, and the units of joint coordinates by their full names, as "pin.angle"."""

    change: Change
    units: Mapping[str, str]

    def field(
        self, record: Any, name: str, coordinate: str, holder: Any = None, held: tuple[Quantity, ...] = ()
    ) -> Any:
        """Return the value of a field, changed. `coordinate` is the unit of the coordinate that the record is about;
        `held` are the quantities of the record's field in its `holder`, for fields that declare none."""
        declared = quantities(record.__class__).get(name, held)
        return self._value(getattr(record, name), _At(record, holder, name, coordinate), declared)

    def _value(self, value: Any, at: _At, declared: tuple[Quantity, ...]) -> Any:
        if isinstance(value, Mapping):
            return {key: self._value(each, *self._under(key, at, declared)) for key, each in value.items()}
        if isinstance(value, tuple) and len(declared) > 1:
            return tuple(self._value(each, at, (one,)) for each, one in zip(value, declared, strict=True))
        if isinstance(value, tuple) and any(map(_is_record, value)):
            return tuple(self._value(each, at, declared) for each in value)
        if _is_record(value):
            unit = self._unit(value, getattr(value, "coordinate", ""), at.coordinate)
            names = [each.name for each in fields(value)]
            return replace(value, **{name: self.field(value, name, unit, at.record, declared) for name in names})
        if not declared or value is None or isinstance(value, str | bool):
            return value
        (quantity,) = declared
        unit = quantity.unit.format(at.record).replace("coordinate", at.coordinate)
        moves = "" if at.in_moving_axes(quantity.local) else quantity.moves
        return self.change(value, Declared(at.name, dimension_of(unit), dimension_of(at.coordinate), moves))

    def _under(self, key: str, at: _At, declared: tuple[Quantity, ...]) -> tuple[_At, tuple[Quantity, ...]]:
        """The place and the quantity of the value under a key of a mapping, which may be a coordinate's name."""
        unit = self._unit(at.record, key, at.coordinate)
        by_key = declared == (BY_KEY,)
        return at._replace(coordinate=unit), (Quantity(at.record.units.get(key, "")),) if by_key else declared

    def _unit(self, record: Any, coordinate: str, default: str) -> str:
        """The unit of a coordinate: of the record's joint, or by its full name."""
        joint = getattr(record, "joint", getattr(record, "name", ""))
        return self.units.get(f"{joint}.{coordinate}", self.units.get(coordinate, default))


class _At(NamedTuple):
    """The place of a value: its record, the record that holds this one, the field, the unit of the coordinate."""

    record: Any
    holder: Any
    name: str
    coordinate: str

    def in_moving_axes(self, local: str) -> bool:
        """Whether a flag of the record says that the value is in the axes of a body, and this is not the ground."""
        if not getattr(self.record, local, False):
            return False
        is_placed = hasattr(self.record, "body")
        body = self.record.body if is_placed else self.holder.bodies[("first", "second").index(self.name)]
        return bool(body != GROUND)


def multiplied(factor: float, value: Any) -> Any:
    """The product of a factor with a number, a function, or all members of a tuple."""
    if isinstance(value, tuple):
        return tuple(multiplied(factor, each) for each in value)
    return weighted([(factor, value)]) if isinstance(value, Program) else factor * value


def with_arguments(program: Program, factors: Mapping[int, float]) -> Program:
    """The program f with x replaced by factor · x. `factors` are by the number of x (`TIME`, `COORDINATE`, `RATE`)."""
    by = {at: apply(Op.MULTIPLY, number(factor), variable(at)) for at, factor in factors.items()}
    return replace(program, code=replaced(program.code, by))


# --- A scene in other units -------------------------------------------------------------------------------------------


def rescaled(scene: Scene, k: float) -> Scene:
    """The scene k times as large, which moves alike: lengths, velocities, gravity and forces grow by k; torques,
    energies and moments of inertia by k²; times and masses stay. It is the mechanism in another unit of length.

    Raises InputError where it has elements, signals or states, because their numbers have no units."""
    if scene.elements or names_channels(scene):
        what = "the numbers in signals, states and what names coordinates have no units"
        what = f"element '{scene.elements[0].name}' is data without units" if scene.elements else what
        raise InputError(Problem(f"{what}: it cannot be made larger", hint="vary something else"))

    def larger(value: Any, declared: Declared) -> Any:
        if isinstance(value, Track | SpaceTrack):
            return value.scaled(k)
        if isinstance(value, tuple):
            return tuple(larger(each, declared) for each in value)
        if isinstance(value, Program):
            value = with_arguments(value, dict.fromkeys((COORDINATE, RATE), k**-declared.coordinate.length))
        factor = k**declared.dimension.length
        return value if isinstance(value, str) or factor == 1.0 else multiplied(factor, value)

    return changed(scene, larger)


# --- A scene turned and shifted as a whole, with gravity and forces ---------------------------------------------------


def _with_x_axes(scene: Scene) -> tuple[Joint, ...]:
    """The joints of a scene, each with the direction of its x also where the model chooses it. The model takes it from
    the global axes, which do not turn with the scene."""
    free = [joint for joint in scene.joints if joint.x_axis is None and JOINTS[joint.type].x_axis == "optional"]
    frames = local_frames(free, poses_of(scene))
    x1, x2 = SYMBOLS.index("x1"), SYMBOLS.index("x2")
    axes = {
        joint.name: Pair(_vector(frame[x1]), _vector(frame[x2]), local=True)
        for joint, frame in zip(free, frames, strict=True)
    }
    return tuple(replace(joint, x_axis=axes.get(joint.name, joint.x_axis)) for joint in scene.joints)


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """The rigid motion x -> R x + s with a rotation R (3, 3) and a shift s (3,) in m."""

    rotation: Array
    shift: Array

    @property
    def parameters(self) -> Array:
        """The Euler parameters of R, (4,)."""
        first, second, third = (_vector(row) for row in self.rotation)
        return np.array(from_matrix((first, second, third)))

    def scene(self, scene: Scene) -> Scene:
        """Return the scene, moved."""
        return changed(replace(scene, joints=_with_x_axes(scene)), self._moved)

    def _moved(self, value: Any, declared: Declared) -> Any:
        if declared.moves == "point":
            return self._point(value)
        if declared.moves == "orientation":
            return multiply(tuple(self.parameters.tolist()), value)
        return self._direction(value) if declared.moves else value

    def _direction(self, value: Any) -> Any:
        if isinstance(value[0], Program):
            return tuple(weighted(zip(row.tolist(), value, strict=True)) for row in self.rotation)
        return _vector(self.rotation @ np.array(value))

    def _point(self, vector: Vector) -> Vector:
        return _vector(self.rotation @ np.array(vector) + self.shift)


def _vector(values: Array) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z


# --- Variants of a scene that move faster, or have stiffer springs or dampers -----------------------------------------


def with_speed(scene: Scene, factor: float) -> Scene:
    """Multiply the start's velocities and the speed of all motions by a factor. Gravity and forces stay."""
    motions = [replace(each, function=with_arguments(each.function, {TIME: factor})) for each in scene.motions]
    what = "the scene starts at rest and has no motions: there is no speed to vary"
    problem = Problem(what, hint="give a joint a 'speed', or a body a 'velocity'")
    return _varied(
        replace(scene, motions=tuple(motions)),
        factor,
        lambda declared: declared.name in ("velocity", "angular_velocity", "speed"),
        ("bodies", "joints"),
        None if motions else problem,
    )


def with_stiffness(scene: Scene, factor: float) -> Scene:
    """Multiply every stiffness by a factor, also those of stops. Dampers, tables and functions stay."""
    return _with_laws(scene, "stiffness", (STIFFNESS, TORSION_STIFFNESS), factor)


def with_damping(scene: Scene, factor: float) -> Scene:
    """Multiply every damping by a factor. Springs, tables and functions stay."""
    return _with_laws(scene, "damping", (DAMPING, TORSION_DAMPING), factor)


def _with_laws(scene: Scene, of: str, dimensions: tuple[Dimension, ...], factor: float) -> Scene:
    """Multiply by a factor the numbers in fields of the name `of`, and those of elements in these dimensions."""

    def picks(declared: Declared) -> bool:
        return declared.name == of or declared.dimension in dimensions

    none = Problem(f"no force of the scene has a '{of}' to vary", hint="add a spring_damper, or vary something else")
    return _varied(scene, factor, picks, ("joints", "forces"), none)


def _varied(
    scene: Scene, factor: float, picks: Callable[[Declared], bool], blocks: Sequence[str], none: Problem | None
) -> Scene:
    """Multiply numbers by a factor. Raises InputError with the problem `none` where all are 0 or infinite."""
    varied = list[float]()

    def change(value: Any, declared: Declared) -> Any:
        if isinstance(value, Program) or not picks(declared):
            return value
        varied.extend(each for each in np.ravel(value) if each and math.isfinite(each))
        return multiplied(factor, value)

    variant = changed(scene, change, blocks)
    if none is not None and not varied:
        raise InputError(none)
    return variant


# --- Variants with uneven masses or moments of inertia ----------------------------------------------------------------
# Every second body, counted from the ground, is heavier.


def with_mass_ratio(scene: Scene, r: float) -> Scene:
    """Multiply mass and inertia by √r for bodies at an odd number of joints from the ground, and by 1/√r for the
    others."""
    return _alternating(scene, r, "mass", ("mass", "inertia"))


def with_inertia_ratio(scene: Scene, r: float) -> Scene:
    """Multiply only the inertia by √r for bodies at an odd number of joints from the ground, and by 1/√r for the
    others."""
    return _alternating(scene, r, "inertia", ("inertia",))


def _alternating(scene: Scene, r: float, what: str, names: Sequence[str]) -> Scene:
    distance = joints_from_ground(scene)
    if len({number % 2 for number in distance.values()}) < 2:
        said = f"no two bodies are joined to each other: there is no {what} ratio between neighbours"
        raise InputError(Problem(said, hint="vary something else, 'step' for example"))

    def uneven(body: Body) -> Body:
        factor = r**0.5 if distance[body.name] % 2 else r**-0.5
        return replace(body, **{name: multiplied(factor, getattr(body, name)) for name in names})

    return replace(scene, bodies=tuple(map(uneven, scene.bodies)))


def joints_from_ground(scene: Scene) -> dict[str, int]:
    """The number of joints on the shortest path from the ground to each body. In a group of bodies that is not joined
    to the ground, the first body counts as one joint away."""
    ways: dict[str, list[str]] = {name: [] for name in (GROUND, *(body.name for body in scene.bodies))}
    for first, second in (joint.bodies for joint in scene.joints):
        ways[first].append(second)
        ways[second].append(first)
    distance = {GROUND: 0}
    for start in ways:
        distance.setdefault(start, 1)
        waiting = [start]
        for name in waiting:
            new = [other for other in dict.fromkeys(ways[name]) if other not in distance]
            distance |= dict.fromkeys(new, distance[name] + 1)
            waiting += new
    return {name: number for name, number in distance.items() if name != GROUND}
