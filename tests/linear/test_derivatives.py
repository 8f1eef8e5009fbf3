"""Derivatives in tangent coordinates, over the registries: complex steps where they pass, and else central differences
extrapolated to step zero (Romberg), of the equations that runs use."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import set_bias, set_velocity
from mbproj.equations.derivatives import (
    Carried,
    MotionAtTime,
    force_derivative,
    linear_equations,
    second_derivatives,
    tangent_force,
    third_derivatives,
)
from mbproj.equations.kinematics import attached, pose_of, slots_of, twist_of
from mbproj.equations.tangent_space import moved, tangent_velocities, velocities
from mbproj.joints.primitives.coupling import Coupling
from mbproj.joints.primitives.rope import Rope
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.joints.table import JOINTS, thread
from mbproj.model.compile.mechanism import initial_guess
from mbproj.scene.scene import read_scene
from tests.dynamics.force_scenes import BUSHINGS, FORCES, HEAD, ON_BODIES
from tests.support import PARAMETERS, made, random_chain, with_flywheels

DRIVEN = """\
motions:
  m: {joint: R, angle: sin(2*t) + t}
"""
STEP = 1e-100


def romberg(f, levels: int = 6, h: float = 0.08):
    """f'(0) from central differences at h, h/2, .. and their extrapolation."""
    rows = [(f(h / 2**k) - f(-h / 2**k)) / (2 * h / 2**k) for k in range(levels)]
    for order in range(1, levels):
        rows = [(4**order * fine - coarse) / (4**order - 1) for coarse, fine in pairwise(rows)]
    return rows[0]


EACH = {
    **{name: made(kind) for name, kind in PRIMITIVES.items() if kind not in (Coupling, Rope)},
    "rope": Rope((0.0, 0.05, -0.08), (0.3, 1.0), (1.0, 1.0), (-0.05, 0.13)),
    "screw": Coupling(("along", "angle"), *thread(PARAMETERS["pitch"])),
}


def pulled(bound, pose, weight):
    """gᵀw in tangent coordinates, at a pose that may be complex."""
    pull = weight[bound.entry_row, None] * bound.gradient_entries(attached(pose, *slots_of(bound)))
    body, local = bound.body[bound.entry_slot], bound.local[bound.entry_slot]
    in_body = (pull[:, None, :] @ pose.rotation[body])[:, 0, :]
    found = np.zeros((len(pose.position), 6), dtype=pull.dtype)
    np.add.at(found[:, :3], body, bound.is_point[bound.entry_slot, None] * pull)
    np.add.at(found[:, 3:], body, np.cross(local, in_body))
    return found[:-1].ravel()


@pytest.mark.parametrize("name", EACH)
def test_second_and_third_derivatives_of_primitives(name):
    primitive, rng = EACH[name], np.random.default_rng(1)
    x, x_dot = rng.normal(size=(2, 3, len(primitive.slots), 3))
    size = x[0].size
    steps = 1j * STEP * np.eye(size).reshape(size, 1, -1, 3)
    bent = np.moveaxis(primitive.gradient(x + steps).imag / STEP, 0, -1)
    hessian = second_derivatives(primitive, x)
    scale = max(1.0, np.abs(hessian).max())
    np.testing.assert_allclose(hessian, bent.reshape(hessian.shape), atol=2e-14 * scale)
    found = third_derivatives(primitive, x, x_dot)

    def along(h):
        bend = second_derivatives(primitive, x + h * x_dot)
        return (bend @ x_dot.reshape(3, 1, -1, 1))[..., 0]

    np.testing.assert_allclose(found, romberg(along, h=0.01), atol=1e-9 * max(1.0, np.abs(found).max()))


@pytest.mark.parametrize("kind", JOINTS)
def test_the_geometric_stiffness_is_the_derivative_of_the_constraint_forces(kind):
    scene = random_chain(3, ["revolute", kind, "spherical"])
    system = compile_system(scene)
    q = initial_guess(scene, system).q
    pose, rng = pose_of(q), np.random.default_rng(2)
    weight = rng.normal(size=system.joints.size)
    still = twist_of(pose, np.zeros_like(q))
    found = force_derivative(system.joints, Carried.along(pose, still, still), weight).dense()
    expected = np.empty_like(found)
    for column, ξ in enumerate(np.eye(6 * system.bodies)):
        there = pose_of(q + 1j * STEP * velocities(pose, ξ))
        expected[:, column] = pulled(system.joints, there, weight).imag / STEP
    np.testing.assert_allclose(found, expected, atol=1e-13 * max(1.0, np.abs(expected).max()))


