"""Sliders on guides and a slider-crank's guide: friction by the force across and by moments, and Painlevé's paradox."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, SimulationError
from tests.crossed import full
from tests.friction import closed_forms as exact
from tests.friction import slider_crank as crank
from tests.friction.mechanisms import FORMULATIONS, STEPS, rotor
from tests.stops.runs import run

#: A slider of 2 kg on a guide along x, `centre` beside it, pushed along x at a point `at` beside it.
GUIDE = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  slider: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, {centre}, 0]}}
joints:
  guide: {{type: prismatic, bodies: [ground, slider], location: [0, 0, 0], axis: [1, 0, 0], speed: {speed}}}
forces:
  push:
    type: force
    body: slider
    location: [0, {at}, 0]
    force: ["{force}", 0, 0]
  friction: {{type: friction, joint: guide, coulomb: {coulomb}}}
"""


def guide(coulomb, force, *, at=0.0, centre=0.0, speed=0.0, duration=1.0, steps="dop853", formulation="reduced"):
    return GUIDE.format(
        coulomb=coulomb,
        force=force,
        at=at,
        centre=centre,
        speed=speed,
        duration=duration,
        steps=STEPS[steps],
        formulation=formulation,
    )


@pytest.mark.parametrize("force", [1.0, 1000.0])
def test_a_slider_pushed_too_far_off_its_axis_jams_under_any_force(force):
    """2 μ a > L: a drawer that jams. The static coefficient makes no difference to the sliding one here."""
    length, μ = 0.2, 0.4
    for off in (0.24, 0.26):
        text = guide(f"{{coefficient: {μ}, bearing_length: {length}}}", force, at=off)
        _, recorded = run(text)
        speed = max(exact.pushed_off_axis(force, 2.0, μ, off, length), 0.0)
        assert recorded["joints/speed"][-1, 0] == pytest.approx(speed, rel=1e-9, abs=1e-12)
    assert (recorded["friction/state"] == 0).all()


def test_a_slider_that_moves_is_jammed():
    """It starts at 3 m/s, is slowed down by the very force that pushes it, and stays."""
    text = guide("{coefficient: 0.4, bearing_length: 0.2}", 10.0, at=0.3, speed=3.0, duration=4.0)
    _, recorded = run(text)
    slows = -exact.pushed_off_axis(10.0, 2.0, 0.4, 0.3, 0.2)
    (sticks,) = recorded.of("stick")
    assert sticks.time == pytest.approx(3.0 / slows, abs=1e-9)
    assert recorded["joints/coordinate"][-1, 0] == pytest.approx(4.5 / slows, abs=1e-9)


def test_preload_holds_without_a_load():
    """μ preload = 3 N against 2t N; then the sliding 2.4 N."""
    text = guide("{coefficient: 0.24, static: 0.3, preload: 10}", "2*t", duration=2.0)
    _, recorded = run(text)
    (slips,) = recorded.of("slip")
    assert slips.time == pytest.approx(1.5, abs=1e-9)
    assert recorded["joints/speed"][-1, 0] == pytest.approx((4.0 - 2.25 - 2.4 * 0.5) / 2.0, rel=1e-9)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["reduced", "full"])
def test_a_mass_beside_its_guide_below_the_critical_coefficient(formulation):
    """κ = 0.8: friction by the slider's own inertia, m a = force - κ m |a|, forwards and slowed down."""
    for force in (6.0, -6.0):
        text = guide("{coefficient: 0.4, bearing_length: 0.2}", force, centre=0.2, speed=40.0, formulation=formulation)
        _, recorded = run(text)
        (a,) = exact.mass_off_axis(force, 2.0, 0.4, 0.2, 0.2)
        assert recorded["joints/speed"][-1, 0] == pytest.approx(40.0 + a, rel=1e-9)


