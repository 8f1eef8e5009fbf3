"""Bushings at a pose: six coordinates each, in the axes of the frame midway between their two frames.

R is the rotation from frame 1 to frame 2, φ its rotation vector, and A the orientation of the frame that half of R
leads to. The coordinates are x = Aᵀ d, with d from origin to origin, and φ, whose components are the same in all three
frames. This frame treats both bodies alike. With angular velocities in the axes of the midway frame,

    φ' = H (ω2 - ω1),    H = n nᵀ + (θ/2) / sin(θ/2) (1 - n nᵀ),    θ = |φ|, n = φ / θ
    x' = Aᵀ d' + x × ω,  ω = ½ (ω1 + ω2) - ½ tan(θ/4) n × (ω2 - ω1) of the midway frame.


Dampers of rotation act on ω2 - ω1, so that their torque does not depend on the angle between the frames: the force
along φ is -H⁻¹ c H⁻¹ φ', and the torque -c (ω2 - ω1).
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Numbers, like_of
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.model.euler_parameters import matrix_E, product, rotation_matrix
from mbproj.model.forces import Bushings

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
