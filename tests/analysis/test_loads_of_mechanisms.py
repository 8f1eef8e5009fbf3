"""Loads of driven mechanisms against closed forms and against a run with a hundred times the samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.results.analysis.loads import loads_of
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from tests.support import ROOT

CRANK, ROD, ROD_CENTRE, ROD_MASS, PISTON_MASS = 0.043, 0.14, 0.04, 0.6, 0.5
SPEED = 1500.0 * 2.0 * np.pi / 60.0


def run(path, step, output_step, duration=0.04):
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
    with run(tmp_path / "engine.h5", 1e-4, 1e-3) as results:
        weight = (20.0 + 4.0 * ROD_MASS + 4.0 * PISTON_MASS) * 9.81
        moving = PISTON_MASS + ROD_MASS * ROD_CENTRE / ROD
        angle = np.pi / 6.0 + SPEED * results.time
        pistons = sum(piston_acceleration(angle + shift) for shift in (0.0, np.pi, np.pi, 0.0))
        expected = weight + moving * pistons
        found = results.joint("main").reaction_force[:, 2]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


def test_peaks_are_those_of_a_run_with_a_hundred_times_the_samples(tmp_path):
    with run(tmp_path / "few.h5", 1e-4, 1e-3) as few, run(tmp_path / "many.h5", 1e-5, 1e-5) as many:
        one, other = ({load[:3]: load for load in loads_of(results)} for results in (few, many))
        forces = {key for key, load in other.items() if load.kind == "motion" or load.largest > 1.0}
        assert len(forces) == 15  # the forces of 13 joints, the drive's torque and power
        for key in forces:
            apart = abs(abs(one[key].largest) - abs(other[key].largest))
            assert apart <= one[key].uncertainty + other[key].uncertainty + 1e-9 * abs(other[key].largest), key
            assert one[key].uncertainty < 2e-2 * abs(other[key].largest), key


def test_over_two_turns_the_drive_takes_out_what_it_puts_in(tmp_path):
    with run(tmp_path / "engine.h5", 1e-4, 1e-4, duration=0.08) as results:
        power = next(load for load in loads_of(results) if load.quantity == "power")
    assert power.put_in == pytest.approx(power.taken_out, rel=1e-9)
