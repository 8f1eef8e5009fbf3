"""Compliant stops: restitution, energies, rest, and equilibria on them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import mbproj
from mbproj import InputError, assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.base.errors import SimulationError
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.equilibrium.start import observed, start_state
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from mbproj.model.compile.contacts import resistance
from mbproj.results.analysis.expectations import series
from tests.stops.runs import DOP853, FIXED, Recorded, run

# Compliant stops: the restitution that is obtained, energies, rest, and the way to rigid ones.

GUIDE = Path(mbproj.__file__).parent / "guide"
BALL = """
mbproj: 1
gravity: [0, 0, {g}]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  ball: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 1], velocity: [0, 0, {speed}]}}
forces:
  floor:
    {{type: stop, plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}},
     point: {{body: ball, location: [0, 0, 1]}}, {law}}}
"""


def ball(law, speed=-2, g=0, duration=1, steps=DOP853, formulation="reduced"):
    return run(BALL.format(law=law, speed=speed, g=g, duration=duration, steps=steps, formulation=formulation))


@pytest.mark.parametrize("e", [1e-6, 0.1, 0.3, 0.48, 0.49, 0.7, 0.999, 1 - 1e-9, 1.0])
def test_the_resistance_gives_the_restitution_and_never_pulls(e):
    """The impact itself, x'' = -x (1 + d w) with w = x' / √(x'² + κ x²), by an integrator of others."""
    d, κ = resistance(e)
    assert 0.0 <= d <= 1.0 and 0.0 < κ <= 1.0 and (d == 1.0 or κ == 1.0)
    if e > 0.9:
        assert d == pytest.approx(1.5 * (1.0 - e), rel=1e-3)
    if e < 0.01:
        assert κ == pytest.approx(8.0 * e**4, rel=1e-4)
        return

    def rates(_, y):
        x, v = y
        return [v, -x * (1.0 + d * v / np.hypot(v, np.sqrt(κ) * x))]

    def opens(_, y):
        return y[0]

    opens.terminal, opens.direction = True, -1
    solved = solve_ivp(rates, (0.0, 100.0), [1e-14, 1.0], "DOP853", events=opens, rtol=1e-12, atol=1e-15)
    assert -solved.y[1, -1] == pytest.approx(e, rel=1e-8)


def test_the_guide_has_the_curve():
    page = (GUIDE / "explanation" / "impacts.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([\d.]+) \| ([\d.]+) \| ([\d.e-]+) \| ([\d.]+) \|$", page, re.MULTILINE)
    assert len(rows) == 10
    for e, *shown in rows:
        d, κ = resistance(float(e))
        assert [float(x) for x in shown] == pytest.approx([d, κ, d / (2.0 * np.sqrt(κ))], rel=0.03, abs=5e-5)


def test_small_motions_on_it_are_damped():
    """A mass on a stop with restitution: the damping ratio is d / (2 √κ), and modes know it."""
    text = BALL.format(
        law="stiffness: 1.0e4, restitution: 0.6", speed=0, g=-10, duration=1, steps=DOP853, formulation="full"
    )
    scene = read_scene_text(text)
    system = compile_system(scene)
    found = modes(equilibrium(system, start_state(scene, system)).reference)
    oscillates = found.eigenvalues[found.eigenvalues.imag > 0.0]
    assert oscillates.size == 1
    d, κ = resistance(0.6)
    assert abs(oscillates[0]) == pytest.approx(np.sqrt(1.0e4 / 2.0), rel=1e-9)
    assert -oscillates[0].real / abs(oscillates[0]) == pytest.approx(d / (2.0 * np.sqrt(κ)), rel=1e-9)


def test_it_has_its_restitution_at_every_speed():
    for speed in (1e-4, 1.0):
        _, recorded = ball("stiffness: 1.0e4, restitution: 0.5", speed=-speed, duration=1.2 / speed)
        assert recorded["bodies/velocity"][-1, 0, 2] == pytest.approx(0.5 * speed, rel=1e-6)


def test_it_has_its_stiffness_at_rest_however_gently_it_was_touched():
    press = """
  press: {type: force, body: ball, location: [0, 0, 1], axes: global, force: [0, 0, -50*sin(t)**2]}
