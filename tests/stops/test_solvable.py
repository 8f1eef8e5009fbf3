"""Starts and releases that can be decided, though nothing but the forces of other contacts decides them."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import mbproj
from mbproj.base.errors import MbprojWarning
from mbproj.base.settings import Settings
from mbproj.results.analysis.contacts import pulls_in_words, pulls_of_stops
from tests.kernel.scenes import needs_kernel

# Compliant stops without a gap at rest, beside a rigid one whose force opens some of them.

#: A plank on a rigid foot, with soft feet to both sides at the same height.
PLANK = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.4, output_step: 10 ms, integrator: dop853, tolerance: 1e-11}
bodies: {plank: {mass: 4, inertia: [0.2, 0.2, 0.2], position: [AWAY, 0, 0.15]}}
joints: {plane: {type: planar, bodies: [ground, plank], location: [AWAY, 0, 0.15], axis: y}}
forces:
  foot: {type: stop, plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]},
         point: {body: plank, location: [0, 0, 0]}, rigid: true}
FEET
"""
SOFT = (
    "  soft{0}: {{type: stop, plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}, "
    "point: {{body: plank, location: [{1}, 0, 0]}}, stiffness: 6000}}\n"
)


def plank(away, feet):
    text = PLANK.replace("AWAY", str(away)).replace("FEET", "".join(SOFT.format(k, a) for k, a in enumerate(feet)))
    return mbproj.run(mbproj.read_scene_text(text))


@needs_kernel
@pytest.mark.parametrize("away", [0.06, -0.06])
@pytest.mark.parametrize("feet", [(-0.25, 0.25), (-0.4, -0.25, 0.25, 0.4)])
def test_soft_feet_beside_a_rigid_one_open_where_its_force_opens_them(away, feet):
    """Against SciPy. The foot slides without friction, so that the centre of mass keeps its x and has the height
    z = h cos θ - a sin θ: (J + m z'²) θ'' + m z' z'' θ'² = -m g z' - Σ k b² sin θ cos θ of the feet that press."""
    mass, height, inertia = 4.0, 0.15, 0.2

    def turns(_, state):
        θ, rate = state
        z_1, z_2 = -height * np.sin(θ) - 0.06 * np.cos(θ), -height * np.cos(θ) + 0.06 * np.sin(θ)
        press = sum(6000.0 * b * b * np.sin(θ) * np.cos(θ) for b in feet if b > 0)
        return [rate, (-mass * z_1 * (9.81 + z_2 * rate**2) - press) / (inertia + mass * z_1**2)]

    results = plank(away, feet)
    exact = solve_ivp(turns, (0, 0.4), [0, 0], t_eval=results.time, rtol=1e-12, atol=1e-14, method="DOP853").y[0]
    assert exact.max() > 1e-3
    z = -0.06 * np.sin(exact) + height * np.cos(exact)
    assert results["bodies/position"][:, 0, 2] == pytest.approx(z, abs=2e-10)
    assert {event.name for event in results.events if event.kind == "contact"} == {
        "stop 'foot'",
        *(f"stop 'soft{k}'" for k, a in enumerate(feet) if a * away > 0),
    }


# A follower that grazes its cam: its force passes 0 for a moment within a long step.

#: Its motion while it touches: s = L (u - sin 2πu / 2π), u = φ/β, on the rise.
CAM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.14 s, output_step: 1 ms, tolerance: 1e-8}
curves:
  law:
    lift:
      base: 40 mm
      rises: [[60 deg, 0 mm, dwell], [90 deg, 20 mm, cycloidal], [90 deg, 20 mm, dwell], [90 deg, 0 mm, cycloidal],
              [30 deg, 0 mm, dwell]]
    roller: 8 mm
    clockwise: true
bodies:
  cam: {mass: 3, inertia: [1e-2, 1e-2, 1e-2], position: [0, 0, 0]}
  pusher: {mass: 1.5, inertia: [2e-3, 2e-3, 1e-3], position: [0, 0, 0.12]}
joints:
  bearing: {type: revolute, bodies: [ground, cam], location: [0, 0, 0], axis: [0, -1, 0]}
  guide: {type: prismatic, bodies: [ground, pusher], location: [0, 0, 0.12], axis: [0, 0, 1]}
  contact: {type: cam_contact, bodies: [cam, pusher], curve: law, axis: [0, -1, 0], x_axis: [0, 0, 1],
            locations: [[0, 0, 0], [0, 0, 48 mm]], limits: {gap: {range: [0, null], rigid: true}}}
