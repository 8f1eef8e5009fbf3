"""Assembly: the consistent state nearest to the scene's guess, or an error that names the joint.

Near means geometrically near: Σ |Δr|² + length² |Δθ|², where the size of the system weighs turns against shifts. The
mass matrix has no part in it, because the guess has no meaning as energy (Nikravesh 2007).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Array, Flags, Integers
from mbproj.base.dataclass import brief, dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.askew import askew
from mbproj.equations.assembly.gauss_newton import gauss_newton, in_coordinates, set_rows, shortest_of
from mbproj.equations.constraints import constraint, constraint_velocity, set_velocity, time_derivative
from mbproj.equations.gaps import gap_rates, gaps, stop_sizes
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import Pose, attached, pose_of, twist_of
from mbproj.equations.motions import Drive, drive_at
from mbproj.model.channels import NO_MOTIONS, Motions
from mbproj.model.compile.mechanism import Guess
from mbproj.model.euler_parameters import matrix_L, product
from mbproj.model.layout import Layout
from mbproj.model.system import Conditions, System
from mbproj.scene.scene import Scene

if TYPE_CHECKING:
    from mbproj.equations.blocks import Rows


@dataclass(frozen=True, eq=False)
class State:
    """Time in s, and y with its layout: coordinates q and velocities v = q' (7n,), whole turns (nc,) of each joint
    coordinate, states of elements."""

    t: float
    y: Array
    layout: Layout

    __repr__ = brief

    @classmethod
    def of(cls, system: System, t: float, **blocks: Array | Integers) -> State:
        """Return a state made of blocks; a block that is not given has its initial values."""
        return cls(t, system.layout.vector_of(blocks), system.layout)

    def changed(self, **blocks: Array | Integers) -> State:
        """Return the state with these blocks replaced."""
        return State(self.t, self.layout.changed(self.y, blocks), self.layout)

    @property
    def q(self) -> Array:
        return self.y[self.layout["positions"]]

    @property
    def v(self) -> Array:
        return self.y[self.layout["velocities"]]

    @property
    def x(self) -> Array:
        """The states of elements."""
        return self.y[self.layout["states"]]

    @property
    def turns(self) -> Integers:
        return self.y[self.layout["turns"]].astype(np.intp)

    def instant(self, system: System) -> Instant:
        """Return the `Instant` at this state, from which functions of the system take their variables."""
        pose = pose_of(self.q)

        def counted() -> Array:
            return coordinate_values(system, pose) + 2.0 * np.pi * self.turns

        return Instant(system, pose, twist_of(pose, self.v), self.t, counted, self.x)


def assemble(system: System, guess: Guess) -> State:
    """Return the consistent state nearest to the guess that meets the joints' `start` and `speed` conditions and the
    motions.

    Raises InputError that names the worst joint with its residual in metres and radians, or the motion at fault.
    """
    drive = drive_at(system, 0.0)
    if system.driven:
        refuse_contradictions(system, guess, drive)
    q = _close(system.at_positions, guess.q, guess.start, drive)
    pose = pose_of(q)
    _refuse_flips(system, pose)
    angles = coordinate_values(system, pose)
    turns = np.zeros(len(angles), dtype=np.intp)
    known = [*guess.start.index.tolist(), *system.motions.joint_coordinate.tolist()]
    for index, value in zip(known, [*guess.start.value.tolist(), *drive.value.tolist()], strict=True):
        turns[index] = np.round((value - angles[index]) / (2 * np.pi))
    turns *= is_angle(system)
    v = _consistent_velocity(system, q, pose, guess, drive)
    if system.stops is not None:
        v = _clear_of_stops(system, q, pose, turns, guess, drive, v)
    return State.of(system, 0.0, positions=q, velocities=v, turns=turns)


def coordinate_values(system: System, pose: Pose) -> Array:
    """Return the joints' coordinates (..., nc): displacements in m, angles in rad within (-π, π]."""
    return system.coordinates.value(pose.places(system.coordinates))


