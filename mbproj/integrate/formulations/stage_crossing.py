"""Channels in the stages of an implicit step of the full formulation.

With δx'_j = x'_j - before_j, δa_j likewise, and weights W, states change by δx = W δx' and coordinates by δs = W² G δa,
δs' = W G δa. Of δx' = f - before + f_x δx + f_s δs + f_s' δs' follows

    δx' = (1 - W f_x)⁻¹ (f - before + B δa),      B = W² f_s G + W f_s' G,


so that forces which depend on states add -F_x W (1 - W f_x)⁻¹ B to the matrix, which is not symmetric. Nothing is
dropped.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime, channel_equations
from mbproj.dynamics.derivatives.tangent import tangent_velocities
from mbproj.dynamics.equations.instant import Instant


@dataclass(frozen=True, eq=False)
class StageCrossing:
    """The derivatives through channels at one stage.

    `elastic`, `viscous` (7n, 7n): what forces that name coordinates and rates add to JᵀkJ and JᵀcJ. `push` (7n, K): the
    generalised forces of states. `by_position`, `by_velocity` (K, 7n): ∂x'/∂q and ∂x'/∂q'. `by_states` (K, K): f_x."""

    elastic: Array
    viscous: Array
    push: Array
    by_position: Array
    by_velocity: Array
    by_states: Array

    @property
    def pushes(self) -> bool:
        """Whether forces name channels."""
        return bool(self.push.any() or self.elastic.any() or self.viscous.any())

    @classmethod
    def at(cls, instant: Instant, v: Array) -> StageCrossing:
        """Return the derivatives at a state with velocities v (7n,)."""
        pose, n = instant.pose, 7 * instant.system.bodies
        q = np.concatenate([pose.position[:-1], pose.orientation[:-1]], axis=1).ravel()
        u = tangent_velocities(pose, v)
        motion = MotionAtTime(
            float(instant.t), q, u, np.zeros_like(u), np.asarray(instant.expected), np.asarray(instant.x)
        )
        D, K, states = channel_equations(instant.system, motion)
        T = np.zeros((instant.system.bodies, 6, instant.system.bodies, 7))
        every = np.arange(instant.system.bodies)
        T[every, :3, every, :3], T[every, 3:, every, 3:] = np.eye(3), 2.0 * pose.L[:-1]
        turned = T.reshape(-1, n)
        push, by_position, by_velocity = (
            part.dense() @ turned for part in (states.push, states.by_displacement, states.by_rate)
        )
        elastic, viscous = (turned.T @ part.dense() @ turned for part in (K, D))
        return cls(elastic, viscous, push.T, by_position, by_velocity, states.by_states)


@dataclass(frozen=True, eq=False)
class Crossing:
    """The matrices of s stages, whose accelerations have this `size`, the first 7n of them q''.

    `left` (sK, sK) = 1 - W f_x, `by_motion` (sK, s size) = B, and `push` (s size, sK) = F_x W."""

    left: Array
    by_motion: Array
    push: Array

    @classmethod
    def of(cls, stages: list[StageCrossing], weights: Array, size: int) -> Crossing:
        """Return the matrices of stages with these weights."""
        count, (n, K) = len(stages), stages[0].push.shape
        left, twice = np.eye(count * K).reshape(count, K, count, K), weights @ weights
        by_motion, push = np.zeros((count, K, count, size)), np.zeros((count, size, count, K))
        for i, each in enumerate(stages):
            for j in range(count):
                left[i, :, j] -= weights[i, j] * each.by_states
                by_motion[i, :, j, :n] = twice[i, j] * each.by_position + weights[i, j] * each.by_velocity
                push[i, :n, j] = weights[i, j] * each.push
        shapes = (count * K, count * K), (count * K, count * size), (count * size, count * K)
        return cls(*(part.reshape(shape) for part, shape in zip((left, by_motion, push), shapes, strict=True)))

    @property
    def added(self) -> Array:
        """The part of the matrix from forces that depend on states, (s size, s size)."""
        return np.asarray(-self.push @ np.linalg.solve(self.left, self.by_motion))

    def pushed(self, left: Array) -> Array:
        """Return the forces (s size,) due to f - before (sK,)."""
        return np.asarray(self.push @ np.linalg.solve(self.left, left))

    def changes(self, left: Array, motion: Array) -> Array:
        """Return δx' (sK,) for f - before (sK,) and δa (s size,)."""
        return np.asarray(np.linalg.solve(self.left, left + self.by_motion @ motion))
