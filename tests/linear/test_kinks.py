"""Forces without a linear part at a pose are refused by name; beside it they are linear."""

from __future__ import annotations

from math import sqrt

import pytest

from mbproj.base.errors import InputError
from tests.linear.closed_forms import HEAD, LAVAL, modes_of


def test_a_force_without_a_slope_is_refused_by_name():
    text = LAVAL.replace("stiffness: 1000, free_length: 0}\n  down", "force: -sqrt(l - 0.3)}\n  down")
    with pytest.raises(InputError, match="force 'up' has no slope at this pose"):
        modes_of(text)


BUFFER = (
    HEAD.replace("-9.81", "0")
    + """\
bodies:
  cart: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0], displacement: AT}
forces:
  spring: {type: linear_spring_damper, joint: rail, stiffness: 50}
  stop: {type: linear_spring_damper, joint: rail, force: FORCE}
"""
)


@pytest.mark.parametrize(
    ("force", "said"),
    [
        ("-300 * max(0, displacement - 0.2)", "has a kink, the slope 0 before and -300 after it,"),
        (
            "-300 * max(0, displacement - 0.2) * exp(displacement_dot)",
            "has a kink, the slope 0 before and -300 after it,",
        ),
        ("-7 * sign(displacement_dot)", "jumps from 7 to -7"),
        ("-7 * abs(displacement - 0.2)", "has a kink, the slope 7 before and -7 after it,"),
        ("-7 * abs(displacement_dot)", "has a kink, the slope 7 before and -7 after it,"),
    ],
)
def test_a_force_with_a_kink_at_the_pose_is_refused_by_name(force, said):
    text = BUFFER.replace("FORCE", f'"{force}"')
    with pytest.raises(InputError, match=f"force 'stop' {said} at this pose: it has no linear part"):
        modes_of(text.replace("AT", "0.2"))
    modes_of(text.replace("AT", "0.2001").replace("_dot", "_dot + 0.01"))  # beside it


@pytest.mark.parametrize(
    ("force", "stiffness"),
    [
        ("-300 * max(0, displacement - 0.2)", 350.0),
        ("-7 * (displacement - 0.3) ** 3", 50.0),
        ("-2 * displacement_dot * abs(displacement_dot)", 50.0),
    ],
)
def test_where_it_is_smooth_it_is_linear(force, stiffness):
    text = BUFFER.replace("AT", "0.3").replace("FORCE", f'"{force}"')
    assert abs(modes_of(text).eigenvalues[0]) == pytest.approx(sqrt(stiffness / 2), rel=1e-9)