def coordinates(system: System, q: Array, v: Array) -> tuple[Array, Array]:
    """Return the joints' coordinates without turns, and their rates, (nc,) each."""
    pose = pose_of(q)
    return coordinate_values(system, pose), set_velocity(system.coordinates, pose, twist_of(pose, v))


def turns_of(system: System, q: Array, counted: Array) -> Array:
    """Return whole turns (T, nc) at poses q (T, 7n), where `counted` (T, nc) are the coordinates with turns. At half a
    turn round-off decides on which side of ±π an angle lies. So the turns belong to the angle as computed here."""
    return np.rint((counted - coordinate_values(system, pose_of(q))) / (2.0 * np.pi)) * is_angle(system)


def moved_by(before: Array, after: Array) -> tuple[float, float]:
    """Return the largest shift in m and the largest turn in rad of a body between two coordinate vectors (7n,)."""
    old, new = before.reshape(-1, 7), after.reshape(-1, 7)
    shift = float(np.linalg.norm(new[:, :3] - old[:, :3], axis=1).max())
    sine = np.linalg.norm(matrix_L(old[:, 3:]) @ new[:, 3:, None], axis=(1, 2))
    return shift, float(2.0 * np.arcsin(np.minimum(sine, 1.0)).max())


def moved_from_scene(scene: Scene, system: System, q: Array) -> tuple[float, float]:
    """Return the largest shift in m and turn in rad of a body from its pose in the scene to that at q. All bodies of
    the scene count, also those merged by fixed joints."""
    pose, carrier = pose_of(q), system.body_carrier
    position = attached(pose, carrier, system.body_offset, np.ones(len(carrier)))
    orientation = product(pose.orientation[carrier], system.body_turn)
    starts = [body.start or (body.position, body.orientation) for body in scene.bodies]
    in_scene = np.array([(*place, *turn) for place, turn in starts])
    return moved_by(in_scene, np.concatenate([position, orientation], axis=1))


def is_angle(system: System) -> Integers:
    """Return 1 for joint coordinates that count turns, 0 for displacements, (nc,)."""
    return np.array([unit == "rad" for unit in system.names.coordinate_units], dtype=np.intp)


def _close(system: System, q: Array, start: Conditions, drive: Drive) -> Array:
    """Return the closed pose next to q. Raises InputError where there is none."""
    closed, residual = nearest(system, q, start, drive, _close_enough(system))
    if np.abs(residual).max(initial=0.0) <= THRESHOLDS.assembled:
        return closed
    if system.driven:
        undriven = replace(system, motions=NO_MOTIONS)
        _close(undriven, q, start, drive_at(undriven, 0.0))

        raise motions_out_of_reach(system, residual[system.joints.size :][: system.driven])
    raise _not_closed(system, residual)


def nearest(system: System, q: Array, start: Conditions, drive: Drive, close_enough: float) -> tuple[Array, Array]:
    """Return the pose that Gauss-Newton with the shortest weighted step reaches, and the violation left there, in rad
    and parts of the length. The iteration ends at the violation `close_enough`."""

    def residual(pose: Pose) -> Array:
        return scaled_residual(system, pose, start, drive)

    def rows(pose: Pose) -> Rows:
        return scaled_rows(system, pose, start)

    return gauss_newton(system, q, residual, rows, close_enough)


def scaled_residual(system: System, pose: Pose, start: Conditions, drive: Drive) -> Array:
    """Return the joint, motion and start rows at poses (...), lengths in units of the system's length, (..., m + c)."""
    rows: Array = (constraint(system, pose, drive) / system.row_scale)[..., system.bodies :]
    if not len(start.index):
        return rows
    excess = coordinate_values(system, pose)[..., start.index] - start.value
    excess = np.where(_asked_angles(system, start), np.arctan2(np.sin(excess), np.cos(excess)), excess / system.length)
    return np.concatenate([rows, excess], axis=-1)


def scaled_rows(system: System, pose: Pose, start: Conditions) -> Rows:
    """Return the derivatives of `scaled_residual` by (δr / length, δθ) of each body."""
    scale = system.row_scale[system.bodies :]
    if len(start.index):
        scale = np.concatenate([scale, np.where(_asked_angles(system, start), 1.0, system.length)])
    return _rows(system, pose, start).scaled(1.0 / scale)


