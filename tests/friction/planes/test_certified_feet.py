"""A certificate of feet that share a load: its error covers the slack with which they slip, and the shares."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from mbproj import Mechanism, read_scene_text, settings_to_run, simulate_certified
from mbproj.cli.report.trust import lines_on
from tests.crossed import full
from tests.friction.closed_forms import Belt
from tests.friction.planes.scenes import CORNERS, IN_PLANE, box
from tests.kernel.scenes import needs_kernel
from tests.support import Recorder

pytestmark = needs_kernel
GRAVITY = 10.0
ON_A_BELT = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: {duration}, integrator: dop853, tolerance: 1e-11, output_step: 0.02}}
bodies:
  belt: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
  block: {{mass: {m}, inertia: [0.02, 0.04, 0.03], position: [0, 0, 0.1], velocity: [{v}, 0, 0]}}
joints:
  drive: {{type: prismatic, bodies: [ground, belt], location: [0, 0, 0], axis: x}}
  {joint}
motions:
  running: {{joint: drive, displacement: {v}*t}}
forces:
{feet}
  spring: {{type: spring_damper, points: {{ground: [-2, 0, 0.1], block: [0, 0, 0.1]}}, stiffness: {k}, free_length: 2}}
"""
ON_THE_BELT = """  {name}:
    type: stop
    plane: {{body: belt, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: block, location: [{x}, {y}, 0]}}
    rigid: true
    friction: {{coefficient: {sliding}, static: {static}}}
"""
BESIDE = "P: {type: planar, bodies: [ground, block], location: [0, 0, 0], axis: y}"
IN_LINE = {"a": (0.25, 0.0), "b": (-0.3, 0.0)}
#: Places of feet, a joint, and the numbers of the belt with its coefficients of friction.
BELTS = (
    (IN_LINE, BESIDE, Belt(m=2.0, k=30.0, v=0.25, sliding=4.0, static=6.0)),
    ({**IN_LINE, "c": (0.1, 0.0)}, BESIDE, Belt(m=1.0, k=10.0, v=0.2, sliding=2.0, static=3.0)),
    ({"a": (0.3, 0.2), "b": (-0.3, 0.2), "c": (-0.3, -0.2), "d": (0.3, -0.2)}, "", Belt(1.5, 20.0, 0.3, 2.0, 4.0)),
)


class Kept(Recorder):
    """A recorder of blocks and of the certificate."""

    def trust(self, trust):
        self.certificate = trust


def certified(text, limits=(1e-12, 1e-9, 1e-6, 1e-3)):
    """The paths of the bodies, and the certificate."""
    scene, recorder = read_scene_text(text), Kept()
    _, trust = simulate_certified(Mechanism.of(scene), settings_to_run(scene), recorder, limits=limits)
    return recorder, trust


@pytest.mark.parametrize(("places", "joint", "belt"), [BELTS[0], *(full(*each) for each in BELTS[1:])])
def test_the_slack_with_which_feet_slip_is_part_of_the_error(places, joint, belt):
    """They slip some 2e-9 of their time early, for the slack of shared friction. The certificate said 1e-12 m."""
    load = belt.m * GRAVITY
    friction = {"sliding": belt.sliding / load, "static": belt.static / load}
    feet = "".join(ON_THE_BELT.format(name=name, x=x, y=y, **friction) for name, (x, y) in places.items())
    duration = 0.02 * round(50.0 * (belt.first_slip + 1.7 * belt.period))
    recorded, trust = certified(
        ON_A_BELT.format(feet=feet, joint=joint, m=belt.m, k=belt.k, v=belt.v, duration=duration)
    )
    times, path = recorded["time"], recorded["bodies/position"][:, 1, 0]
    exact = np.where(times < belt.first_slip, belt.v * times, belt(times))
    off, block = np.abs(path - exact), trust.names.index("block")
    assert 1e-10 < off.max() < 1e-7
    assert np.all(off <= trust.error[:, block] + trust.uncertainty[:, block] + 1e-15)
    assert trust.uncertainty[:, block].max() < 30.0 * off.max()
    assert trust.horizon_low[block, 1] < inf


