"""The forces of a scene at a state: forces and torques on the bodies, potential energy, power.

A law gives a generalised force F on a coordinate s(q). On every point and vector that s binds it acts with F ∂s/∂x, so
that its power is F s'. A bushing gives six such forces. Springs and preloads store energy, dampers lose it; functions
of a scene do work.
"""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array, Flags, Integers, Numbers, cross, like_of, numbers, total
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.constraints import set_velocity
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import Pose, Twist, body_rates
from mbproj.model.euler_parameters import matrix_E, product, rotation_matrix
from mbproj.model.forces import Bushings, Forces, Laws


@dataclass(frozen=True, eq=False)
class LawState:
    """The F coordinates that forces act along, their rates, and the forces of springs with preloads, of dampers and of
    functions along each, (..., F). `stored` (...): the energy in springs, in J. `bent`: the deflections of bushings,
    None without any."""

    value: Numbers
    rate: Numbers
    spring: Numbers
    damper: Numbers
    function: Numbers
    stored: Numbers
    bent: Deflection | None = None

    @property
    def force(self) -> Numbers:
        """The sum of the forces, (..., F), in N or N m."""
        return self.spring + self.damper + self.function


@dataclass(frozen=True, eq=False)
class Applied:
    """Forces (n+1, 3) in N at the centres of mass in global axes, and torques (n+1, 3) in N m about them in body axes.
    The power of functions and the power that dampers lose, in W; `apart`: the part of the losses that is counted
    separately."""

    force: Array
    torque: Array
    power: float
    dissipation: float
    apart: Array


def law_state(instant: Instant, held: Array | None = None, carried: Numbers | None = None) -> LawState:
    """Return the state of the laws and bushings of a system with forces, (...).

    `held`: the branches on which switches are held; None leaves all free. `carried` (..., B): the loads of bearings;
    None stands for 0.
    """
    forces = instant.system.forces
    if not forces.size:
        shape = instant.pose.position.shape[:-2]
        none = np.zeros((*shape, 0))
        return LawState(none, none, none, none, none, stored=np.zeros(shape))
    laws = forces.laws
    value, rate = law_coordinates(instant)
    function, damper = np.zeros_like(value), -laws.damping * rate
    for law in np.flatnonzero(laws.program >= 0):
        from mbproj.functions.values import value as value_of

        speed = rate[..., law]
        if laws.partner[law] >= 0:
            speed = np.hypot(speed, rate[..., laws.partner[law]])
        variables = instant.values(value[..., law], speed)
        force = value_of(forces.programs, int(laws.program[law]), variables, held)
        if laws.partner[law] >= 0:
            force = force * _along_sliding(laws, rate, int(law))
        if laws.bearing[law] >= 0:
            force = force * (0.0 if carried is None else carried[..., laws.bearing[law]])
        if laws.loses[law]:
            damper[..., law] += force
        else:
            function[..., law] = force
    extension = value - laws.free
    stored = 0.5 * total(laws.stiffness * extension**2)
    state = LawState(value, rate, -laws.stiffness * extension, damper, function, stored)
    return _with_bushings(forces, state, instant) if forces.bushings.size else state


def _along_sliding(laws: Laws, rate: Numbers, law: int) -> Numbers:
    """Return the component of the unit direction of friction in a plane along a law's tangent. The direction is that of
    the velocity, or its opposite where the velocity has reversed: a step may then pass through rest."""
    along, across, direction = rate[..., law], rate[..., laws.partner[law]], laws.sliding[law]
    speed, back = np.hypot(along, across), direction[0] * along + direction[1] * across < 0.0
    part = np.where(back, -along, along) / np.where(speed > 0.0, speed, 1.0)
    shares: Numbers = np.where(speed > 0.0, part, direction[0])
    return shares