"""
    text = BALL.format(
        law="stiffness: 1.0e4, restitution: 0.5", speed=-1e-4, g=0, duration=1.5, steps=DOP853, formulation="reduced"
    ).replace("position: [0, 0, 1]", "position: [0, 0, 1.000001]")
    _, recorded = run(text.replace("location: [0, 0, 1]}, ", "location: [0, 0, 1.000001]}, ") + press.lstrip("\n"))
    assert recorded.happened[0].kind == "contact"
    assert recorded["stops/gap"][-1, 0] == pytest.approx(-50.0 * np.sin(1.5) ** 2 / 1.0e4, rel=1e-3)


@pytest.mark.parametrize("exponent", [1, 1.5, 2])
@pytest.mark.parametrize("e", [0.1, 0.3, 0.7, 1.0])
def test_a_free_impact_has_the_restitution(e, exponent):
    _, recorded = ball(f"stiffness: 1.0e5, exponent: {exponent}, restitution: {e}")
    assert recorded["bodies/velocity"][-1, 0, 2] == pytest.approx(2.0 * e, rel=1e-6)
    assert recorded["diagnostics/dissipation"][-1] == pytest.approx(4.0 * (1.0 - e**2), rel=1e-6, abs=1e-8)
    assert [event.kind for event in recorded.happened] == ["contact", "release"]
    assert recorded.unbalanced < 1e-7
    assert recorded["stops/force"].min() >= 0.0


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["reduced", "full"])
def test_fixed_steps_end_where_it_is_met(formulation):
    steps = FIXED if formulation == "reduced" else "integrator: rk4, step: 5.0e-3"
    _, recorded = ball("stiffness: 1.0e3, restitution: 0.5", steps=steps, formulation=formulation)
    met, left = recorded.happened
    assert met.time == pytest.approx(0.5, abs=1e-12)
    assert recorded["bodies/velocity"][-1, 0, 2] == pytest.approx(1.0, rel=1e-4)
    assert left.time > 0.5 + 0.5 * np.pi * np.sqrt(2.0 / 1.0e3)


def test_what_rests_on_it_sinks_in_by_its_weight():
    _, recorded = ball("stiffness: 1.0e4, restitution: 0.3", speed=0, g=-10, duration=4)
    assert recorded["stops/gap"][-1, 0] == pytest.approx(-20.0 / 1.0e4, rel=1e-3)
    assert recorded["stops/force"][-1, 0] == pytest.approx(20.0, rel=1e-3)
    assert recorded.unbalanced < 1e-7


def test_what_begins_in_balance_on_several_of_them_stays_there():
    """A block on a floor carries a lid that presses a spring to its stop: without the floor, it would leave it."""
    text = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 2, step: 2 ms, output_step: 0.1, start: equilibrium}
bodies:
  block: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.5]}
  lid: {mass: 3, inertia: [0.1, 0.1, 0.1], position: [0, 0, 1]}
joints:
  guide: {type: prismatic, bodies: [ground, block], location: [0, 0, 0], axis: [0, 0, 1]}
  strut:
    type: prismatic
    bodies: [block, lid]
    location: [0, 0, 1]
    axis: [0, 0, 1]
    limits: {displacement: {range: [-0.01, null], stiffness: 2e5, exponent: 2, restitution: 0.4}}
forces:
  coil: {type: linear_spring_damper, joint: strut, stiffness: 1000}
  floor:
    {type: stop, plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]},
     point: {body: block, location: [0, 0, 0.5]}, radius: 0.5, stiffness: 5000, restitution: 0.6}
expect:
  energy: {diagnostic: energy_drift_relative, at: maximum, below: 1e-6, source: nothing moves}
"""
    scene = read_scene_text(text)
    system = compile_system(scene)
    recorded = Recorded()
    report = simulate(system, start_state(scene, system), settings_to_run(scene), recorded)
    assert recorded["stops/gap"][-1, 1] == pytest.approx(-50.0 / 5000.0, rel=1e-9)
    pressed = -recorded["stops/gap"][-1, 0]
    assert 2e5 * pressed**2 + 1000.0 * (0.01 + pressed) == pytest.approx(30.0, rel=1e-9)
    assert np.ptp(recorded["stops/gap"], axis=0).max() < 1e-12
    assert report.energy_drift_relative == 0.0
    (energy,) = scene.expectations
    assert series(energy, _Samples(recorded)).max() == 0.0


