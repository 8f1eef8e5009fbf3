"""The scene's dry friction as arrays: frictions that can stick, the loads they depend on, and regularised frictions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.functions.program import RATE, Code, Instruction, Op, Program, apply, number, variable
from mbproj.functions.standard import reading
from mbproj.joints import JOINTS
from mbproj.model.bearings import Bearings
from mbproj.model.frictions import Frictions
from mbproj.model.primitive_set import Binding, bind
from mbproj.scene.blocks.ropes.path import Path
from mbproj.scene.expressions.formula import formula
from mbproj.scene.friction import Bearing, DryFriction
from mbproj.scene.read import Scene
from mbproj.scene.records import Joint, JointForce


@dataclass(frozen=True, eq=False)
class _Dry:
    """A dry friction: its force, its coordinate and the `whole` name "joint.coordinate". `name` stands in results,
    `owner` in messages. `bearing`: the number of its bearing, -1 for none. `place`: its place in the scene."""

    force: str
    coordinate: str
    whole: str
    name: str
    owner: str
    dry: DryFriction
    bearing: int
    place: Place | None

    @property
    def key(self) -> tuple[str, str]:
        """Its force and its coordinate."""
        return self.force, self.coordinate


@dataclass(frozen=True, eq=False)
class SmoothFriction:
    """A regularised friction as a law: a program, times the load of the bearing of this number (-1: 1)."""

    program: Program
    bearing: int


@dataclass(frozen=True, eq=False)
class DryFrictions:
    """All dry friction of a scene: frictions that can stick, with their `names` in results; bearings; and regularised
    frictions by force and coordinate."""

    frictions: Frictions | None = None
    bearings: Bearings | None = None
    names: tuple[str, ...] = ()
    smooth: Mapping[tuple[str, str], SmoothFriction] = field(default_factory=dict)


def compile_friction(
    scene: Scene,
    joints: Sequence[Joint],
    axes: Sequence[Array],
    coordinates: Mapping[str, Binding],
    slips: Mapping[str, Binding],
) -> DryFrictions:
    """Return the dry friction on coordinates of joints.

    `joints` are the joints of the system, `axes` their z axes in the axes of body 2. `coordinates` are all coordinates
    of joints, by names such as "hinge.angle"; `slips` are those that friction resists in joints without a coordinate
    for them."""
    loads: list[_Load] = []
    frictions = list(_dry_frictions(scene, {joint.name: (at, joint) for at, joint in enumerate(joints)}, loads))
    frictions += _on_ropes(scene, joints, loads)
    sticking = [each for each in frictions if each.dry.regularised is None]
    smooth = {
        each.key: SmoothFriction(_smooth(each.dry, each.dry.regularised), each.bearing)
        for each in frictions
        if each.dry.regularised is not None
    }
    names = tuple(each.name for each in sticking)
    return DryFrictions(
        _frictions(sticking, coordinates, slips) if sticking else None,
        _bearings(loads, axes) if loads else None,
        names,
        smooth,
    )


@dataclass(frozen=True, eq=False)
class _Load:
    """A row of `Bearings`. With a `row` of the joint the load is the multiplier of this row. Without an axis the whole
    force counts."""

    joint: int
    radial: float
    axial: float
    length: float
    preload: float
    row: int | None = None
    has_axis: bool = True


def _dry_frictions(scene: Scene, joints: Mapping[str, tuple[int, Joint]], loads: list[_Load]) -> Iterator[_Dry]:
    """The dry frictions of a scene; the loads of their bearings are appended to `loads`."""
    for force in scene.forces:
        for coordinate, dry in force.coulomb.items() if isinstance(force, JointForce) else ():
            assert isinstance(force, JointForce)
            bearing = -1
            if dry.bearing is not None:
                at, joint = joints[force.joint]
                bearing = len(loads)
                loads.append(_load(at, joint, dry.unit, dry.bearing))
            place = scene.place("forces", force.name, "coulomb", coordinate)
            whole, name = f"{force.joint}.{coordinate}", force.called(coordinate)
            yield _Dry(force.name, coordinate, whole, name, f"force '{force.name}'", dry, bearing, place)


def _on_ropes(scene: Scene, joints: Sequence[Joint], loads: list[_Load]) -> Iterator[_Dry]:
    """The frictions of ropes on sheaves. The tension is T on one side and T e^(μα) on the other (Euler, Eytelwein). The
    friction is their difference, 2 tanh(μα/2) times their mean, which is the multiplier of the rope's row."""
    for at, joint in enumerate(joints):
        if "path" not in joint.parameters:
            continue
        path: Path = joint.parameters["path"]
        for one, k in enumerate(path.rubbing, 1):
            name, node = f"{joint.name}.slip_{one}", path.nodes[k]
            wrapped = reading(f"{joint.name}.wrapped_{one}")
            grip = formula("2*tanh(m*s/(2*r))", m=node.friction or 0.0, s=wrapped, r=node.radius)
            dry = DryFriction("m", grip, grip, bearing=Bearing())
            loads.append(_Load(at, 0.0, 1.0, math.inf, 0.0, 0, has_axis=False))
            place = scene.place("joints", joint.name, "path", k, "friction")
            owner = f"the friction on place {k + 1} of rope '{joint.name}'"
            yield _Dry(joint.name, f"slip_{one}", name, name, owner, dry, len(loads) - 1, place)


