"""A body without mass and inertia in loops, to which the kernel lends some: against Eq. 14, which needs none."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj import Scene, mobility
from mbproj.equations.constraints import gamma, jacobian
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.of_motion import SOLVERS, generalised_force, mass_matrix
from mbproj.motion.formulations.reduced import space_acceleration
from tests.kernel.scenes import Case, loops, needs_kernel, opened, star

pytestmark = needs_kernel
NOTHING = ((0.0, 0.0, 0.0),) * 3
#: The scene, and a body of it that no joint lets move without moving mass (Eq. 20).
LIGHT = {f"loops {seed}, body {body}": (loops, seed, body) for seed in range(6) for body in (0, 1, 3)}
LIGHT["the hub of a star"] = (star, 0, 0)


def with_nothing(scene: Scene, body: int) -> Scene:
    """The scene with neither mass nor inertia in one of its bodies."""
    bodies = list(scene.bodies)
    bodies[body] = dataclasses.replace(bodies[body], mass=0.0, inertia=NOTHING)
    return dataclasses.replace(scene, bodies=tuple(bodies))


@pytest.fixture(params=LIGHT)
def case(request) -> Case:
    build, seed, body = LIGHT[request.param]
    found = opened(with_nothing(build(seed), body))
    assert not mobility(found.system, pose_of(found.q)).massless
    assert found.reduced.equations().topology["core_bodies"] > 0
    return found


def test_accelerations_and_multipliers_hold_nothing_of_what_was_lent(case):
    """A millionth of the mean mass would show in the sixth digit."""
    system, pose = case.system, pose_of(case.q)
    twist = twist_of(pose, case.v)
    expected, multipliers = SOLVERS["bordered"](
        mass_matrix(system, pose),
        jacobian(system, pose),
        generalised_force(system, pose, twist),
        gamma(system, pose, twist),
    )
    acceleration, own = case.reduced.equations().accelerations(case.y)
    found = space_acceleration(case.y[None], acceleration[None])[0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    joints = multipliers[system.bodies :]
    np.testing.assert_allclose(own, joints, rtol=0, atol=1e-9 * np.abs(joints).max())