def _asked_angles(system: System, asked: Conditions) -> Flags:
    return is_angle(system)[asked.index].astype(bool)


def _rows(system: System, pose: Pose, asked: Conditions) -> Rows:
    """Return the derivatives of the joints' and the motions' rows, and of the coordinates in `asked`."""
    rows = set_rows(system, system.rows, pose)
    if not len(asked.index):
        return rows
    from mbproj.equations.blocks import stacked

    return stacked(system.bodies, [rows, set_rows(system, system.coordinates, pose).chosen(asked.index)])


def _not_closed(system: System, residual: Array) -> InputError:
    joints = np.abs(residual[: system.joints.size])
    owner, is_length = system.joints.owner, system.joints.is_length
    if joints.max(initial=0.0) > 0.1 * np.abs(residual).max():
        worst = int(owner[np.argmax(joints)])
        message = "the mechanism does not close"
    else:
        wanted = np.argmax(np.abs(residual[system.joints.size :]))
        worst = int(system.coordinates.owner[wanted])
        message = "the mechanism cannot reach the coordinates that its joints ask for"
    length = joints[(owner == worst) & is_length].max(initial=0.0) * system.length
    angle = joints[(owner == worst) & ~is_length].max(initial=0.0)
    others = [
        f"'{name}'"
        for index, name in enumerate(system.names.joints)
        if index != worst and joints[owner == index].max(initial=0.0) > 0.1 * joints.max()
    ]
    shared = f", and the gap is shared with {', '.join(others)}" if others else ""
    return InputError(
        Problem(
            f"{message}: joint '{system.names.joints[worst]}' stays open by {length:.3g} m and {angle:.3g} rad{shared}",
            system.joint_places[worst],
            "check the locations and axes of its loop, the lengths of the bodies, and the pose that 'bodies' guesses",
        )
    )


def _refuse_flips(system: System, pose: Pose) -> None:
    cosines = system.alignment.value(pose.places(system.alignment))
    if np.any(cosines < 0.0):
        worst = int(system.alignment.owner[np.argmin(cosines)])
        raise InputError(
            Problem(
                f"assembly turned the axis of joint '{system.names.joints[worst]}' by 180 degrees",
                system.joint_places[worst],
                "give a pose in 'bodies' that is nearer to the closed one, or reverse the axis in one body",
            )
        )


def _close_enough(system: System) -> float:
    """Return the violation at which closing ends: round-off. For a large system it is a little more, which saves
    further factorisations; the first projection removes the rest."""
    return 1e-15 if system.bodies <= THRESHOLDS.large else 1e-12


def _clear_of_stops(
    system: System, q: Array, pose: Pose, turns: Integers, guess: Guess, drive: Drive, v: Array
) -> Array:
    """Return a velocity with which no rigid stop that touches closes, unless the guess or the joints' speeds ask for
    that. The nearest velocity v knows nothing of stops."""
    from mbproj.equations.blocks import stacked

    stops, held = system.stops, np.zeros(0, dtype=np.intp)
    assert stops is not None
    slack = THRESHOLDS.same_written * stop_sizes(system)
    closed = stops.is_rigid & (np.abs(gaps(stops, pose, turns)) <= slack)
    closed &= gap_rates(stops, pose, twist_of(pose, _on_spheres(q, guess.v))) >= -slack
    clear = v
    while len(into := np.flatnonzero(closed & (gap_rates(stops, pose, twist_of(pose, clear)) < -slack))):
        if np.isin(into, held).any():
            return v  # the joints' speeds ask for it
        held = np.union1d(held, into)
        move = shortest_of(stacked(system.bodies, [_rows(system, pose, guess.speed), _stop_rows(system, pose, held)]))
        for _ in range(2):
            of_stops = gap_rates(stops, pose, twist_of(pose, clear))[held] * stops.side[held]
            left = np.concatenate([_velocity_residual(system, pose, guess, drive, clear), of_stops])
            clear = clear + in_coordinates(system, q, move(-left))
        if np.abs(_velocity_residual(system, pose, guess, drive, clear)).max(initial=0.0) > slack.min():
            return v
    return clear