def law_coordinates(instant: Instant) -> tuple[Numbers, Numbers]:
    """Return the coordinates of the laws and their rates, (..., E)."""
    laws, pose, expected = instant.system.forces.laws, instant.pose, instant.expected
    value = laws.coordinates.value(pose.places(laws.coordinates))
    turns = np.round((expected[..., laws.joint_coordinate] - value) / (2.0 * np.pi)) if laws.is_angle.any() else 0.0
    with np.errstate(divide="ignore", invalid="ignore"):  # `applied` reports points that coincide
        rate = set_velocity(laws.coordinates, pose, instant.twist)
    return value + 2.0 * np.pi * laws.is_angle * turns, rate


def _with_bushings(forces: Forces, laws: LawState, instant: Instant) -> LawState:
    """Return the state with the bushings after the laws."""

    bushings, bent = forces.bushings, deflection(forces.bushings, instant.pose)
    s, rate = bent.value, rates(bushings, bent, instant.pose, instant.twist)
    elastic = (bushings.stiffness @ s[..., None])[..., 0]
    damper = (-viscous(bushings, bent) @ rate[..., None])[..., 0]
    after = s, rate, bushings.preload - elastic, damper, np.zeros_like(s)
    before = laws.value, laws.rate, laws.spring, laws.damper, laws.function
    value, speed, spring, damped, function = (
        np.concatenate([first, last.reshape(*last.shape[:-2], -1)], axis=-1)
        for first, last in zip(before, after, strict=True)
    )
    stored = total(total((0.5 * elastic - bushings.preload) * s))
    return LawState(value, speed, spring, damped, function, laws.stored + stored, bent)


def applied(instant: Instant, held: Array | None = None, carried: Array | None = None) -> Applied:
    """Return all forces of the scene but gravity, on every body and the ground, at one state.

    `held`: the branches of switches; `carried` (B,): the loads of bearings.

    Raises SimulationError that names the force whose function has no finite value there, or that has no direction.
    """
    forces, pose, t = instant.system.forces, instant.pose, float(instant.t)
    state = law_state(instant, held, carried)
    if not np.all(np.isfinite(state.force)):
        from mbproj.equations.force_errors import law_fails

        raise law_fails(instant, state)
    force, torque = _along_coordinates(forces, pose, state.force, state.bent)
    if state.bent is not None and np.any(too_far := _stands_too_far(forces, state.bent)):
        from mbproj.equations.force_errors import turns_too_far

        raise turns_too_far(forces, np.where(too_far, state.bent.cosine, 1.0), t)
    given_force, given_torque = _on_bodies(instant, held)
    omega = body_rates(pose, instant.twist)
    power = np.sum(given_force * instant.twist.velocity) + np.sum(given_torque * omega) + state.function @ state.rate
    lost = -state.damper * state.rate
    apart = lost[: forces.laws.size][forces.laws.apart]
    return Applied(force + given_force, torque + given_torque, float(power), float(lost.sum()), apart)


def state_rates(instant: Instant, held: Array | None = None) -> Array:
    """Return x' of the states of elements, (K,), on the branches `held`. Raises SimulationError that names a state
    whose rate has no finite value."""
    system = instant.system
    if not len(instant.x):
        return instant.x
    from mbproj.functions.values import values

    rates = range(system.first_rate, system.first_rate + len(instant.x))
    of_states = np.array(values(system.programs, rates, instant.values(), held))
    if not np.isfinite(of_states).all():
        k = int(np.flatnonzero(~np.isfinite(of_states))[0])
        from mbproj.equations.force_errors import program_fails

        raise program_fails(instant, rates[k], f"state '{system.names.states[k]}'", instant.variables())
    return of_states


def require_values(instant: Instant) -> None:
    """Raise SimulationError that names the force, state or controller whose function has no finite value."""
    state_rates(instant)
    applied(instant)
    for action in range(instant.system.actions.size):
        action_values(instant, action)


def action_values(instant: Instant, action: int) -> Array:
    """Return the values that a controller's action gives to its states. Raises SimulationError that names a controller
    with a value that is not finite."""
    from mbproj.functions.values import values

    system = instant.system
    sets = system.actions.sets(action)
    assigned = np.array(values(system.actions.programs, sets, instant.values()))
    if not np.isfinite(assigned).all():
        k = sets[int(np.flatnonzero(~np.isfinite(assigned))[0])]
        from mbproj.equations.force_errors import program_fails

        raise program_fails(instant, k, system.actions.names[action], instant.variables(), system.actions.programs)
    return assigned