class _Samples(NamedTuple):
    """What was recorded, as expectations read it."""

    recorded: Recorded

    def __getitem__(self, path):
        return self.recorded[path]

    def names(self, kind):
        return ()

    @property
    def event_times(self):
        return np.zeros(0)


def test_given_damping_is_that_of_every_contact():
    """F = k δ (1 + c δ'): the energy that a contact takes follows from c times the speed."""
    c = brentq(lambda d: 1.5 * d - np.log((1.0 + d) / (1.0 - 0.5 * d)), 0.1, 1.9) / 2.0
    _, recorded = ball(f"stiffness: 1.0e5, damping: {c}")
    assert recorded["bodies/velocity"][-1, 0, 2] == pytest.approx(1.0, rel=1e-7)


def test_it_becomes_rigid_with_its_stiffness():
    """A ball that bounces, e = 1: it is late by the time of contact, π √(m/k), an error of order 1/2 in k."""
    late = []
    for k in (1.0e6, 1.0e8):
        _, recorded = ball(f"stiffness: {k:g}, restitution: 1", duration=1)
        late.append(1.0 - recorded["bodies/position"][-1, 0, 2])
    assert late == pytest.approx([2.0 * np.pi * np.sqrt(2.0 / k) for k in (1.0e6, 1.0e8)], rel=1e-3)
    assert np.log10(late[0] / late[1]) / 2.0 == pytest.approx(0.5, abs=0.01)


HINGED = """
mbproj: 1
gravity: [0, -10, 0]
simulation: {{duration: 0.5, {steps}, formulation: {formulation}}}
bodies:
  door: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}}
joints:
  hinge:
    type: revolute
    bodies: [ground, door]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    angle: {start} deg
    speed: {speed}
    limits: {{angle: {{range: {range}, stiffness: 1.0e4, restitution: 0.6}}}}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
@pytest.mark.parametrize(
    ("start", "speed", "limits"), [(0, -3, "[-30 deg, null]"), (170, 9, "[null, 200 deg]"), (720, 9, "[null, 750 deg]")]
)
def test_limits_of_angles_count_turns(formulation, start, speed, limits):
    steps = DOP853 if formulation != "full" else "integrator: dop853, tolerance: 1.0e-6, output_step: 0.1"
    _, recorded = run(HINGED.format(steps=steps, formulation=formulation, start=start, speed=speed, range=limits))
    bound = {-3: -30.0, 9: 200.0 if start == 170 else 750.0}[speed]
    first = recorded.happened[0]
    assert first.kind == "contact"
    far = np.degrees(recorded["joints/coordinate"][:, 0]) - bound
    assert np.sign(speed) * far.max() < 3.0 if speed > 0 else far.min() > -3.0
    assert recorded.unbalanced < 1e-3


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["full", "reduced"])
def test_an_overdamped_stop_is_steep_and_no_dry_friction(formulation):
    """k δ (1 + d v) with d = 2e4 s/m has no jump: explicit steps ring about its kink, where implicit ones come to rest
    at δ = m g / k."""
    law = "stiffness: 1.0e8, exponent: 1, damping: 2.0e4"
    steps = "tolerance: 1.0e-6, output_step: 0.1, integrator: {}"
    with pytest.raises(SimulationError, match=r"again and again.*no jump.*explicit.*esdirk4") as stopped:
        ball(law, g=-9.81, steps=steps.format("dop853"), formulation=formulation)
    assert "dry friction" not in str(stopped.value)
    _, recorded = ball(law, g=-9.81, steps=steps.format("radau5"), formulation=formulation)
    assert recorded["bodies/position"][-1, 0, 2] == pytest.approx(-2 * 9.81 / 1e8, rel=0.01)


# Equilibria and small motions on stops: compliant ones carry, rigid ones are refused by name.

#: A block of 2 kg on a vertical slide, above a stop, with a spring that holds it where SPRING says so.
BLOCK = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 1, step: 1 ms}
bodies:
  block: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  slide:
    type: prismatic
    bodies: [ground, block]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    displacement: 0
    limits: {displacement: {range: [-0.1, null], LAW}}
SPRING
"""
SPRING = "forces: {coil: {type: linear_spring_damper, joint: slide, stiffness: 100}}"


