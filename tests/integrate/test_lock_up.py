"""Motions that drive a mechanism to where it has no pose: the run stops there, and names the motion."""

from __future__ import annotations

import re
from itertools import product

import numpy as np
import pytest

from mbproj.base.errors import SimulationError
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene_text
from tests.crossed import crossed, full
from tests.support import Recorder, assembled

#: A crank of 0.2 m at 30 degrees turns up at 2 rad/s, and the rod of 0.15 m reaches the slider's line no more.
SHORT_ROD = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {r: 0.2 m, l: 0.15 m, a: 30 deg, x: r*cos(a) + sqrt(l**2 - (r*sin(a))**2)}
simulation: {duration: 3 s, step: 2 ms}
bodies:
  crank: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [r/2*cos(a), 0, r/2*sin(a)]}
  rod: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [(r*cos(a) + x)/2, 0, r/2*sin(a)]}
  slider: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [x, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, -1, 0]}
  B: {type: spherical, bodies: [crank, rod], location: [r*cos(a), 0, r*sin(a)]}
  C: {type: universal, bodies: [rod, slider], location: [x, 0, 0], axes: [[0, 0, 1], [0, 1, 0]]}
  D: {type: prismatic, bodies: [ground, slider], location: [x, 0, 0], axis: [1, 0, 0]}
motions:
  drive: {joint: A, angle: {constant_speed: 2}}
"""
#: Two bars of 1 m each pull a cart, from 1.8 m away at 1 m/s.
STRETCHED = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {z: sqrt(0.19)}
simulation: {duration: 3 s, step: 2 ms}
bodies:
  a: {mass: 1, inertia: [0.01, 0.1, 0.1], position: [0.45, 0, z/2]}
  b: {mass: 1, inertia: [0.01, 0.1, 0.1], position: [1.35, 0, z/2]}
  cart: {mass: 1, inertia: [0.01, 0.1, 0.1], position: [1.8, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: spherical, bodies: [a, b], location: [0.9, 0, z]}
  C: {type: universal, bodies: [b, cart], location: [1.8, 0, 0], axes: [[0, 0, 1], [0, 1, 0]]}
  D: {type: prismatic, bodies: [ground, cart], location: [1.8, 0, 0], axis: [1, 0, 0]}
motions:
  drive: {joint: D, displacement: {constant_speed: 1}}
"""
#: A bob on two cords of 0.5 m, to the ground and to a cart that is driven away.
CORDS = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 3 s, step: 2 ms}
bodies:
  bob: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.4, 0, -0.3]}
  cart: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.8, 0, 0]}
joints:
  D: {type: prismatic, bodies: [ground, cart], location: [0.8, 0, 0], axis: [1, 0, 0]}
  left: {type: distance, bodies: [ground, bob], locations: [[0, 0, 0], [0.4, 0, -0.3]]}
  right: {type: distance, bodies: [cart, bob], locations: [[0.8, 0, 0], [0.4, 0, -0.3]]}
motions:
  drive: {joint: D, displacement: {constant_speed: 1}}
"""
#: By name: the scene, the driven coordinate, its unit, its value where no pose is left, and how fast it gets there.
LOCKS = {
    "cords taut": (CORDS, "D.displacement", "m", 0.2, 1.0),
    "rod too short": (SHORT_ROD, "A.angle", "rad", float(np.arcsin(0.75) - np.pi / 6), 2.0),
    "bars stretched": (STRETCHED, "D.displacement", "m", 0.2, 1.0),
}
BY_ERROR = {"integrator": "dop853", "step": None, "tolerance": "1e-6", "output_step": "0.1"}
IN_NUMPY = {"formulation": "full", "kinematic": "false"}
RUNS = [
    pytest.param(IN_NUMPY, id="full"),
    pytest.param({"formulation": "auto"}, id="kernel"),
    pytest.param({"formulation": "auto", **BY_ERROR}, id="by error"),
]


def stopped(text: str, **simulation: str | None) -> SimulationError:
    scene = read_scene_text(text, "locked.yaml", {}, {key: value for key, value in simulation.items() if value})
    with pytest.raises(SimulationError) as caught:
        simulate(*assembled(scene), scene.settings, Recorder())
    return caught.value


@crossed("name, simulation", LOCKS, RUNS, dear=[IN_NUMPY])
def test_a_lock_up_is_called_one(name, simulation):
    """It stops, and says how far the motion gets, to 3 %."""
    text, coordinate, unit, limit, speed = LOCKS[name]
    error = stopped(text, **simulation)
    assert error.time == pytest.approx(limit / speed, rel=0.03)
    assert error.where == "motion 'drive'"
    found = re.fullmatch(r".* stay closed: beyond about (\S+) = (\S+) (\S+) there is no pose for it", error.cause)
    assert found is not None, error.cause
    assert (found[1], found[3]) == (coordinate, unit)
    assert float(found[2]) == pytest.approx(limit, rel=0.03)
    assert error.hint == "end the motion or turn back before, or change the lengths"


def test_a_driven_run_that_stops_where_there_is_a_pose_keeps_its_reason():
    """Steps that are far too large for the swinging bob, and a cart that hardly moves."""
    pushed = CORDS.replace("position: [0.4, 0, -0.3]", "position: [0.4, 0, -0.3], velocity: [0, 3, 0]")
    error = stopped(pushed.replace("speed: 1}", "speed: 1e-6}"), projection="none", step="0.3")
    assert error.where != "motion 'drive'"
    assert "stay closed" not in error.cause


BEVELS = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.3, step: 10 ms, integrator: rk4, formulation: full}
bodies:
  a: {mass: 1, inertia: [2e-3, 2e-3, 2e-3], position: [0, 0, 0]}
  b: {mass: 1, inertia: [1e-3, 1e-3, 1e-3], position: [0.2, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 0, 1], speed: 450}
  B: {type: revolute, bodies: [ground, b], location: [0.2, 0, 0], axis: [1, 0, 0]}
  G: {type: gear, joints: [A, B], teeth: [40, 16]}
"""


