"""Implicit steps in the full formulation: their orders in space, closed joints, stiff forces of any size, events,
and redundant rows."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from mbproj.integrate import simulate
from mbproj.registry import integrators
from mbproj.scene import ProjectionSettings, Settings, read_scene, read_scene_text
from tests.integrate.event_scenes import bounce, contact_times, height_at
from tests.kernel.scenes import assembled, needs_kernel
from tests.support import ROOT, Recorder

IMPLICIT = ("esdirk4", "radau5")
#: A disk that spins and sways on a universal joint, with a spring, a damper and a force that does work.
SPINNING = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  arm: {mass: 1, inertia: [0.05, 0.1, 0.08], position: [0.3, 0, 0], angular_velocity: [0, 1, 2]}
  disk: {mass: 2, inertia: [0.2, 0.15, 0.1], position: [0.7, 0.1, 0], angular_velocity: [15, 0, 3]}
joints:
  pin: {type: universal, bodies: [ground, arm], location: [0, 0, 0], axes: [[0, 0, 1], [0, 1, 0]]}
  ball: {type: spherical, bodies: [arm, disk], location: [0.6, 0, 0]}
forces:
  spring: {type: spring_damper, points: {ground: [0, 0, 1], disk: [0.8, 0.2, 0]}, stiffness: 50, damping: 2}
  push: {type: force, body: disk, location: [0.7, 0.3, 0], force: [3*sin(5*t), 1, 2], axes: body}
"""


def run(scene, projection="gpopm", **keys):
    """(recorder, report)."""
    recorder = Recorder()
    if keys.get("integrator") in IMPLICIT:
        keys = {"formulation": "full"} | keys
    report = simulate(*assembled(scene), Settings(projection=ProjectionSettings(projection), **keys), recorder)
    return recorder, report


def of(recorder, name):
    return np.concatenate([getattr(block.samples, name) for block in recorder.blocks])


def off(one, other, name):
    return float(np.abs(of(one, name) - of(other, name)).max())


@cache
def spinning():
    """The reference, at 1e-12."""
    scene = read_scene_text(SPINNING)
    return run(scene, duration=0.1, tolerance=1e-12, integrator="dop853", output_step=0.02, formulation="full")[0]


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_orders_in_space(integrator):
    """Of coordinates, velocities, work and dissipation, with gyroscopic moments and rotations about changing axes."""
    steps = (0.02, 0.01)
    runs = [
        run(read_scene_text(SPINNING), duration=0.1, step=h, output_step=0.02, integrator=integrator) for h in steps
    ]
    for name in ("q", "v", "work"):
        coarse, fine = (off(recorder, spinning(), name) for recorder, _ in runs)
        assert np.log2(coarse / fine) == pytest.approx(integrators()[integrator].order, abs=0.15)
    for _, report in runs:
        assert report.position_violation.value <= 1e-13
        assert report.velocity_violation.value <= 1e-13
        assert report.formulation == "full"


@pytest.mark.parametrize("method", ["none", "baumgarte", "gopm", "mass-orthogonal", "mmopm", "gpopm", "gpopm-pinv"])
def test_every_projection(method):
    scene = read_scene_text(SPINNING)
    own = {"baumgarte": {"gains": (20.0, 20.0)}, "mass-orthogonal": {"alpha": 1e6}, "mmopm": {"alpha": 1e6}}
    recorder = Recorder()
    projection = ProjectionSettings(method, **own.get(method, {}))
    simulate(
        *assembled(scene), Settings(projection=projection, duration=0.1, step=0.02, integrator="esdirk4"), recorder
    )
    assert off(recorder, spinning(), "q") < 2e-6


