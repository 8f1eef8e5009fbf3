"""The loads of joints: the largest ones, between samples too, those of driven mechanisms, and which are unique."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import (
    assemble,
    compile_system,
    initial_guess,
    open_results,
    read_scene,
    read_scene_text,
    run,
    settings_to_run,
    simulate,
)
from mbproj.results.analysis.loads import duration_above, loads_of, recorded_in, samples_of, swings
from mbproj.results.between_samples import in_and_out, integrals, peaks, pieces
from mbproj.results.largest_loads import loads
from mbproj.results.writer import ResultsWriter
from tests.results.pendulum_blocks import record
from tests.support import ROOT

# The largest loads: peaks between samples, works, and the same from the file as from its samples.

ONE_PIECE = np.zeros(0)


@pytest.mark.parametrize("samples", [30, 60, 120])
def test_a_peak_between_samples_is_found_to_the_stated_uncertainty(samples):
    time = np.linspace(0.0, 2.0 * np.pi, samples)
    values = np.stack([-3.0 * np.sin(time - 0.1), 2.0 + np.cos(time - 1.0)], axis=1)[..., None]
    found = peaks(time, values, pieces(time, ONE_PIECE))
    assert np.all(np.abs(np.abs(found.value) - 3.0) <= found.uncertainty)
    assert found.uncertainty.max() < 200.0 / samples**4 + 1e-14
    assert found.time[1] == pytest.approx(1.0, abs=1e-3)


def test_of_two_peaks_the_higher_one_wins_though_a_sample_meets_the_other():
    time = np.arange(0.0, 8.0, 0.1)
    low, high = np.exp(-((time - 2.0) ** 2)), 1.001 * np.exp(-((time - 6.05) ** 2))
    found = peaks(time, (low + high)[:, None, None], pieces(time, ONE_PIECE))
    assert found.time[0] == pytest.approx(6.05, abs=1e-4)


def test_what_is_constant_is_largest_at_its_first_sample():
    time = np.linspace(0.0, 1.0, 101)
    found = peaks(time, np.full((101, 1, 1), -8000.0), pieces(time, ONE_PIECE))
    assert (found.value[0], found.time[0]) == (-8000.0, 0.0)
    assert found.uncertainty[0] < 1e-10


def test_no_polynomial_crosses_a_jump():
    time = np.linspace(0.0, 2.0, 201)
    values = np.where(time <= 1.0, time, -0.5)
    found = peaks(time, values[:, None, None], pieces(time, np.array([1.0])))
    assert found.value[0] == pytest.approx(1.0, abs=1e-12)
    assert found.time[0] == 1.0
    assert found.uncertainty[0] < 1e-12


def test_a_sample_at_a_jump_is_the_last_before_it():
    """∫ t dt up to the sample at 1 s, and -0.5 from there on."""
    time = np.linspace(0.0, 2.0, 201)
    values = np.where(time <= 1.0, time, -0.5)[:, None]
    areas = integrals(time, values, pieces(time, np.array([1.0])))
    assert areas[:100].sum() == pytest.approx(0.5, abs=1e-12)
    assert areas[100:].sum() == pytest.approx(-0.5, abs=1e-12)


@pytest.mark.parametrize("samples", [11, 14, 30, 80, 300])
@pytest.mark.parametrize("event", [0.61, 0.7123, 0.7999])
def test_a_peak_just_before_a_jump_is_found_to_the_stated_uncertainty(samples, event):
    """A load that grows until a friction reverses: its largest value stands between the last sample and the jump."""
    time = np.linspace(0.0, 1.0, samples)
    shape = np.exp(2.0 * np.minimum(time, event)) * np.cos(0.3 * time)
    values = np.where(time <= event, shape, 1.0 - np.sin(time - event))
    found = peaks(time, np.stack([values, -values], axis=1)[..., None], pieces(time, np.array([event])))
    largest = np.exp(2.0 * event) * np.cos(0.3 * event)
    assert np.all(np.abs(np.abs(found.value) - largest) <= found.uncertainty)
    assert np.all(np.sign(found.value) == [1.0, -1.0])
    if samples >= 30:
        assert found.uncertainty.max() < 1e-3
        np.testing.assert_allclose(found.time, event)


def test_a_load_just_after_an_event_between_few_samples_is_within_the_uncertainty():
    """Two events within three samples: the piece between them has one sample, and no polynomial."""
    time = np.linspace(0.0, 1.0, 21)
    first, last = 0.49, 0.53
    load = np.where(time < first, 1.0, np.where(time < last, 3.0 + 10.0 * (time - first), 2.0))
    found = peaks(time, load[:, None, None], pieces(time, np.array([first, last])))
    assert 3.0 + 10.0 * (last - first) <= found.value[0] + found.uncertainty[0]


def test_works_are_those_of_each_side_of_a_jump():
    """A power whose sign changes at a reversal, and at a zero that is no event; the integrals are closed."""
    event, zero = 0.4321, 0.8123
    time = np.linspace(0.0, 1.0, 26)
    power = np.where(time <= event, -np.exp(time), np.cos(time) - np.cos(zero))[:, None]
    put_in, taken_out = in_and_out(time, power, pieces(time, np.array([event])))
    above = np.sin(zero) - np.sin(event) - (zero - event) * np.cos(zero)
    below = -(np.sin(1.0) - np.sin(zero) - (1.0 - zero) * np.cos(zero))
    assert put_in[0] == pytest.approx(above, rel=1e-7)
    assert taken_out[0] == pytest.approx(np.exp(event) - 1.0 + below, rel=1e-7)


def test_friction_that_only_takes_puts_nothing_in():
    time = np.linspace(0.0, 10.0, 700)
    turns = np.pi * np.arange(1, 4)
    power = -3.0 * np.abs(np.sin(time))[:, None]
    put_in, taken_out = in_and_out(time, power, pieces(time, turns))
    assert put_in[0] == 0.0
    assert taken_out[0] == pytest.approx(3.0 * (7.0 + np.cos(10.0 - 3.0 * np.pi) * -1.0), rel=1e-9)


def test_an_integral_is_exact_for_cubics_and_works_add_up_to_it():
    time = np.sort(np.concatenate([np.linspace(0.0, 1.0, 9), [0.37]]))
    cubic = (4.0 * time**3 - time)[:, None]
    piece = pieces(time, ONE_PIECE)
    assert integrals(time, cubic, piece).sum() == pytest.approx(0.5, abs=1e-14)
    put_in, taken_out = in_and_out(time, cubic, piece)
    assert put_in[0] - taken_out[0] == pytest.approx(0.5, abs=1e-14)
    assert taken_out[0] == pytest.approx(1.0 / 16.0, abs=1e-3)


def test_the_time_above_a_level_is_that_of_the_curve():
    time = np.linspace(0.0, 2.0 * np.pi, 2001)
    assert duration_above(time, np.sin(time), 0.5) == pytest.approx(4.0 * np.pi / 3.0, abs=1e-5)


def test_rainflow_counts_the_example_of_the_standard():
    pytest.importorskip("rainflow")
    counted = swings(np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]))  # ASTM E1049-85, fig. 6
    assert [(swing.range, swing.cycles) for swing in counted] == [
        (9.0, 0.5),
        (8.0, 1.0),
        (6.0, 0.5),
        (4.0, 1.5),
        (3.0, 0.5),
    ]


def test_the_file_keeps_what_its_samples_say(tmp_path):
    with open_results(record(tmp_path / "pendulum.h5")) as results:
        kept = loads_of(results)
        computed = loads(recorded := recorded_in(results), recorded.cycle())
        by_name = {(load.kind, load.name, load.quantity): load for load in kept}
        pull = by_name["joint", "A", "reaction_force"]
        assert pull.largest == pytest.approx(np.linalg.norm(results.joint("A").reaction_force, axis=1).max(), rel=1e-6)
        assert samples_of(results, pull).max() <= pull.largest + pull.uncertainty
    assert kept
    assert repr(list(kept)) == repr(computed)


# Loads of driven mechanisms against closed forms and against a run with a hundred times the samples.

CRANK, ROD, ROD_CENTRE, ROD_MASS, PISTON_MASS = 0.043, 0.14, 0.04, 0.6, 0.5
SPEED = 1500.0 * 2.0 * np.pi / 60.0


def run_engine(path, step, output_step, duration=0.04):
    scene = read_scene(ROOT / "mechanisms" / "inline_four.yaml")
    system = compile_system(scene)
    settings = replace(settings_to_run(scene), duration=duration, step=step, output_step=output_step)
    with ResultsWriter(path, scene, system.names.as_mapping()) as recorder:
        simulate(system, assemble(system, initial_guess(scene, system)), settings, recorder)
    return open_results(path)


def piston_acceleration(angle):
    """z'' of z = r cos θ + sqrt(l² - r² sin² θ) at constant speed."""
    sine, root = CRANK * np.sin(angle), np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    slope = sine * CRANK * np.cos(angle)
    bend = CRANK**2 * np.cos(2.0 * angle)
    return -(SPEED**2) * (CRANK * np.cos(angle) + bend / root + slope**2 / root**3)


def test_the_engine_shakes_its_ground_as_the_closed_form_says(tmp_path):
    """A rod is two points at its pins: with its part of the rod's mass, each piston's inertia acts vertically; the
    rotating masses cancel. The bores take no vertical force, so the main bearing takes all of it."""
    with run_engine(tmp_path / "engine.h5", 1e-4, 1e-3) as results:
        weight = (20.0 + 4.0 * ROD_MASS + 4.0 * PISTON_MASS) * 9.81
        moving = PISTON_MASS + ROD_MASS * ROD_CENTRE / ROD
        angle = np.pi / 6.0 + SPEED * results.time
        pistons = sum(piston_acceleration(angle + shift) for shift in (0.0, np.pi, np.pi, 0.0))
        expected = weight + moving * pistons
        found = results.joint("main").reaction_force[:, 2]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


def test_peaks_are_those_of_a_run_with_a_hundred_times_the_samples(tmp_path):
    with run_engine(tmp_path / "few.h5", 1e-4, 1e-3) as few, run_engine(tmp_path / "many.h5", 1e-5, 1e-5) as many:
        one, other = ({load[:3]: load for load in loads_of(results)} for results in (few, many))
        forces = {key for key, load in other.items() if load.kind == "motion" or load.largest > 1.0}
        assert len(forces) == 15  # the forces of 13 joints, the drive's torque and power
        for key in forces:
            apart = abs(abs(one[key].largest) - abs(other[key].largest))
            assert apart <= one[key].uncertainty + other[key].uncertainty + 1e-9 * abs(other[key].largest), key
            assert one[key].uncertainty < 2e-2 * abs(other[key].largest), key


def test_over_two_turns_the_drive_takes_out_what_it_puts_in(tmp_path):
    with run_engine(tmp_path / "engine.h5", 1e-4, 1e-4, duration=0.08) as results:
        power = next(load for load in loads_of(results) if load.quantity == "power")
    assert power.put_in == pytest.approx(power.taken_out, rel=1e-9)


# Which loads of a machine that moves in a plane are unique, and how large they are where a friction reverses.

#: A crank of 0.1 m drives a rocker of 0.2 m, whose hinge rubs. `turned` is the pose of its plane in the world.
FOUR_BAR = """
mbproj: 1
gravity: {gravity}
simulation: {{duration: 1.1, kinematic: true, output_step: {step}}}
bodies:
  crank: {{mass: 1, inertia: [0.01, 0.01, 0.001], position: {crank}, orientation: {{matrix: {turned}}}}}
  coupler: {{mass: 2, inertia: [0.01, 0.05, 0.05], position: {coupler}, orientation: {{matrix: {turned}}}}}
  rocker: {{mass: 1.5, inertia: [0.02, 0.02, 0.001], position: {rocker}, orientation: {{matrix: {turned}}}}}