def forces_everywhere(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(HEAD + FORCES + BUSHINGS + ON_BODIES + DRIVEN)
    return with_flywheels(read_scene(path))


def random_motion(system, scene, t=0.7, seed=4):
    """At a time and pose with any velocities and accelerations: the equations hold there whether constraints do."""
    guess, rng = initial_guess(scene, system), np.random.default_rng(seed)
    q = moved(guess.q, 0.1 * rng.normal(size=6 * system.bodies))
    u, change = rng.normal(size=(2, 6 * system.bodies))
    return MotionAtTime(t, q, u, change, coordinate_values(system, pose_of(q)))


def varied(motion, variation, h):
    """The motion after h times a variation (ξ, ξ', ξ''), with δω = ξθ' + ω × ξθ and δω' = δω's derivative in time."""
    bodies = len(motion.u) // 6
    (ω, ω_dot), (turn, turn_dot) = (
        tuple(x.reshape(bodies, 6)[:, 3:] for x in pair) for pair in ((motion.u, motion.change), variation[:2])
    )
    u, change = (x.reshape(bodies, 6).copy() for x in (motion.u + h * variation[1], motion.change + h * variation[2]))
    u[:, 3:] += h * np.cross(ω, turn)
    change[:, 3:] += h * (np.cross(ω_dot, turn) + np.cross(ω, turn_dot))
    return MotionAtTime(motion.t, moved(motion.q, h * variation[0]), u.ravel(), change.ravel(), motion.expected)


def test_the_linear_equations_are_the_derivative_of_the_equations_of_motion(tmp_path):
    """With every kind of force, reflected inertias, motions, spin and accelerations."""
    scene = forces_everywhere(tmp_path)
    system = compile_system(scene)
    motion, rng = random_motion(system, scene), np.random.default_rng(5)
    multipliers = rng.normal(size=system.constraints - system.bodies)
    found = linear_equations(system, motion, multipliers)
    M, D, K = (part.dense() for part in (found.M, found.D, found.K))
    for _ in range(6):
        variation = rng.normal(size=(3, len(motion.u)))

        def residual(h, variation=variation):
            there = varied(motion, variation, h)
            return pulled(system.rows, there.pose, multipliers) - tangent_force(system, there)

        expected = romberg(residual)
        change = K @ variation[0] + D @ variation[1] + M @ variation[2]
        np.testing.assert_allclose(change, expected, atol=2e-10 * np.abs(expected).max())


@pytest.mark.parametrize("kind", JOINTS)
def test_rows_along_a_motion_are_the_derivatives_of_the_constraints(kind):
    """δC = Gξ, δC' = Gξ' + G'ξ and δC'' = Gξ'' + 2G'ξ' + G''ξ."""
    scene = random_chain(8, ["revolute", kind, "universal"])
    system = compile_system(scene)
    motion, rng = random_motion(system, scene), np.random.default_rng(8)
    rows = linear_equations(system, motion, np.zeros(system.joints.size)).rows
    G, G_dot, G_ddot = (part.dense() for part in (rows.G, rows.G_dot, rows.G_ddot))
    ξ, ξ_dot, ξ_ddot = variation = rng.normal(size=(3, len(motion.u)))

    def constraints(h):
        there = varied(motion, variation, h)
        pose = there.pose
        twist, change = there.twist(pose), there.change_of(pose)
        value = system.joints.value(attached(pose, *slots_of(system.joints)))
        rate = set_velocity(system.joints, pose, twist)
        return np.array([value, rate, set_velocity(system.joints, pose, change) + set_bias(system.joints, pose, twist)])

    level = ~system.joints.is_velocity  # slip is that of no function: see tests/rolling/test_modes.py
    expected = romberg(constraints, h=0.02)[:, level]
    found = np.array([G @ ξ, G @ ξ_dot + G_dot @ ξ, G @ ξ_ddot + 2.0 * G_dot @ ξ_dot + G_ddot @ ξ])[:, level]
    np.testing.assert_allclose(found, expected, atol=1e-9 * max(1.0, np.abs(expected).max()))


def test_velocities_in_tangent_coordinates_and_back():
    scene = random_chain(1, ["spherical", "revolute"])
    system = compile_system(scene)
    pose, u = pose_of(initial_guess(scene, system).q), np.random.default_rng(3).normal(size=12)
    np.testing.assert_allclose(tangent_velocities(pose, velocities(pose, u)), u, rtol=1e-14)
