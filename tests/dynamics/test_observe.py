"""What is recorded obeys mechanics: Newton and Euler for every body with its reactions, rates of change, energies."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from mbproj import read_scene, settings_to_run
from mbproj.base.mechanisms_folder import mechanism
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.equations.recorded import Observer
from mbproj.equations.samples import Samples, join
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.motion.simulate import simulate
from tests.crossed import full
from tests.support import Recorder, assembled, random_chain

KINDS = ["revolute", "universal", "prismatic", "spherical"]
STEP = 1e-3


@pytest.fixture(scope="module")
def run():
    """A short motion of a chain with every kind of joint, at every step."""
    scene = random_chain(12, KINDS)
    system, state = assembled(scene)
    recorder = Recorder()
    simulate(system, state, Settings(duration=0.05, step=STEP, projection=ProjectionSettings()), recorder)
    return scene, system, recorder


def loads(scene, system, run):
    """Σ of the joint reactions on each body: force, and torque about its centre of mass, (T, n, 3), global axes."""
    index = {name: number for number, name in enumerate(system.names.bodies)}
    position = run["bodies/position"]
    rotation = rotation_matrix(run["bodies/orientation"])
    force, torque = np.zeros_like(position), np.zeros_like(position)
    for number, joint in enumerate(scene.joints):
        F, T = run["joints/reaction_force"][:, number], run["joints/reaction_torque"][:, number]
        second = index[joint.bodies[1]]
        point = position[:, second] + (rotation[:, second] @ system.reaction_local[number][:, None])[..., 0]
        for name, sign in ((joint.bodies[0], -1.0), (joint.bodies[1], 1.0)):
            if name in index:
                body = index[name]
                force[:, body] += sign * F
                torque[:, body] += sign * (T + np.cross(point - position[:, body], F))
    return force, torque


def test_newton(run):
    scene, system, record = run
    force, _ = loads(scene, system, record)
    expected = system.mass[:, None] * (record["bodies/acceleration"] - system.gravity)
    np.testing.assert_allclose(force, expected, atol=1e-10 * np.abs(expected).max())


def test_euler(run):
    """J ω' + ω × J ω is the torque about the centre of mass, in body axes."""
    scene, system, record = run
    _, torque = loads(scene, system, record)
    omega, omega_dot = record["bodies/angular_velocity"], record["bodies/angular_acceleration"]
    momentum = (system.inertia @ omega[..., None])[..., 0]
    expected = (system.inertia @ omega_dot[..., None])[..., 0] + np.cross(omega, momentum)
    in_body = (np.swapaxes(rotation_matrix(record["bodies/orientation"]), -1, -2) @ torque[..., None])[..., 0]
    np.testing.assert_allclose(in_body, expected, atol=1e-9 * np.abs(expected).max())


def test_joints_without_friction_take_no_torque_about_what_they_leave_free(run):
    scene, _, record = run
    torque = record["joints/reaction_torque"]
    size = np.abs(torque).max()
    rotation = rotation_matrix(record["bodies/orientation"])
    spherical = torque[:, 3]
    assert np.abs(spherical).max() < 1e-10 * size
    axis = np.array(scene.joints[0].axes.first)  # the ground's
    assert np.abs(torque[:, 0] @ axis).max() < 1e-10 * size
    slide = np.array(scene.joints[2].axes.first)  # global at the start, fixed in body 1 of the joint
    local = rotation_matrix(np.array(scene.bodies[1].orientation)).T @ slide
    along = (rotation[:, 1] @ local[:, None])[..., 0]
    assert np.abs(np.sum(record["joints/reaction_force"][:, 2] * along, axis=1)).max() < 1e-9 * size


@pytest.mark.parametrize(
    ("path", "rate"),
    [
        ("bodies/position", "bodies/velocity"),
        ("bodies/velocity", "bodies/acceleration"),
        ("bodies/angular_velocity", "bodies/angular_acceleration"),
        ("markers/position", "markers/velocity"),
        ("markers/velocity", "markers/acceleration"),
        ("joints/coordinate", "joints/speed"),
    ],
)
def test_rates_are_rates(run, path, rate):
    """Central differences of order 4."""
    values, rates = run[2][path], run[2][rate]
    difference = (8.0 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4])) / (12.0 * STEP)
    np.testing.assert_allclose(difference, rates[2:-2], atol=1e-5 * np.abs(rates).max())


def test_energies(run):
    _, _, record = run
    total = record["diagnostics/kinetic_energy"] + record["diagnostics/potential_energy"]
    np.testing.assert_array_equal(record["diagnostics/total_energy"], total)
    np.testing.assert_allclose(record["diagnostics/energy_balance"], total - total[0], atol=1e-12)
    assert np.abs(record["diagnostics/energy_balance"]).max() < 1e-7


@pytest.mark.parametrize(
    "name",
    [
        "five_bar",
        "drum_brake",
        "split_coupler",
        *map(full, ("stewart_platform", "governor", "inline_four", "screw_press")),
    ],
)
def test_a_sample_is_the_same_in_blocks_of_any_length(name):
    """To the bit: a run that goes on from a mark has other blocks than one that did not stop."""
    scene = read_scene(mechanism(name), simulation={"duration": 0.05})
    system, state = assembled(scene)
    recorder = Recorder()
    simulate(system, state, settings_to_run(scene), recorder)
    samples, observer = join([block.samples for block in recorder.blocks]), Observer(system, state)
    whole, count = observer.at(samples), len(samples.t)
    for length in (1, 2, 7):
        parts = [observer.at(part_of(samples, first, first + length)) for first in range(0, count, length)]
        assert sum(len(part.samples.t) for part in parts) == count
        for path in whole:
            np.testing.assert_array_equal(np.concatenate([part[path] for part in parts]), whole[path], err_msg=path)


def part_of(samples: Samples, first: int, last: int) -> Samples:
    rows = slice(first, last)
    arrays = {
        field.name: getattr(samples, field.name)[rows]
        for field in fields(Samples)
        if field.name not in {"motion", "solved", "counters", "press", "rub"}
    }
    return Samples(
        **arrays,
        motion=samples.motion.chosen(rows),
        solved=lambda _: samples.multipliers[rows],
        counters={name: values[rows] for name, values in samples.counters.items()},
        press=None if samples.press is None else lambda: samples.press()[rows],
        rub=None if samples.rub is None else lambda: tuple(each[rows] for each in samples.rub()),
    )


def test_violations_are_split_into_lengths_and_angles(run):
    _, _, record = run
    largest = np.maximum(record["joints/violation_length"], record["joints/violation_angle"])
    np.testing.assert_array_equal(record["joints/violation"], largest)
    assert np.all(record["diagnostics/position_violation"] >= largest.max(axis=1))
    assert record["diagnostics/position_violation"].max() <= 1e-13
    assert record["diagnostics/acceleration_violation"].max() <= 1e-11
    assert np.all(record["joints/violation_angle"][:, 3] == 0.0)  # a ball joint has no rows in radians