def _stop_rows(system: System, pose: Pose, held: Integers) -> Rows:
    assert system.stops is not None
    return set_rows(system, system.stops.coordinates, pose).chosen(held)


def _on_spheres(q: Array, v: Array) -> Array:
    """The velocity v with |Λ| constant."""
    velocity, Λ = v.reshape(-1, 7), q.reshape(-1, 7)[:, 3:]
    turning = velocity[:, 3:] - np.sum(Λ * velocity[:, 3:], axis=1, keepdims=True) * Λ
    return np.concatenate([velocity[:, :3], turning], axis=1).ravel()


def _velocity_residual(system: System, pose: Pose, guess: Guess, drive: Drive, v: Array) -> Array:
    """C_q v + C_t of the joints and motions, then what the joints' speeds lack."""
    twist = twist_of(pose, v)
    rows: Array = constraint_velocity(system, pose, twist, drive)[system.bodies :]
    if not len(guess.speed.index):
        return rows
    speeds = set_velocity(system.coordinates, pose, twist)[guess.speed.index]
    return np.concatenate([rows, speeds - guess.speed.value])


def _consistent_velocity(system: System, q: Array, pose: Pose, guess: Guess, drive: Drive) -> Array:
    """Return the velocity nearest to the guess with C_q v + C_t = 0 and the joints' speeds."""
    wanted = np.concatenate([-time_derivative(system, drive), guess.speed.value])
    if not wanted.any() and not guess.v.any():
        return guess.v  # the guess is at rest, and no row or condition asks for a velocity

    residual = partial(_velocity_residual, system, pose, guess, drive)
    v = _on_spheres(q, guess.v)
    if system.bodies > THRESHOLDS.large and np.abs(residual(v)).max(initial=0.0) <= _close_enough(system):
        return v
    move = shortest_of(_rows(system, pose, guess.speed))
    for _ in range(2):
        v = v + in_coordinates(system, q, move(-residual(v)))
    left = np.abs(residual(v))
    size = np.maximum(np.abs(wanted).max(initial=1.0), np.abs(guess.v).max())
    grain = 4096.0 * np.finfo(float).eps * np.abs(v).max()
    of_joints, of_motions, of_speeds = np.split(left, [system.joints.size, system.constraints - system.bodies])
    # Joints of a loop whose numbers are rounded open a little as it moves; the rank decides whether they lock it.
    asked = np.concatenate([of_motions, of_speeds]).max(initial=0.0)
    if asked > 1e-9 * size + grain or of_joints.max(initial=0.0) > THRESHOLDS.in_doubt * size + grain:
        if of_motions.max(initial=0.0) > of_speeds.max(initial=0.0):
            raise motions_at_odds(system, pose, of_motions)
        raise speeds_at_odds(system, guess, q, of_joints, of_speeds)
    return v


# --- Motions and speeds at the start of a run -------------------------------------------------------------------------
# Errors where the mechanism cannot meet them.


def refuse_contradictions(system: System, guess: Guess, drive: Drive) -> None:
    """Raise InputError where a motion starts at another value or speed than its joint's own conditions."""
    motions, problems = system.motions, []
    for number, index in enumerate(motions.joint_coordinate.tolist()):
        name, unit = system.names.coordinates[index], system.names.coordinate_units[index]
        for word, conditions, actual in (
            ("", guess.start, drive.value[number]),
            (" per s", guess.speed, drive.rate[number]),
        ):
            asked = _value_at(conditions, index)
            if asked is not None and abs(asked - actual) > THRESHOLDS.same_written * (1.0 + abs(asked)):
                message = (
                    f"motion '{system.names.motions[number]}' begins with {name} at {actual:.6g} {unit}{word}, "
                    f"and the joint's own condition asks for {asked:.6g}"
                )
                problems.append(Problem(message, motions.places[number], "take the joint's condition out"))
    if problems:
        raise InputError(problems)


def _value_at(conditions: Conditions, index: int) -> float | None:
    values = conditions.value[conditions.index == index]
    return float(values[0]) if len(values) else None