def generalised(pose: Pose, force: Array, torque: Array) -> Array:
    """Return Q (7n,) of forces (n+1, 3), global, and torques (n+1, 3), body axes: (F, 2 Lᵀτ / |Λ|²) for each body."""
    norm2 = np.sum(pose.orientation * pose.orientation, axis=-1)[:, None]
    turning = 2.0 * (np.swapaxes(pose.L, -1, -2) @ torque[..., None])[..., 0] / norm2
    return np.concatenate([force, turning], axis=-1)[:-1].ravel()


def unit_pull(forces: Forces, pose: Pose, law: int) -> tuple[Array, Array]:
    """Return the forces and torques on every body and the ground, as in `Applied`, of a unit force along one of the F
    coordinates."""
    size = np.zeros(forces.size)
    size[law] = 1.0
    if not forces.bushings.size:
        return _along_coordinates(forces, pose, size, None)

    return _along_coordinates(forces, pose, size, deflection(forces.bushings, pose))


def _along_coordinates(forces: Forces, pose: Pose, size: Numbers, bent: Deflection | None) -> tuple[Array, Array]:
    """Return the forces and torques on the bodies of forces `size` (F,) along the coordinates. Every attachment of a
    law is pulled with F ∂s/∂x."""
    bound = forces.laws.coordinates
    gradient = bound.gradient_entries(pose.places(bound))
    pull = size[bound.entry_row, None] * gradient
    body, local = bound.body[bound.entry_slot], bound.local[bound.entry_slot]
    force, torque = np.zeros_like(pose.position), np.zeros_like(pose.position)
    np.add.at(force, body, bound.is_point[bound.entry_slot, None] * pull)
    np.add.at(torque, body, cross(local, _in_body(pose, body, pull)))
    if bent is not None:
        bushings, bushing_force = forces.bushings, size[forces.laws.size :]
        pulls = wrenches(bushings, bent, pose, bushing_force.reshape(bushings.size, -1))
        for total, part in zip((force, torque), pulls, strict=True):
            np.add.at(total, bushings.body, part)
    return force, torque


def _stands_too_far(forces: Forces, bent: Deflection) -> Flags:
    too_far: Flags = (bent.cosine < np.cos(0.5 * THRESHOLDS.most_turned)) & ~forces.bushings.turns_freely
    return too_far


