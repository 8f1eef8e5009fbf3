"""Fixed implicit steps that Newton's method does not solve are made in halves."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.errors import SimulationError
from mbproj.integrate import simulate
from mbproj.integrate.formulations.choice import choose
from mbproj.registry import implicit_integrators
from mbproj.runs import notes_on
from mbproj.scene import Settings, read_scene, read_scene_text
from tests.integrate.event_scenes import rotor
from tests.kernel.scenes import assembled, needs_kernel
from tests.support import ROOT, Recorder

#: A belt of 0.1 m/s carries a mass away; it sticks within 1e-5 m/s.
BELT = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {mass: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0]}}
forces:
  friction:
    type: linear_spring_damper
    joint: rail
    force: "-100*displacement - 5*tanh((displacement_dot - 0.1)/5e-6)"
"""
both = pytest.mark.parametrize("integrator", implicit_integrators())


def governor():
    return read_scene(ROOT / "mechanisms/governor.yaml", {"stiffness": "1e8", "damping": "1e5"})


def run(scene, **keys):
    """(recorder, report)."""
    recorder = Recorder()
    return recorder, simulate(*assembled(scene), Settings(**keys), recorder)


@both
@pytest.mark.parametrize("formulation", ["full", "reduced", "planar"])
def test_a_mass_that_comes_to_stick(formulation, integrator):
    """The samples are where they were; the belt takes the mass along, and slow steps find where it sticks."""
    keys = {"duration": 0.1, "output_step": 0.02, "integrator": integrator, "formulation": formulation}
    found, report = run(read_scene_text(BELT), step=0.005, **keys)
    np.testing.assert_allclose(found["time"], 0.02 * np.arange(6), rtol=0.0, atol=1e-15)
    halvings = report.counters["rejected_steps"]
    assert 3 <= halvings <= 25
    assert report.counters["steps"] <= 20 + halvings
    assert f"{halvings} times, for want of " in report.halved
    assert any("fixed steps were halved" in note.text and "Newton's method" in note.text for note in notes_on(report))
    fine, _ = run(read_scene_text(BELT), tolerance=1e-8, **keys | {"formulation": "reduced", "integrator": "radau5"})
    assert np.abs(found["bodies/position"] - fine["bodies/position"]).max() < 2e-4


@both
@pytest.mark.parametrize("formulation", ["full", "reduced"])
def test_stiff_springs_at_a_coarse_step(formulation, integrator):
    """The governor turns by more than a radian in a step, and its joints stay closed."""
    _, report = run(governor(), duration=0.1, step=0.1, output_step=0.1, integrator=integrator, formulation=formulation)
    assert report.counters["steps"] - 1 == report.counters["rejected_steps"] > 0
    assert report.halved
    assert report.position_violation.value < 1e-12


@needs_kernel
def test_the_force_that_is_the_cause_is_named():
    _, report = run(read_scene_text(BELT), duration=0.1, step=0.01, output_step=0.1, integrator="esdirk4")
    assert "for want of force 'friction'" in report.halved


@both
@pytest.mark.parametrize("formulation", ["full", "reduced"])
def test_what_halving_does_not_mend(formulation, integrator):
    """A torque that grows with the speed without bound."""
    with pytest.raises(SimulationError, match=r"at (body 'rotor'|force 'push'): Newton's method did not") as caught:
        keys = {"integrator": integrator, "formulation": formulation}
        run(read_scene_text(rotor("1 + 1e6*sinh(50*angle_dot)")), duration=2.0, step=0.5, output_step=0.5, **keys)
    assert "nor did it those of its parts, down to 0.0" in caught.value.cause
    assert "smooth it; or try --integrator dop853" in caught.value.hint


@needs_kernel
@both
@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_a_run_goes_on_between_two_parts_of_a_step(formulation, integrator):
    """With the bits of one run, and its counts."""
    system, state = assembled(read_scene_text(BELT))
    settings = Settings(duration=0.05, step=0.01, output_step=0.01, integrator=integrator, formulation=formulation)
    compiled = choose(system, state, settings).compiled
    whole = compiled.run(state, settings)
    whole.advance(1000, 60.0)
    parts = set()
    for attempts in range(3, 21):
        begun, rest = compiled.run(state, settings), compiled.run(state, settings)
        begun.keeps_marks = True
        begun.advance(1000, 60.0, attempts)
        mark = begun.mark()
        parts.add(mark["part"])
        rest.resume(mark)
        rest.advance(1000, 60.0)
        np.testing.assert_array_equal(rest.standing["y"], whole.standing["y"])
        np.testing.assert_array_equal(rest.counters[:3], whole.counters[:3])
        assert rest.halved == whole.halved
    assert len(parts) > 3
