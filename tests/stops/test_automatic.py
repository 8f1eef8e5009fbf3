"""`integrator: auto` in a run of many legs: a choice of the method lasts through impacts, sticking and slipping."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.crossed import crossed
from tests.integrate.stiff_scenes import CLAMP
from tests.stops.runs import run, simulated
from tests.support import ROOT

#: A cart is pushed against a bumper of 1e8 N/m, where it rests until it is pulled away at 1 s. A bob swings beside it.
BUMPER = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 2 s, tolerance: 1.0e-7, integrator: auto, output_step: 0.02}
bodies:
  cart: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  bob: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0.1, 0, 0]}
joints:
  rail:
    type: prismatic
    bodies: [ground, cart]
    location: [0, 0, 0]
    axis: [1, 0, 0]
    limits: {displacement: {range: [null, 0.05], stiffness: 1e8 N/m, damping: 2e4 s/m}}
  wire: {type: prismatic, bodies: [ground, bob], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  push: {type: linear_spring_damper, joint: rail, force: "4*sign(1 - t) - 2*displacement_dot"}
  coil: {type: linear_spring_damper, joint: wire, force: "-100*(displacement + 0.1)"}
"""
#: A block on a belt, held by an arm on a soft spring; between block and arm a bushing of 1e8 N/m.
BELT = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 2 s, tolerance: 1.0e-7, integrator: auto, output_step: 0.02}
bodies:
  belt: {mass: 3, inertia: [0.01, 0.3, 0.3], position: [0, 0, 0]}
  block: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  arm: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  drum: {type: prismatic, bodies: [ground, belt], location: [0, 0, 0], axis: [1, 0, 0]}
  contact: {type: prismatic, bodies: [belt, block], location: [0, 0, 0], axis: [1, 0, 0], speed: 0}
  slide: {type: prismatic, bodies: [ground, arm], location: [0, 0, 0], axis: [1, 0, 0], speed: 0.1}
motions:
  belt: {joint: drum, displacement: 0.1 * t}
forces:
  spring: {type: linear_spring_damper, joint: slide, stiffness: 300}
  bush:
    type: bushing
    bodies: [arm, block]
    location: [0, 0, 0]
    stiffness: {translation: [1e8, 1e8, 1e8], rotation: [1e4, 1e4, 1e4]}
    damping: {translation: [2e4, 2e4, 2e4], rotation: [1, 1, 1]}
  grip: {type: friction, joint: contact, coulomb: {force: 6, static: 9}}
"""
#: The clamp that holds from 0.5 s to 1 s, and the bob beside it bounces on a stop.
BOUNCES = CLAMP.replace(
    "  wire: {type: prismatic, bodies: [ground, bob], location: [0, 0, 0], axis: [1, 0, 0]}",
    "  wire: {type: prismatic, bodies: [ground, bob], location: [0, 0, 0], axis: [1, 0, 0],\n"
    "         limits: {displacement: {range: [-0.11, null], rigid: true, restitution: 0.9}}}",
)
#: A scene, the force that its changes of the method name, and the most steps in which it is done.
STIFF = {
    "bumper": (BUMPER, "force 'rail'", 400),
    "belt": (BELT, "force 'bush'", 450),
    "clamp": (BOUNCES, "force 'clamp'", 450),
}


def by(name, integrator="auto", tolerance="1.0e-7"):
    how = f"tolerance: {tolerance}, integrator: {integrator}"
    return STIFF[name][0].replace("tolerance: 1.0e-7, integrator: auto", how)


def changes(recorded):
    return [event.kind for event in recorded.happened if event.name == "integrator"]


@pytest.mark.parametrize("name", STIFF)
def test_the_implicit_method_goes_on_through_events(name):
    """The exact motion, the same impacts, sticking and slipping, and far fewer steps."""
    _, where, most = STIFF[name]
    report, found = run(by(name, tolerance="1.0e-9" if name == "bumper" else "1.0e-7"))
    alone, exact = run(by(name, "dop853", "1.0e-11"))
    assert np.abs(found["bodies/position"] - exact["bodies/position"]).max() < 2e-6
    assert changes(found)[0].startswith(f"esdirk4 goes on, for {where} (ω h = ")
    assert report.counters["steps"] < most < alone.counters["steps"] / 3.0
    assert report.position_violation.value < 1e-15
    if name == "bumper":
        assert changes(found)[1] == "dop853 goes on"  # it has left the bumper
        return
    events, known = ([event for event in each.happened if event.name != "integrator"] for each in (found, exact))
    assert [event.kind for event in events] == [event.kind for event in known]
    np.testing.assert_allclose([event.time for event in events], [event.time for event in known], atol=1e-5)
    assert changes(found)[1:] == []


@pytest.mark.parametrize("name", ["stick_slip", "drum_brake", "door_closer"])
def test_where_nothing_is_stiff_it_has_the_motion_of_dop853(name):
    """To what the tolerance allows, as trials have no say in the steps."""
    text = (ROOT / "mechanisms" / f"{name}.yaml").read_text()
    assert "integrator: dop853" in text
    _, alone = run(text)
    report, auto = run(text.replace("integrator: dop853", "integrator: auto"))
    assert report.methods[0] in (
        "dop853 throughout: esdirk4 was not quicker",
        "dop853 throughout: no force is stiff",
    )
    told = [[(event.name, event.kind, event.direction) for event in each.happened] for each in (auto, alone)]
    assert told[0] == told[1]
    times = [[event.time for event in each.happened] for each in (auto, alone)]
    np.testing.assert_allclose(*times, rtol=0.0, atol=1e-8)
    for path in ("time", "joints/coordinate", "joints/speed", "bodies/position"):
        np.testing.assert_allclose(auto[path], alone[path], rtol=0.0, atol=1e-7, err_msg=path)


def test_a_bump_stop_is_met_by_either_method():
    """What lies on a stop with a small restitution holds explicit steps up; both tell of the same contacts."""
    text = (ROOT / "mechanisms" / "bump_stop.yaml").read_text().replace("restitution: 0.4", "restitution: 0.1")
    _, alone = run(text)
    _, auto = run(text.replace("integrator: dop853", "integrator: auto"))
    met = [event for event in auto.happened if event.name != "integrator"]
    assert len(changes(auto)) > 0
    assert [event.kind for event in met] == [event.kind for event in alone.happened]
    assert np.abs(auto["bodies/position"] - alone["bodies/position"]).max() < 1e-8


@crossed("until, name", [0.1, 0.17, 0.62, 1.3], STIFF, together=1)
def test_a_run_goes_on_with_the_bits_of_a_longer_one(name, until):
    """Before and after a change of the method, before and after events, and where the end cuts a trial short."""
    whole, _ = simulated(by(name))
    _, kept = simulated(by(name).replace("duration: 2 s", f"duration: {until} s"))
    rest, _ = simulated(by(name), kept[-1])
    after = whole["time"] > kept[-1]["t"]
    for path in whole.blocks[0]:
        np.testing.assert_array_equal(rest[path], whole[path][after], err_msg=path)
    assert rest.happened == whole.happened


@pytest.mark.parametrize("integrator", ["esdirk4", "radau5"])
def test_an_implicit_step_to_an_impact_is_the_one_that_found_it(integrator):
    """The foot of a cabinet that comes to the floor and stays there keeps no gap of what Newton's method leaves."""
    text = (ROOT / "mechanisms" / "rocking_cabinet.yaml").read_text()
    text = re.sub(r"tolerance: \S+", "tolerance: 1.0e-7", text.replace("dop853", integrator))
    report, _ = run(text)
    assert report.position_violation.value < 2e-13