def given_components(instant: Instant, held: Array | None = None) -> Array:
    """Return the values of the programs of given forces and torques, (..., W, 3)."""
    from mbproj.functions.values import values

    forces, samples = instant.system.forces, np.shape(instant.t)
    programs = forces.on_bodies.program.ravel().tolist()
    each = [np.broadcast_to(value, samples) for value in values(forces.programs, programs, instant.values(), held)]
    return np.moveaxis(numbers(each), 0, -1).reshape(*samples, len(programs) // 3, 3)


def given_vectors(instant: Instant, held: Array | None = None) -> Array:
    """Return the given forces and torques in global axes, (W, 3). Raises SimulationError where one is not finite."""
    on_bodies, vector = instant.system.forces.on_bodies, given_components(instant, held)
    if not np.all(np.isfinite(vector)):
        from mbproj.equations.force_errors import force_fails

        raise force_fails(instant, int(on_bodies.program[~np.isfinite(vector)][0]))
    return in_global_axes(instant, vector)


def in_global_axes(instant: Instant, vector: Array) -> Array:
    """Return components (..., W, 3) of the given forces and torques in global axes; those in body axes are turned."""
    on_bodies = instant.system.forces.on_bodies
    carried = (on_bodies.turn @ vector[..., None])[..., 0]
    turned = (instant.pose.rotation[..., on_bodies.body, :, :] @ carried[..., None])[..., 0]
    vectors: Array = np.where(on_bodies.in_body[:, None], turned, vector)
    return vectors


def _on_bodies(instant: Instant, held: Array | None) -> tuple[Array, Array]:
    """Return the forces and torques on the bodies of the given forces and torques."""
    on_bodies, pose = instant.system.forces.on_bodies, instant.pose
    force, torque = np.zeros_like(pose.position), np.zeros_like(pose.position)
    if not on_bodies.size:
        return force, torque
    vector = given_vectors(instant, held)
    np.add.at(force, on_bodies.body, np.where(on_bodies.is_torque[:, None], 0.0, vector))
    in_body = _in_body(pose, on_bodies.body, vector)
    np.add.at(torque, on_bodies.body, np.where(on_bodies.is_torque[:, None], in_body, cross(on_bodies.point, in_body)))
    return force, torque


def _in_body(pose: Pose, body: Integers, vector: Array) -> Array:
    """Return global vectors (e, 3) in the axes of bodies (e,)."""
    return (vector[:, None, :] @ pose.rotation[body])[:, 0, :]


# --- Bushings at a pose -----------------------------------------------------------------------------------------------
# Six coordinates each, in the axes of the frame midway between their two frames.
# R is the rotation from frame 1 to frame 2, φ its rotation vector, and A the orientation of the frame that half of R
# leads to. The coordinates are x = Aᵀ d, with d from origin to origin, and φ, whose components are the same in all
# three frames. This frame treats both bodies alike. With angular velocities in the axes of the midway frame,
#
#    φ' = H (ω2 - ω1),    H = n nᵀ + (θ/2) / sin(θ/2) (1 - n nᵀ),    θ = |φ|, n = φ / θ
#    x' = Aᵀ d' + x × ω,  ω = ½ (ω1 + ω2) - ½ tan(θ/4) n × (ω2 - ω1) of the midway frame.
# Dampers of rotation act on ω2 - ω1, so that their torque does not depend on the angle between the frames: the force
# along φ is -H⁻¹ c H⁻¹ φ', and the torque -c (ω2 - ω1).


#: sin²(θ/2) up to which (θ/2) / sin(θ/2) is computed from its series, whose next term is below ε.
SMALL = 1e-3
_UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Deflection:
    """The coordinates of bushings and their derivatives at a pose.

    `value` (..., B, 6): the coordinates s, translations and then the rotation vector. `gradient` (..., B, 2, 6, 6): s'
    for a velocity of the centre of mass and an angular velocity, both in global axes, of each of the two bodies.
    `turning` (..., B, 3, 3): H⁻¹, with ω2 - ω1 = H⁻¹ φ'. `cosine` (..., B): that of half the angle, which vanishes at
    half a turn."""

    value: Numbers
    gradient: Numbers
    turning: Numbers
    cosine: Numbers


def deflection(bushings: Bushings, pose: Pose) -> Deflection:
    """Return the deflections of all bushings at poses (...)."""
    return deflected(bushings, pose.position[..., bushings.body, :], pose.orientation[..., bushings.body, :])


def deflected(bushings: Bushings, position: Numbers, orientation: Numbers) -> Deflection:
    """Return the deflections for positions (..., B, 2, 3) and Euler parameters (..., B, 2, 4) of the bodies; both may
    be complex."""
    unit = orientation / np.sqrt(np.sum(orientation * orientation, axis=-1, keepdims=True))
    frames = product(unit, bushings.turn)
    relative = product(frames[..., 0, :] * _CONJUGATE, frames[..., 1, :])
    relative = relative * np.where(relative[..., :1].real < 0.0, -1.0, 1.0)
    cosine, sines = relative[..., 0], relative[..., 1:]
    half = (relative + _UNTURNED) / np.sqrt(2.0 + 2.0 * cosine)[..., None]
    A = rotation_matrix(product(frames[..., 0, :], half))
    longer, H, turning = _rates_of_rotation(cosine, sines)
    arm = (rotation_matrix(orientation) @ bushings.origin[..., None])[..., 0]
    ends = position + arm
    to_midway = np.swapaxes(A, -1, -2)
    x = (to_midway @ (ends[..., 1, :] - ends[..., 0, :])[..., None])[..., 0]
    carried, lead = _cross_matrix(x), _cross_matrix(sines / (1.0 + cosine)[..., None])
    gradient = np.zeros((*cosine.shape, 2, 6, 6), dtype=cosine.dtype, like=x)
    for side, sign in enumerate((-1.0, 1.0)):
        share = 0.5 * (np.eye(3) - sign * lead)  # the contribution of this body's ω to that of the midway frame
        gradient[..., side, :3, :3] = sign * to_midway
        gradient[..., side, :3, 3:] = carried @ share @ to_midway - sign * to_midway @ _cross_matrix(arm[..., side, :])
        gradient[..., side, 3:, 3:] = sign * H @ to_midway
    return Deflection(np.concatenate([x, 2.0 * longer * sines], axis=-1), gradient, turning, cosine)


def rates(bushings: Bushings, bent: Deflection, pose: Pose, twist: Twist) -> Numbers:
    """Return s', (..., B, 6)."""
    orientation = pose.orientation[..., bushings.body, :]
    turning = 2.0 * (matrix_E(orientation) @ twist.rate[..., bushings.body, :, None])[..., 0]
    omega = turning / np.sum(orientation * orientation, axis=-1, keepdims=True)
    motion = np.concatenate([twist.velocity[..., bushings.body, :], omega], axis=-1)
    return np.sum((bent.gradient @ motion[..., None])[..., 0], axis=-2)


def viscous(bushings: Bushings, bent: Deflection) -> Numbers:
    """Return the damping along the coordinates, (..., B, 6, 6): the dampers' forces are its product with -s'."""
    damping = np.broadcast_to(bushings.damping, (*bent.cosine.shape, 6, 6)).astype(bent.turning.dtype)
    along = np.array(damping, like=like_of(damping, bent.turning))
    along[..., 3:, 3:] = bent.turning @ bushings.damping[:, 3:, 3:] @ bent.turning
    return along


def wrenches(bushings: Bushings, bent: Deflection, pose: Pose, force: Array) -> tuple[Array, Array]:
    """Return the effect of forces (..., B, 6) along the coordinates on both bodies at one pose, (..., B, 2, 3): forces
    in global axes, and torques about their centres of mass in body axes."""
    pull = (np.swapaxes(bent.gradient, -1, -2) @ force[..., None, :, None])[..., 0]
    orientation = pose.orientation[bushings.body]
    axes = pose.rotation[bushings.body] / np.sum(orientation * orientation, axis=-1)[..., None, None]
    return pull[..., :3], (pull[..., None, 3:] @ axes)[..., 0, :]


def _rates_of_rotation(cosine: Numbers, sines: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Return (θ/2) / sin(θ/2), (..., 1), and H and H⁻¹, (..., 3, 3), from cos(θ/2) and n sin(θ/2)."""
    q = np.sum(sines * sines, axis=-1)
    is_large = q.real > SMALL
    square = np.where(is_large, q, 1.0)
    sine = np.sqrt(square)
    half = np.where(is_large, np.arctan2(sine.real, cosine.real), 0.0)
    if np.iscomplexobj(q):  # numpy.arctan2 takes real arguments only
        half = half + 1j * (cosine.real * sine.imag - sine.real * cosine.imag)
    small = 1.0 / 6.0 + q * (3.0 / 40.0 + q * (5.0 / 112.0 + q * (35.0 / 1152.0 + q * (63.0 / 2816.0))))
    longer = np.where(is_large, half / sine, 1.0 + q * small)
    along = np.where(is_large, (1.0 - longer) / square, -small)
    longer, along = longer[..., None, None], along[..., None, None] * sines[..., :, None] * sines[..., None, :]
    return longer[..., 0], longer * np.eye(3) + along, (np.eye(3) - along) / longer


def _cross_matrix(vector: Numbers) -> Numbers:
    """Return the matrices (..., 3, 3) of the products vector × ."""
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