@pytest.mark.parametrize(("places", "joint"), [({"a": (0.3, 0.0), "b": (-0.35, 0.0)}, IN_PLANE), (CORNERS, "")])
def test_feet_that_a_growing_force_tears_loose_have_their_slack_in_the_error(places, joint):
    """They hold up to 0.3 m g, and slide with 0.2 m g: from then on m x'' = p t - 0.2 m g."""
    push, mass, duration = 25.0, 3.0, 0.7
    recorded, trust = certified(
        box(places, "{coefficient: 0.2, static: 0.3}", push=push, height=0.05, joint=joint, duration=duration)
    )
    t, slips = recorded["time"], 0.3 * mass * GRAVITY / push
    after = np.maximum(t - slips, 0.0)
    path = (
        push * (t**3 - slips**3) / 6.0 / mass
        - push * slips**2 / 2.0 / mass * after
        - 0.1 * GRAVITY * 2.0 * after**2 / 2.0
    )
    off = np.abs(recorded["bodies/position"][:, 0, 0] - np.where(t < slips, 0.0, path))
    assert off.max() > 1e-11
    assert np.all(off <= trust.error[:, 0] + trust.uncertainty[:, 0] + 1e-15)
    assert trust.uncertainty.max() < 100.0 * off.max()


def path_of_the_box(places, share, velocity, spin, friction, duration, steps=400):
    """Where a box that slides and turns on feet comes, (2,), by RK4. Of the loads that balance it, its feet have one at
    the part `share` of the way from the one to the other edge of those in which no foot pulls."""
    own, mass, moment, height = np.array(list(places.values())), 3.0, 0.12, 0.25

    def loads(direction, arms):
        balance = np.stack(
            [np.ones(len(arms)), arms[:, 1] + height * direction[:, 1], arms[:, 0] + height * direction[:, 0]]
        )
        least = np.linalg.lstsq(balance, [mass * GRAVITY, 0.0, 0.0], rcond=None)[0]
        open_ = np.linalg.svd(balance)[2][-1]
        open_ *= np.sign(open_[0])
        low, high = (-least[open_ > 0.0] / open_[open_ > 0.0]).max(), (-least[open_ < 0.0] / open_[open_ < 0.0]).min()
        return least + (low + share * (high - low)) * open_

    def rate(y):
        c, s = np.cos(y[2]), np.sin(y[2])
        arms = own @ np.array([[c, s], [-s, c]])
        slides = y[3:5] + y[5] * np.stack([-arms[:, 1], arms[:, 0]], axis=1)
        direction = -friction * slides / np.linalg.norm(slides, axis=1)[:, None]
        force = loads(direction, arms)[:, None] * direction
        turning = np.sum(arms[:, 0] * force[:, 1] - arms[:, 1] * force[:, 0]) / moment
        return np.concatenate([y[3:], force.sum(axis=0) / mass, [turning]])

    y, h = np.array([0.0, 0.0, 0.0, *velocity, spin]), duration / steps
    for _ in range(steps):
        k1 = rate(y)
        k2 = rate(y + 0.5 * h * k1)
        k3 = rate(y + 0.5 * h * k2)
        y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(y + h * k3))
    return y[:2]


@pytest.mark.parametrize(
    ("places", "velocity", "spin", "friction"),
    [
        (CORNERS, (1.0, 0.0), 5.0, 0.25),
        full({"a": (0.3, 0.2), "b": (-0.2, 0.3), "c": (-0.4, -0.2), "d": (0.35, -0.25)}, (0.5, 0.7), 3.0, 0.4),
    ],
)
def test_where_the_motion_depends_on_shares_the_error_is_that_of_any_share(places, velocity, spin, friction):
    """It gave no figure. The largest distance is that to one of the two shares that relieve a foot of all its load."""
    duration = 0.2
    recorded, trust = certified(
        box(places, friction, velocity=(*velocity, 0.0), spin=(0.0, 0.0, spin), duration=duration)
    )
    here = recorded["bodies/position"][-1, 0, :2]
    apart = [
        np.linalg.norm(path_of_the_box(places, share, velocity, spin, friction, duration) - here)
        for share in (0.0, 0.3, 0.7, 1.0)
    ]
    assert trust.uncertainty[-1, 0] == pytest.approx(max(apart), rel=1e-3)
    assert max(apart) > 1e-3
    assert "how these share their load, stop 'a'" in trust.remark
    assert trust.untrusted_from(1e-3) is not None
    assert any("lower under one of them" in line for line in lines_on(trust))


def test_shares_have_no_say_where_a_box_slides_straight_on():
    _, trust = certified(box(CORNERS, 0.25, velocity=(1, 0, 0), duration=0.1))
    assert trust.solution and trust.untrusted_from(1e-9) is None
    assert "share" not in trust.remark