@pytest.mark.parametrize("formulation", ["reduced", "full"])
@pytest.mark.parametrize(("force", "count"), [(6.0, 2), (-6.0, 0)])
def test_painleves_paradox_of_a_slider(formulation, force, count):
    """κ = 1.6: two sliding accelerations where the force drives the slider, none where it brakes it. The run stops and
    names the friction."""
    assert len(exact.mass_off_axis(force, 2.0, 0.8, 0.2, 0.2)) == count
    text = guide("{coefficient: 0.8, bearing_length: 0.2}", force, centre=0.2, speed=2.0, formulation=formulation)
    with pytest.raises(SimulationError, match=r"friction 'friction'.*Painlevé"):
        run(text)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_painleves_paradox_of_a_rotor(formulation):
    """An eccentric rotor whose bearing is too wide: arm m e ≥ J + m e², so that no friction lets it slide."""
    critical = (0.5 + 2.0 * 0.1**2) / (2.0 * 0.1)
    coulomb = f"{{coefficient: 1, radius: {1.01 * critical}}}"
    with pytest.raises(SimulationError, match=r"friction 'brake'.*Painlevé"):
        run(rotor(coulomb, centre=[0.1, 0, 0], formulation=formulation))
    _, recorded = run(rotor(coulomb.replace(str(1.01 * critical), str(0.9 * critical)), centre=[0.1, 0, 0]))
    expected = exact.eccentric_coasts(0.5, 2.0, 0.1, 0.9 * critical, 30.0, 2.0)
    assert recorded["joints/speed"][-1, 0] == pytest.approx(expected[1], rel=1e-8)


CYLINDRICAL = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {{duration: 1, {steps}, formulation: {formulation}}}
bodies:
  piston: {{mass: 2, inertia: [0.5, 0.4, 0.4], position: [0, 0, 0]}}
joints:
  bore: {{type: cylindrical, bodies: [ground, piston], location: [0, 0, 0], axis: [1, 0, 0],
    speed: {{angle: 8, displacement: 2}}}}
forces:
  friction:
    type: friction
    joint: bore
    coulomb:
      angle: {{coefficient: 0.2, radius: 0.3}}
      displacement: {{coefficient: 0.25}}
"""


def test_each_coordinate_of_a_cylindrical_joint_has_its_own():
    _, recorded = run(CYLINDRICAL.format(steps=STEPS["dop853"], formulation="reduced"))
    weight = 2.0 * 9.81
    shifts = exact.brake_stops(2.0, 2.0, 0.25 * weight)
    names = {event.name: event.time for event in recorded.of("stick")}
    assert names["friction 'friction.displacement'"] == pytest.approx(shifts[0], abs=1e-9)
    assert recorded["joints/coordinate"][-1, 1] == pytest.approx(shifts[1], abs=1e-9)
    assert recorded["joints/coordinate"][-1, 0] == pytest.approx(8.0 - 0.5 * 0.2 * 0.3 * weight / 0.5, abs=1e-9)
    assert np.diff(recorded["friction/dissipation"], axis=0).min() >= -1e-12


#: A telescope has no rows, and stands before the joint whose load counts; so does another joint behind that.
ARMS = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 1e-3, integrator: dop853, tolerance: 1e-10, formulation: {formulation}}}
bodies:
  a: {{mass: 1, inertia: [0.05, 0.05, 0.05], position: [0.3, 0, 0]}}
  b: {{mass: 3, inertia: [0.05, 0.05, 0.05], position: [0.9, 0, 0.1]}}
joints:
  rod: {{type: telescope, bodies: [ground, b], locations: [[0, 0, 1], [0.9, 0, 0.1]]}}
  hinge: {{type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0], speed: 5}}
  elbow: {{type: revolute, bodies: [a, b], location: [0.6, 0, 0], axis: [0, 1, 0]}}
forces:
  friction: {{type: friction, joint: hinge, coulomb: {{coefficient: 0.3, radius: 0.05}}}}
"""