def _load(at: int, joint: Joint, unit: str, bearing: Bearing) -> _Load:
    """Return the load of a bearing of joint number `at`: in N m for an angle, in N for a displacement."""
    radius, kind = bearing.radius or 0.0, JOINTS[joint.type]
    if kind.slip:
        return _Load(at, 0.0, 1.0, math.inf, bearing.preload, 0, has_axis=False)
    if unit == "m":
        in_space = "space_arc" in (row[0] for row in kind.coordinates.values())
        return _Load(at, 1.0, 0.0, bearing.length, bearing.preload, has_axis=not in_space)
    if kind.is_threaded and bearing.axial_radius is None:
        return _Load(at, 0.0, radius, bearing.length, bearing.preload * radius)
    return _Load(at, radius, bearing.axial_radius or 0.0, bearing.length, bearing.preload * radius)


def _bearings(loads: Sequence[_Load], axes: Sequence[Array]) -> Bearings:
    def column(name: str) -> Array:
        return np.array([getattr(load, name) for load in loads], dtype=float)

    return Bearings(
        joint=np.array([load.joint for load in loads], dtype=np.intp),
        axis=np.array([axes[load.joint] if load.has_axis else np.zeros(3) for load in loads]),
        radial=column("radial"),
        axial=column("axial"),
        length=column("length"),
        preload=column("preload"),
        parts=tuple(() if load.row is None else ((load.joint, load.row, 1.0),) for load in loads),
    )


def _frictions(sticking: Sequence[_Dry], coordinates: Mapping[str, Binding], slips: Mapping[str, Binding]) -> Frictions:
    index = {name: at for at, name in enumerate(coordinates)}
    along = [coordinates.get(each.whole) or slips[each.whole] for each in sticking]
    laws = [each.dry for each in sticking]
    return Frictions(
        coordinates=bind([Binding(each.primitive, at, each.slots) for at, each in enumerate(along)]),
        joint_coordinate=np.array([index.get(each.whole, -1) for each in sticking], dtype=np.intp),
        sliding=np.array([np.nan if dry.varies else dry.sliding for dry in laws], dtype=float),
        static=np.array([np.nan if dry.varies else dry.static for dry in laws], dtype=float),
        stribeck=np.array([dry.stribeck_speed or 0.0 for dry in laws], dtype=float),
        bearing=np.array([each.bearing for each in sticking], dtype=np.intp),
        stop=np.full(len(sticking), -1, dtype=np.intp),
        partner=np.full(len(sticking), -1, dtype=np.intp),
        owners=tuple(each.owner for each in sticking),
        places=tuple(each.place for each in sticking),
        varies={at: _sizes(dry) for at, dry in enumerate(laws) if dry.varies},
    )


def _sizes(dry: DryFriction) -> tuple[Program, Program]:
    """Return the sliding and the static friction as functions: at least 0, and static at least sliding."""
    sliding = formula("max(0, f)", f=dry.sliding)
    return sliding, sliding if dry.static is dry.sliding else formula("max(f, g)", f=sliding, g=dry.static)


def _smooth(dry: DryFriction, width: float) -> Program:
    """Return -(sliding + (static - sliding) exp(-(s'/stribeck_speed)²)) tanh(s'/width) as a program. Its variables are
    the rate s' and the channels on which the friction depends."""
    rate = variable(RATE)
    if isinstance(dry.sliding, Program) or isinstance(dry.static, Program):
        (f, g), v = _sizes(dry), Program(rate)
        if dry.stribeck_speed is not None:
            f = formula("f + (g - f)*exp(-(v/fallen)**2)", f=f, g=g, v=v, fallen=dry.stribeck_speed)
        return formula("-f*tanh(v/width)", f=f, v=v, width=width)
    size: Code = number(dry.sliding)
    if dry.stribeck_speed is not None:
        part = apply(Op.DIVIDE, rate, number(dry.stribeck_speed))
        fall = apply(Op.EXP, apply(Op.NEGATE, (*part, Instruction(Op.POWER, 2.0))))
        size = apply(Op.ADD, size, apply(Op.MULTIPLY, number(dry.static - dry.sliding), fall))
    sign = apply(Op.TANH, apply(Op.DIVIDE, rate, number(width)))
    return Program(apply(Op.NEGATE, apply(Op.MULTIPLY, size, sign)))
