"""Implicit steps in the kernel at jumps in time, at events, and with laws that saturate or have no solution."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.errors import SimulationError
from mbproj.registry import implicit_integrators
from mbproj.scene import read_scene_text
from tests.integrate.event_scenes import rotor
from tests.kernel.scenes import needs_kernel, run

pytestmark = needs_kernel
both = pytest.mark.parametrize("integrator", implicit_integrators())


@both
@pytest.mark.parametrize("step", [{"step": 0.01}, {"tolerance": 1e-8}], ids=["fixed", "by error"])
def test_jumps_in_time(step, integrator):
    """A torque that jumps, on a body that a stiff spring holds: the slope that is carried on jumps with it."""
    text = rotor("10*sign(t - 0.313) - 2000*angle - 5*angle_dot")
    scene, keys = read_scene_text(text), {"duration": 0.8, "output_step": 0.1, "formulation": "reduced"}
    found, _ = run(scene, integrator=integrator, **step, **keys)
    exact, _ = run(scene, tolerance=1e-11, integrator="dop853", **keys)
    assert np.abs(found["joints/coordinate"] - exact["joints/coordinate"]).max() < 5e-6


@both
def test_recorded_at_a_jump_is_what_holds_there(integrator):
    """A sample at the time of a jump shows the acceleration after it, as explicit steps do."""
    text = rotor("sign(t - 0.3) + 1")
    keys = {"duration": 0.6, "step": 0.1, "formulation": "reduced"}
    found, exact = (run(read_scene_text(text), integrator=name, **keys)[0] for name in (integrator, "rk4"))
    np.testing.assert_allclose(found["bodies/angular_acceleration"], exact["bodies/angular_acceleration"], atol=1e-12)


@both
def test_events_in_the_state(integrator):
    """A stiff stop is met where an explicit method meets it."""
    text = rotor("3 - 50000*max(0, angle - 0.2)")
    keys = {"duration": 0.6, "output_step": 0.05, "formulation": "planar"}
    found, report = run(read_scene_text(text), tolerance=1e-7, integrator=integrator, **keys)
    exact, other = run(read_scene_text(text), tolerance=1e-11, integrator="dop853", **keys)
    assert report.events == other.events > 1
    assert np.abs(found["joints/coordinate"] - exact["joints/coordinate"]).max() < 1e-4


@both
def test_a_law_that_saturates(integrator):
    """Friction with a narrow tanh sticks: steps that are long beside its time constant of 1e-6 s."""
    scene = read_scene_text(rotor("5*sin(10*t) - 4*tanh(angle_dot/1e-4)"))
    keys = {"duration": 0.5, "output_step": 0.5, "formulation": "planar", "integrator": integrator}
    found, report = run(scene, tolerance=1e-6, **keys)
    fine, _ = run(scene, tolerance=1e-9, **keys)
    assert report.counters["steps"] < 600
    assert np.abs(found["joints/coordinate"] - fine["joints/coordinate"]).max() < 1e-5


@both
def test_an_unsolved_step_says_where(integrator):
    """A torque that grows with the speed, so that no finite acceleration solves a long step. A rotor has no singular
    position, and none is blamed."""
    with pytest.raises(SimulationError, match=r"at body 'rotor': Newton's method did not solve the eq") as raised:
        run(read_scene_text(rotor("1 + 1e6*sinh(50*angle_dot)")), duration=2.0, step=0.5, integrator=integrator)
    assert "singular" not in raised.value.cause