forces: {spring: {type: linear_spring_damper, joint: guide, stiffness: 3 N/mm, free_displacement: -50 N/(3 N/mm)}}
motions: {drive: {joint: bearing, angle: {constant_speed: SPEED}}}
"""


def force_on_rise(u, speed):
    """The force of the cam at the part u of the rise, N."""
    lift, rate = 0.02, speed / (np.pi / 2)
    s = lift * (u - np.sin(2 * np.pi * u) / (2 * np.pi))
    return 1.5 * (2 * np.pi * lift * np.sin(2 * np.pi * u) * rate**2 + 9.81) + 3000 * s + 50.0


#: The speed at which the least force is zero, and one at which the follower leaves the cam for a moment, rad/s.
GRAZES = brentq(lambda speed: min(force_on_rise(u, speed) for u in np.linspace(0.5, 1, 20001)), 30, 60)
LEAVES = 1.002 * GRAZES


@needs_kernel
@pytest.mark.parametrize(
    "options",
    [
        {"integrator": "dop853", "tolerance": 1e-9},
        {"integrator": "dop853", "tolerance": 1e-6},
        {"integrator": "dop853", "tolerance": 1e-6, "output_step": 0.07},
        {"integrator": "dopri5", "tolerance": 1e-5},
        {"integrator": "auto", "tolerance": 1e-7},
        {"integrator": "radau5", "tolerance": 1e-9},
        {"integrator": "rk4", "step": 2e-4},
    ],
    ids=str,
)
def test_a_follower_leaves_where_its_force_would_pull(options):
    """The release is the zero of the force, whatever the steps; and no sample has a pull."""
    scene = mbproj.read_scene_text(CAM.replace("SPEED", repr(LEAVES)))
    results = mbproj.run(scene, **options)
    u = brentq(force_on_rise, 0.5, 0.75, args=(LEAVES,), xtol=1e-15)
    leaves = (np.pi / 3 + u * np.pi / 2) / LEAVES
    released = [event.time for event in results.events if event.kind == "release"]
    assert released[0] == pytest.approx(leaves, abs=2e-7)
    assert results["stops/force"].min() >= -1e-7
    assert results["stops/gap"].min() >= -1e-12


@needs_kernel
@pytest.mark.parametrize("integrator", ["dop853", "dopri5"])
def test_no_tolerance_and_no_samples_hide_a_release(integrator):
    """Looks at a cubic inside a long step are off by more than the pull; a step to near there is not."""
    released = [
        (part, tolerance, samples)
        for part in (1.0003, 1.001, 1.005)
        for tolerance in 10.0 ** np.arange(-9, -3.9, 0.5)
        for samples in (1e-3, 0.07)
        for results in [leaving(part, integrator=integrator, tolerance=float(tolerance), output_step=samples)]
        if len([event for event in results.events if event.kind == "release"]) != 2
    ]
    assert released == []


def leaving(part, **options):
    """A run at this part of the speed at which the follower grazes; its warnings of drift are none of ours."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MbprojWarning)
        return mbproj.run(mbproj.read_scene_text(CAM.replace("SPEED", repr(part * GRAZES))), **options)


@needs_kernel
def test_a_follower_that_only_grazes_stays():
    scene = mbproj.read_scene_text(CAM.replace("SPEED", repr(0.999 * GRAZES)))
    results = mbproj.run(scene, integrator="dop853", tolerance=1e-6)
    assert [event.kind for event in results.events if event.kind == "release"] == []
    assert results["stops/gap"].max() < 1e-12


class Samples(dict[str, np.ndarray]):
    """Two seconds of one stop, whose largest force is 100 N, in steps of a tolerance."""

    time, settings = np.linspace(0, 2, 101), Settings(tolerance=1e-3)

    def names(self, kind):
        return ("low",)


@pytest.mark.parametrize(("force", "told"), [(-0.05, None), (-0.5, "pulls with up to 0.5 N or N m, at 1.14 s")])
def test_a_pull_that_no_step_has_found_is_said(force, told):
    """The samples tell of it. What is within the tolerance is none."""
    forces = np.linspace(100, 1, 101)[:, None]
    forces[57] = force
    pulls = pulls_of_stops(Samples({"stops/force": forces}))
    assert [pulls_in_words(*pull) for pull in pulls.items()] == (
        [] if told is None else [f"stop 'low' {told}: it should have opened there; take a smaller tolerance or step"]
    )


# A start whose speeds the scene leaves open: they are chosen so that nothing moves into what it touches.

YOKE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.2, tolerance: 1e-10, integrator: dop853}
bodies:
  crank: {mass: 1, inertia: [0.03, 0.03, 0.03], position: [0, 0, 0]}
  block: {mass: 3, inertia: [0.04, 0.04, 0.04], position: [X, 0, 0], VELOCITY}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, -1, 0], speed: 8}
  slot: {type: point_on_line, bodies: [block, crank], location: [X, 0, Z], axis: z}
  plane: {type: planar, bodies: [ground, block], location: [X, 0, 0], axis: y, x_axis: x}
forces:
  f0: {type: stop, plane: {body: ground, location: [0, 0, -0.04], normal: [0, 0, 1]},
       point: {body: block, location: {block: [-0.2, 0, -0.04]}}, rigid: true}
  f1: {type: stop, plane: {body: ground, location: [0, 0, -0.04], normal: [0, 0, 1]},
       point: {body: block, location: {block: [0.2, 0, -0.04]}}, rigid: true}
"""


def yoke(angle, velocity=""):
    x, z = 0.15 * np.cos(angle), 0.15 * np.sin(angle)
    text = YOKE.replace("X", repr(float(x))).replace("Z", repr(float(z))).replace(", VELOCITY", velocity)
    return mbproj.read_scene_text(text)


@pytest.mark.parametrize("angle", [2e-5, 1e-3, 0.4, 1.2, -0.7])
def test_a_start_does_not_move_into_what_it_touches(angle):
    """The speed of the crank is as asked; the rest is open, and no foot goes down."""
    results = mbproj.run(yoke(angle))
    assert results["stops/rate"][0].min() >= -1e-13
    assert results["joints/speed"][0, 0] == pytest.approx(8, rel=1e-11)
    assert results["diagnostics/velocity_violation"][0] < 1e-12


def test_a_speed_into_a_stop_that_the_scene_asks_for_is_refused():
    with pytest.raises(mbproj.InputError, match=r"touches the stop 'f0' and moves into it at "):
        mbproj.run(yoke(0.4, ", velocity: [0, 0, -0.1]"))