def motions_out_of_reach(system: System, left: Array) -> InputError:
    """Return the error for motions whose initial values the joints cannot reach; `left` (k,) is the scaled violation of
    each."""
    hint = "begin at the pose that 'bodies' gives, or take out other motions and conditions"
    return _worst(system, left, "the mechanism cannot reach where motion '{}' begins", hint)


def motions_at_odds(system: System, pose: Pose, left: Array) -> InputError:
    """Return the error for motions whose velocities contradict; `left` (k,) is the violation of each."""
    hint = "its joints, or other motions and speeds, hold it: drive no more than there are degrees of freedom"
    hint = askew(system, pose) or hint
    return _worst(system, left, "the mechanism cannot move as motion '{}' asks at the start", hint)


def speeds_at_odds(system: System, guess: Guess, q: Array, of_joints: Array, of_speeds: Array) -> InputError:
    """Return the error for joints' speeds that no velocity meets: they contradict each other, or joints would open. The
    violations are those of the joints' rows and of the speeds."""
    message, hint = "the mechanism cannot move at the speeds that its joints ask for", "give fewer speeds, or others"
    if of_speeds.max(initial=0.0) >= of_joints.max(initial=0.0):
        number = int(np.argmax(of_speeds))
        coordinate = guess.speed.index[number]
        worst, unit = int(system.coordinates.owner[coordinate]), f"{system.names.coordinate_units[coordinate]}/s"
        left, asked = f"{of_speeds[number]:.3g} {unit}", f"{guess.speed.value[number]:.4g} {unit}"
        off = f"'{system.names.coordinates[coordinate]}' stays {left} away from its {asked}"
        hint = "give fewer speeds than degrees of freedom, or speeds that agree"
    else:
        from mbproj.equations.assembly.compiled import needed, rounded_up

        row = int(np.argmax(of_joints))
        worst = int(system.joints.owner[row])
        off = f"joint '{system.names.joints[worst]}' would open at {of_joints[row]:.3g} {system.joints.units[row]}/s"
        if size := needed(system, q):
            hint = f"its loop moves where joints are moved a little: give adjust_joints: {rounded_up(size)}"
        hint = askew(system, pose_of(q)) or hint
    return InputError(Problem(f"{message}: {off}", system.joint_places[worst], hint))


def _worst(system: System, left: Array, message: str, hint: str) -> InputError:
    worst = int(np.argmax(np.abs(left)))
    return InputError(Problem(message.format(system.names.motions[worst]), system.motions.places[worst], hint))


# --- Refuses motions that jump ----------------------------------------------------------------------------------------
# Bodies with mass cannot follow a jump of position, and a jump of velocity takes an impulse.


HINT = "a motion needs a continuous velocity: lead over with a smooth_step or a table"


def refuse_jumps(system: System, start: float, end: float) -> None:
    """Raise InputError where a motion's value or velocity jumps from `start` to `end`. Jumps of the acceleration alone
    are allowed: the driving force jumps with it."""
    problems = _problems(system.motions, system.names.motions, system.names.motion_units, start, end)
    if problems:
        raise InputError(list(problems))


@lru_cache(maxsize=256)
def _problems(
    motions: Motions, names: tuple[str, ...], units: tuple[str, ...], start: float, end: float
) -> tuple[Problem, ...]:
    """Return the first jump of each motion. The result is cached: studies run one mechanism many times."""
    return tuple(
        Problem(f"motion '{name}' {jump}", motions.places[number], HINT)
        for number, (name, unit) in enumerate(zip(names, units, strict=True))
        for jump in _first_jump(motions, number, unit, start, end)
    )


def _first_jump(motions: Motions, number: int, unit: str, start: float, end: float) -> Iterator[str]:
    from mbproj.functions.kinks import kinks

    for kink in kinks(motions.programs, number, start, end):
        value, rate, _ = kink.jump
        if value:
            yield f"jumps by {abs(value):.6g} {unit} at t = {kink.t:.9g} s"
        elif rate:
            yield f"changes its velocity by {abs(rate):.6g} {unit}/s at once at t = {kink.t:.9g} s"
        if value or rate:
            return