@needs_kernel
@pytest.mark.parametrize("integrator", IMPLICIT)
@pytest.mark.parametrize("softness", ["0.1", "1e-5"])
def test_a_bushing_of_any_stiffness_takes_large_steps(integrator, softness):
    """The coupler of a four-bar in two halves, held by 1e6 and by 1e10 N/m, against DOP853's 1,000 and 90,000 steps a
    second; joints stay closed."""
    scene = read_scene(ROOT / "mechanisms" / "split_coupler.yaml", {"softness": softness})
    reference, _ = run(scene, duration=0.1, tolerance=1e-10, integrator="dop853", output_step=0.05)
    found, report = run(scene, duration=0.1, step=0.01, integrator=integrator, output_step=0.05)
    assert off(found, reference, "q") < {"esdirk4": 1e-4, "radau5": 1e-5 if softness == "0.1" else 1e-7}[integrator]
    assert report.position_violation.value <= 1e-13
    assert report.velocity_violation.value <= 1e-13


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_a_mass_bounces_on_a_spring_as_in_closed_form(integrator):
    """Steps end at the events in the state."""
    recorder, report = run(
        read_scene_text(bounce()), duration=0.5, tolerance=1e-8, integrator=integrator, output_step=0.1
    )
    height = recorder["joints/coordinate"][:, 0]
    np.testing.assert_allclose(height, [height_at(t) for t in recorder["time"]], atol=1e-7)
    assert report.events == len([t for t in contact_times(9) if t < 0.5])


def test_redundant_rows():
    """A Bennett linkage, with three rows that follow from the others."""
    scene = read_scene(ROOT / "mechanisms" / "bennett.yaml")
    reference, _ = run(scene, duration=0.1, tolerance=1e-11, integrator="dop853", output_step=0.05)
    found, report = run(scene, duration=0.1, step=0.025, integrator="radau5", output_step=0.05)
    assert off(found, reference, "q") < 1e-6
    assert report.position_violation.value <= 1e-13


def test_a_massless_body():
    """A coupler without mass and inertia, which its joints hold."""
    scene = read_scene(ROOT / "mechanisms" / "massless_coupler.yaml")
    reference, _ = run(scene, duration=0.1, tolerance=1e-11, integrator="dop853", output_step=0.05)
    found, report = run(scene, duration=0.1, step=0.025, integrator="esdirk4", output_step=0.05)
    assert off(found, reference, "q") < 5e-5
    assert report.position_violation.value <= 1e-13


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_samples_within_a_step(integrator):
    """By the continuous extension: closed, and at a tolerance of 1e-6 as near to the reference as the steps are; so are
    accelerations and multipliers, with a power of h less."""
    found, report = run(
        read_scene_text(SPINNING), duration=0.1, tolerance=1e-6, integrator=integrator, output_step=0.02
    )
    assert report.counters["steps"] < 20
    assert off(found, spinning(), "q") < 1e-6
    assert off(found, spinning(), "acceleration") < 1e-3


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_forces_within_a_long_step_are_those_of_their_time(integrator):
    """What bears a load that swings while nothing moves: steps see nothing of it, samples within them do."""
    scene = read_scene_text(
        "mbproj: 1\ngravity: [0, 0, 0]\nbodies: {block: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}\n"
        "joints: {pin: {type: revolute, bodies: [ground, block], location: [0, 0, 0], axis: [1, 0, 0]}}\n"
        "forces: {load: {type: force, body: block, location: [0, 0, 0], force: [8*sin(3*t), 0, 0]}}\n"
    )
    found, report = run(scene, duration=2, tolerance=1e-6, integrator=integrator, output_step=0.02)
    assert report.counters["steps"] < 20
    borne = np.abs(of(found, "multipliers")).max(axis=1)
    np.testing.assert_allclose(borne, np.abs(8.0 * np.sin(3.0 * of(found, "t"))), atol=1e-12)


def test_what_does_not_converge_is_named():
    """With steps in which the disk turns too far: a stiff force, or else a body."""
    for stiffness, where in ((50, "force 'spring'"), (0, "body 'disk'")):
        text = SPINNING.replace("stiffness: 50, damping: 2", f"stiffness: {stiffness}, damping: 0")
        _, report = run(read_scene_text(text), duration=0.5, step=0.5, integrator="radau5")
        assert where in report.halved
