"""Why an error cannot be kept: chaos, round-off, too many kinks, a reference that does not converge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj.scene.scene import read_scene_text
from mbproj.studies.measure.reference import Reference, not_smooth, uneven, why_not
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Mechanism, solve
from mbproj.studies.recommend import recommend

PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2, step: 0.01}
bodies: {bar: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}}
joints: {pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}}
markers: {end: {body: bar, location: [1, 0, 0]}}
"""
DOUBLE_PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 20, step: 0.01}
bodies:
  bar: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
  tip: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
  knee: {type: revolute, bodies: [bar, tip], location: [1, 0, 0], axis: [0, 1, 0]}
markers: {end: {body: tip, location: [2, 0, 0]}}
"""
DOOR = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 3, step: 1 ms}
bodies: {door: {mass: 20, inertia: [2, 2, 1.5], position: [0.4, 0, 0]}}
joints: {hinge: {type: revolute, bodies: [ground, door], location: [0, 0, 0], axis: [0, 0, 1], speed: 1 rad/s}}
markers: {handle: {body: door, location: [0.8, 0, 0]}}
forces:
  stop: {type: torsion_spring_damper, joint: hinge, torque: "-5000*max(0, angle - 0.5) - 0.2*sign(angle)"}
"""


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory, monkeypatch):
    monkeypatch.setenv("MBPROJ_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))


def uncertain(text: str, by: float, end: float, limit: str = "") -> tuple[Mechanism, Reference]:
    """A mechanism, and a reference that is uncertain by so much (m) after the start."""
    ready = Mechanism.of(read_scene_text(text, "scene.yaml"))
    times = np.linspace(0.0, end, 41)
    found = solve(ready, Setting(integrator="dop853", tolerance=1e-12), times)
    uncertainty = np.full(found.position.shape[:2], by)
    uncertainty[0] = 0.0
    return ready, Reference(ready.points, times, found.position, found.velocity, uncertainty, "", "", limit)


def test_round_off_is_named_only_where_it_explains_the_error():
    ready, reference = uncertain(PENDULUM, 1e-14, 1.0)
    assert why_not(ready, reference, 1e-15, 1.0).startswith("errors grow from round-off: starts that differ by it are ")
    assert why_not(ready, replace(reference, uncertainty=1e-4 * np.ones((41, 1))), 1e-6, 1.0) == (
        "the reference does not converge: the best solutions are uncertain by 0.0001 m at 1 s; a load that is "
        "shorter than a step may be the reason"
    )


def test_a_law_with_too_many_kinks_is_named_and_one_with_edges_is_not():
    """Steps end at the edges of a door's stop, wherever these are: they are no reason."""
    door, _ = uncertain(DOOR, 1e-5, 0.3)
    assert uneven(door, 0.3) == ()
    rattle = PENDULUM + "forces: {push: {type: torsion_spring_damper, joint: pin, torque: '1e-9*abs(sin(9000*t))'}}\n"
    ready, reference = uncertain(rattle, 1e-5, 1.0)
    said = "force 'push' has more kinks in time than steps end at"
    assert not_smooth(uneven(ready, 1.0)) == said
    assert why_not(ready, reference, 1e-7, 1.0) == f"{said}, and the best solutions are uncertain by 1e-05 m at 1 s"
    known = replace(reference, uncertainty=9e-8 * np.ones((41, 1)))
    assert why_not(ready, known, 1e-7, 1.0) == f"{said}, and no setting is that accurate"


def test_a_reference_that_ended_says_why():
    ready, reference = uncertain(PENDULUM, np.inf, 1.0, "dopri5 stopped at 0.3 s")
    assert why_not(ready, reference, 1e-6, 1.0) == "dopri5 stopped at 0.3 s"


def test_chaos_is_named():
    """A double pendulum that tumbles: starts part with a rate of some 1/s."""
    ready, reference = uncertain(DOUBLE_PENDULUM, 1e-3, 20.0)
    why = why_not(ready, reference, 1e-9, 20.0)
    assert why.startswith("the motion is chaotic: starts that differ by round-off part as exp(")


@pytest.mark.full
def test_a_door_with_a_stop_gets_its_recommendation():
    """Its error holds against DOP853 at a tolerance of 1e-13, whose steps end at the stop."""
    ready = Mechanism.of(read_scene_text(DOOR, "door.yaml"))
    found = recommend(ready.scene, 1e-6, until=3.0, timed=False)
    assert found.reached
    times = np.linspace(0.0, 3.0, 31)
    better = solve(ready, Setting(integrator="dop853", tolerance=1e-13), times)
    chosen = solve(ready, found.setting, times)
    assert np.linalg.norm(chosen.position - better.position, axis=2).max() <= 1e-6 + found.uncertain