@pytest.mark.parametrize("formulation", [*FORMULATIONS[:2], full("full")])
def test_joints_without_rows_have_no_number_among_loads(formulation):
    """Torque = μ r F with F of the joint that has the friction."""
    _, recorded = run(ARMS.format(formulation=formulation))
    across = np.linalg.norm(recorded["joints/reaction_force"][0, 1])
    assert abs(recorded["friction/force"][0, 0]) == pytest.approx(0.3 * 0.05 * across, rel=1e-12)


# A slider-crank whose guide resists by the force across it, which friction itself changes: against the equations of its
# bodies, integrated by SciPy.


@pytest.mark.parametrize("rate", [12.0, -12.0])
def test_the_equations_of_the_bodies_keep_their_energy(rate):
    """What SciPy integrates loses what friction takes, by energies that it does not know."""
    motion = crank.Motion(crank.START, rate, 0.3, 0.4, 0.5)
    φ, speed, lost = motion(0.5)
    assert crank.energy(crank.START, rate) - crank.energy(φ, speed) == pytest.approx(lost, abs=1e-9)
    assert lost > 0.3


@pytest.mark.parametrize(("formulation", "rate"), [("reduced", 12.0), ("reduced", -12.0), ("full", -12.0)])
def test_it_turns_as_the_equations_of_its_bodies_have_it(formulation, rate):
    """Through two reversals of the slider, at its dead centres, where the crank goes on."""
    duration = 0.08 if formulation == "full" else 0.5
    motion = crank.Motion(crank.START, rate, 0.3, 0.4, duration)
    assert len(motion.times) == (1 if formulation == "full" else 2)
    _, recorded = run(crank.linkage(rate, 0.3, 0.4, duration, formulation))
    found = np.array([motion(t) for t in recorded["time"]])
    assert recorded["joints/coordinate"][:, 0] == pytest.approx(found[:, 0] - crank.START, abs=1e-8)
    assert recorded["joints/speed"][:, 0] == pytest.approx(found[:, 1], abs=1e-7)
    assert recorded["friction/dissipation"][:, 0] == pytest.approx(found[:, 2], abs=1e-7)
    assert recorded["joints/violation"].max() < 2e-13
    assert recorded.unbalanced < 1e-7


def test_it_comes_to_rest_between_its_dead_centres_and_stays():
    motion = crank.Motion(crank.START, 6.0, 0.3, 0.6, 1.3)
    assert motion.rests < 1.1
    _, recorded = run(crank.linkage(6.0, 0.3, 0.6, 1.3, "reduced"))
    last = recorded.of("stick")[-1]
    assert last.time == pytest.approx(motion.rests, abs=1e-8)
    assert recorded["joints/speed"][-1] == pytest.approx(0.0, abs=1e-11)
    assert recorded["joints/coordinate"][-1, 0] == pytest.approx(motion(1.3)[0] - crank.START, abs=1e-8)


#: Four joints that each hold the plane: what they carry across it is not unique.
REDUNDANT = f"""
  B: {{type: revolute, bodies: [crank, rod], location: [{crank.PIN[0]}, {crank.PIN[1]}, 0], axis: [0, 0, 1]}}
  C: {{type: revolute, bodies: [rod, slider], location: [{crank.END}, 0, 0], axis: [0, 0, 1]}}
"""


def test_friction_by_what_redundant_joints_share_is_refused_and_a_constant_one_is_not():
    text = crank.linkage(12.0, 0.3, 0.4, 0.02, "reduced").replace(crank.PINS.strip("\n"), REDUNDANT.strip("\n"))
    with pytest.raises(
        InputError, match=r"'guide' depends on the load of joint 'D', which is not unique.*'A', 'B', 'C'"
    ):
        run(text)
    _, recorded = run(text.replace("coefficient: 0.3, static: 0.4", "force: 3"))
    slid = crank.slider(crank.START, 0.0)[0] - crank.slider(crank.START + recorded["joints/coordinate"][-1, 0], 0.0)[0]
    assert recorded["friction/dissipation"][-1, 0] == pytest.approx(3.0 * slid, rel=1e-8)