def test_a_step_too_long_for_teeth_is_no_crossing_of_branches():
    assert "the step is too long to tell its turns, and so which teeth" in str(stopped(BEVELS))


DEAD_CENTRE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, step: 1 ms, integrator: rk4}
bodies:
  crank: {mass: 0, inertia: [0, 0, 0], position: [0.1, 0, 0.1]}
  rod: {mass: 0, inertia: [0, 0, 0], position: [0.5, 0, 0.1]}
  slider: {mass: 1, inertia: [1e-3, 1e-3, 1e-3], position: [0.8, 0, 0], velocity: [0.5, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [crank, rod], location: [0.2, 0, 0.2], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [rod, slider], location: [0.8, 0, 0], axis: [0, 1, 0]}
  D: {type: prismatic, bodies: [ground, slider], location: [0.8, 0, 0], axis: [1, 0, 0]}
"""


#: A nut without mass on a spindle without mass makes three turns until the rod is straight, and the slider stands.
NUT = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5, step: 1 ms, output_step: 50 ms, integrator: rk4}
bodies:
  spindle: {mass: 0, inertia: [0, 0, 0], position: [0, 0, 0]}
  nut: {mass: 0, inertia: [0, 0, 0], position: [-0.3, 0, 0]}
  rod: {mass: 0, inertia: [0, 0, 0], position: [-0.15, 0.2, 0]}
  slider: {mass: 1, inertia: [1e-3, 1e-3, 1e-3], position: [0, 0.4, 0]}
joints:
  A: {type: revolute, bodies: [ground, spindle], location: [0, 0, 0], axis: [1, 0, 0]}
  N: {type: screw, bodies: [spindle, nut], location: [-0.3, 0, 0], axis: [1, 0, 0], pitch: 0.1}
  P: {type: prismatic, bodies: [ground, nut], location: [-0.3, 0, 0], axis: [1, 0, 0]}
  B: {type: revolute, bodies: [nut, rod], location: [-0.3, 0, 0], axis: [0, 0, 1]}
  C: {type: revolute, bodies: [rod, slider], location: [0, 0.4, 0], axis: [0, 0, 1]}
  D: {type: prismatic, bodies: [ground, slider], location: [0, 0.4, 0], axis: [0, 1, 0], speed: 0.5}
"""


@pytest.mark.parametrize(
    ("formulation", "step"),
    [*product(["planar", "reduced"], ["0.1 ms", "1 ms", "10 ms"]), full("full", "1 ms"), ("full", "10 ms")],
)
def test_no_step_passes_over_where_mass_is_lost(formulation, step):
    """The slider arrives with its whole speed where it can go no further: any pose and speed beyond is as good."""
    fast = DEAD_CENTRE.replace("gravity: [0, 0, -9.81]", "gravity: [0, 0, 0]").replace(
        "velocity: [0.5, 0, 0]}", "velocity: [0, 0, 0]}"
    )
    error = stopped(fast.replace("axis: [1, 0, 0]}", "axis: [1, 0, 0], speed: 1}"), formulation=formulation, step=step)
    left = 0.2 * 2**0.5 + (0.6**2 + 0.2**2) ** 0.5 - 0.8
    assert left - 1e-3 < error.time <= left + 0.011
    assert "near here a motion moves no mass" in error.cause


@pytest.mark.parametrize("formulation", ["reduced", full("full")])
def test_a_nut_that_loses_its_mass_is_named(formulation):
    error = stopped(NUT, formulation=formulation)
    assert error.time == pytest.approx(0.2, abs=2e-3)
    assert "near here a motion moves no mass, so that its speed grows beyond all bounds: 'spindle' turns" in error.cause
    assert "'nut' shifts along x" in error.cause


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
def test_what_loses_its_mass_on_the_way_is_said(formulation):
    """At its dead centre the slider stands, and a crank and a rod without mass turn as fast as they like."""
    error = stopped(DEAD_CENTRE, formulation=formulation, step="5 ms" if formulation == "full" else "1 ms")
    assert "near here a motion moves no mass, so that its speed grows beyond all bounds: 'crank' turns" in error.cause