joints:
  A: {{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: {axis}}}
  B: {{type: revolute, bodies: [crank, coupler], location: {B}, axis: {axis}}}
  C: {{type: revolute, bodies: [coupler, rocker], location: {C}, axis: {axis}}}
  D: {{type: revolute, bodies: [ground, rocker], location: {D}, axis: {axis}}}
forces:
  rub: {{type: friction, joint: D, coulomb: {{torque: 3}}}}
motions:
  drive: {{joint: A, angle: {{constant_speed: 6 rad/s}}}}
"""
POINTS = {
    "crank": (0.0, 0.0, 0.05),
    "coupler": (0.2, 0.0, 0.15),
    "rocker": (0.4, 0.0, 0.1),
    "B": (0.0, 0.0, 0.1),
    "C": (0.4, 0.0, 0.2),
    "D": (0.4, 0.0, 0.0),
    "axis": (0.0, 1.0, 0.0),
}


def four_bar(path, yaw, tilt, *, across=0.0, step=0.01):
    """The loads of a run by (kind, name, quantity), with gravity `across` the plane."""
    (c, s), (ct, st) = ((np.cos(a), np.sin(a)) for a in (yaw, tilt))
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ [[1, 0, 0], [0, ct, -st], [0, st, ct]]
    given = {name: (turned @ point).tolist() for name, point in POINTS.items()}
    gravity = (turned @ [0.0, across, -9.81]).tolist()
    text = FOUR_BAR.format(**given, gravity=gravity, turned=turned.tolist(), step=step)
    run(read_scene_text(text), output=path).close()
    with open_results(path) as results:
        assert len(results.constant("joints/reaction_force_open")) == 4
        return {(load.kind, load.name, load.quantity): load for load in loads_of(results)}


@pytest.mark.parametrize(("yaw", "tilt"), [(0.0, 0.0), (0.7, 0.4)])
def test_bearings_share_only_loads_out_of_the_plane(tmp_path, yaw, tilt):
    """All were starred, since their components out of the plane are not unique."""
    loads = four_bar(tmp_path / "in.h5", yaw, tilt)
    assert all(loads["joint", name, "reaction_force"].unique for name in "ABCD")
    loads = four_bar(tmp_path / "across.h5", yaw, tilt, across=2.0)
    assert not any(loads["joint", name, "reaction_force"].unique for name in "ABCD")


def test_peaks_at_a_reversal_are_within_their_uncertainty(tmp_path):
    """Beside samples a hundred times as dense. The stated ± was round-off, and the peak off by a part in a thousand."""
    fine = four_bar(tmp_path / "fine.h5", 0.0, 0.0, step=1e-4)
    for step, known in ((0.03, 0.1), (0.01, 2e-5)):
        coarse = four_bar(tmp_path / "coarse.h5", 0.0, 0.0, step=step)
        for name in "ABCD":
            found, exact = (each["joint", name, "reaction_force"] for each in (coarse, fine))
            assert abs(found.largest - exact.largest) <= found.uncertainty + 1e-9
            assert found.uncertainty < known * exact.largest
