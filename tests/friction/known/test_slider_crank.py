"""A slider-crank whose guide resists by the force across it, which friction itself changes: against the equations of
its bodies, integrated by SciPy."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError
from tests.friction.known import slider_crank as exact
from tests.friction.known.mechanisms import STEPS
from tests.stops.runs import run

START = 1.0
ψ = exact.rod(START, 0.0, 0.0)[0]
PIN = exact.R * np.array([np.cos(START), np.sin(START)])
END = exact.slider(START, 0.0)[0]
CENTRE = 0.5 * (PIN + np.array([END, 0.0]))
#: A ball and a universal joint hold the rod in the plane, so that no row is redundant.
PINS = f"""
  B: {{type: spherical, bodies: [crank, rod], location: [{PIN[0]}, {PIN[1]}, 0]}}
  C:
    type: universal
    bodies: [rod, slider]
    location: [{END}, 0, 0]
    axes: [[{-np.sin(ψ)}, {np.cos(ψ)}, 0], [0, 0, 1]]
"""
TEXT = f"""
mbproj: 1
gravity: [0, {-exact.G}, 0]
simulation: {{{{duration: {{duration}}, {{steps}}, formulation: {{formulation}}}}}}
bodies:
  crank: {{{{mass: 1, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0]}}}}
  rod:
    mass: {exact.MASS["rod"]}
    inertia: [6.0e-3, 6.0e-3, 6.0e-3]
    position: [{CENTRE[0]}, {CENTRE[1]}, 0]
  slider: {{{{mass: {exact.MASS["slider"]}, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [{END}, 0, 0]}}}}
joints:
  A: {{{{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1], speed: {{rate}}}}}}
  D: {{{{type: prismatic, bodies: [ground, slider], location: [{END}, 0, 0], axis: [1, 0, 0]}}}}
{{pins}}
forces:
  guide: {{{{type: friction, joint: D, coulomb: {{{{coefficient: {{μ}}, static: {{static}}}}}}}}}}
"""


def linkage(rate, μ, static, duration, formulation, steps="dop853"):
    pins = PINS.strip("\n")
    return TEXT.format(
        rate=rate, μ=μ, static=static, duration=duration, formulation=formulation, pins=pins, steps=STEPS[steps]
    )


@pytest.mark.parametrize("rate", [12.0, -12.0])
def test_the_equations_of_the_bodies_keep_their_energy(rate):
    """What SciPy integrates loses what friction takes, by energies that it does not know."""
    motion = exact.Motion(START, rate, 0.3, 0.4, 0.5)
    φ, speed, lost = motion(0.5)
    assert exact.energy(START, rate) - exact.energy(φ, speed) == pytest.approx(lost, abs=1e-9)
    assert lost > 0.3


@pytest.mark.parametrize(("formulation", "rate"), [("reduced", 12.0), ("reduced", -12.0), ("full", -12.0)])
def test_it_turns_as_the_equations_of_its_bodies_have_it(formulation, rate):
    """Through two reversals of the slider, at its dead centres, where the crank goes on."""
    duration = 0.08 if formulation == "full" else 0.5
    motion = exact.Motion(START, rate, 0.3, 0.4, duration)
    assert len(motion.times) == (1 if formulation == "full" else 2)
    _, recorded = run(linkage(rate, 0.3, 0.4, duration, formulation))
    found = np.array([motion(t) for t in recorded["time"]])
    assert recorded["joints/coordinate"][:, 0] == pytest.approx(found[:, 0] - START, abs=1e-8)
    assert recorded["joints/speed"][:, 0] == pytest.approx(found[:, 1], abs=1e-7)
    assert recorded["friction/dissipation"][:, 0] == pytest.approx(found[:, 2], abs=1e-7)
    assert recorded["joints/violation"].max() < 2e-13
    assert recorded.unbalanced < 1e-7


def test_it_comes_to_rest_between_its_dead_centres_and_stays():
    motion = exact.Motion(START, 6.0, 0.3, 0.6, 1.3)
    assert motion.rests < 1.1
    _, recorded = run(linkage(6.0, 0.3, 0.6, 1.3, "reduced"))
    last = recorded.of("stick")[-1]
    assert last.time == pytest.approx(motion.rests, abs=1e-8)
    assert recorded["joints/speed"][-1] == pytest.approx(0.0, abs=1e-11)
    assert recorded["joints/coordinate"][-1, 0] == pytest.approx(motion(1.3)[0] - START, abs=1e-8)


#: Four joints that each hold the plane: what they carry across it is not unique.
REDUNDANT = f"""
  B: {{type: revolute, bodies: [crank, rod], location: [{PIN[0]}, {PIN[1]}, 0], axis: [0, 0, 1]}}
  C: {{type: revolute, bodies: [rod, slider], location: [{END}, 0, 0], axis: [0, 0, 1]}}
"""


def test_friction_by_what_redundant_joints_share_is_refused_and_a_constant_one_is_not():
    text = linkage(12.0, 0.3, 0.4, 0.02, "reduced").replace(PINS.strip("\n"), REDUNDANT.strip("\n"))
    with pytest.raises(InputError, match=r"'guide' goes by what joint 'D' carries, which is not unique.*'A', 'B', 'C'"):
        run(text)
    _, recorded = run(text.replace("coefficient: 0.3, static: 0.4", "force: 3"))
    slid = exact.slider(START, 0.0)[0] - exact.slider(START + recorded["joints/coordinate"][-1, 0], 0.0)[0]
    assert recorded["friction/dissipation"][-1, 0] == pytest.approx(3.0 * slid, rel=1e-8)