def assembled(law, spring=""):
    scene = read_scene_text(BLOCK.replace("LAW", law).replace("SPRING", spring))
    system = compile_system(scene)
    return system, assemble(system, initial_guess(scene, system))


@pytest.mark.parametrize(("exponent", "depth"), [(1, 20.0 / 1e4), (1.5, (20.0 / 1e4) ** (1 / 1.5)), (2, 0.002**0.5)])
def test_a_compliant_stop_carries_the_weight(exponent, depth):
    found = equilibrium(*assembled(f"stiffness: 1.0e4, exponent: {exponent}, restitution: 0.5"))
    block = observed(found)
    assert block["stops/gap"][0, 0] == pytest.approx(-depth, rel=1e-9)
    assert block["stops/force"][0, 0] == pytest.approx(20.0, rel=1e-9)
    stiffness = exponent * 1e4 * depth ** (exponent - 1)
    (frequency,) = np.abs(modes(found.reference).eigenvalues[:1])
    assert frequency == pytest.approx(np.sqrt(stiffness / 2.0), rel=1e-9)


def test_what_does_not_touch_does_not_act():
    found = equilibrium(*assembled("stiffness: 1.0e4", SPRING.replace("100", "1000")))
    assert observed(found)["joints/coordinate"][0, 0] == pytest.approx(-0.02, rel=1e-9)
    assert observed(found)["stops/force"][0, 0] == 0.0


def test_an_equilibrium_beyond_a_rigid_stop_is_none():
    with pytest.raises(InputError, match=r"0\.1 m beyond the rigid stop 'slide.displacement.low'"):
        equilibrium(*assembled("rigid: true", SPRING))


def test_rigid_stops_hold_nothing_in_an_equilibrium_and_that_is_said():
    with pytest.raises(NoEquilibrium, match="rigid stops hold nothing here"):
        equilibrium(*assembled("rigid: true"))


def test_a_rigid_stop_that_touches_has_no_linear_part():
    scene = read_scene_text(BLOCK.replace("LAW", "rigid: true").replace("SPRING", "").replace("-0.1, null", "0, null"))
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    with pytest.raises(InputError, match=r"the rigid stop 'slide.displacement.low' touches at this pose"):
        modes(reference_at(system, state, "start"))


def test_a_run_from_the_equilibrium_stays_there():
    text = BLOCK.replace("LAW", "stiffness: 1.0e4, restitution: 0.5").replace("SPRING", "")
    scene = read_scene_text(text.replace("step: 1 ms", "step: 1 ms, start: equilibrium"))
    system, recorded = compile_system(scene), Recorded()
    simulate(system, start_state(scene, system), settings_to_run(scene), recorded)
    assert recorded["stops/gap"][:, 0] == pytest.approx(-20.0 / 1e4, abs=1e-12)
    assert recorded["stops/force"][:, 0] == pytest.approx(20.0, rel=1e-9)
