"""Derivatives are functions of (t, state, row set), and the policy is what a run remembers."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run
from mbproj.dynamics import NO_DRIVE, RowPolicy, RowSet, jacobian, pose_of
from mbproj.integrate.formulations.choice import choose
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.numpy_loop import march
from mbproj.integrate.reporting.tally import Tally
from mbproj.scene import read_scene_text
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.closed_forms import PARALLELOGRAM
from tests.support import REDUNDANT, ROOT

#: Chains of loops that pass singular poses, rows that follow from others, and a scene with neither.
SCENES = (
    1e-6,
    1e-3,
    full("inline_four"),
    *["n_four_bar", "bennett", "locomotive", "planar_four_bar", "spatial_slider_crank"],
)
#: Shipped mechanisms whose rows are independent at every pose of their first steps.
REGULAR = ("five_bar", "spatial_slider_crank", "double_pendulum", "heavy_top", "stewart_platform", "delta_robot")


def formulation_of(name, **options):
    """Of a shipped mechanism, or of the parallelogram at an angle."""
    keys = {"formulation": "full", "step": "10 ms", "output_step": "10 ms", "duration": "0.1", "integrator": "rk4"}
    if "tolerance" in options:
        del keys["step"]
    keys |= options
    scene = (
        read_scene(ROOT / "mechanisms" / f"{name}.yaml", {}, keys)
        if isinstance(name, str)
        else read_scene_text(PARALLELOGRAM.replace("CLOSURE", "point_on_line"), "scene.yaml", {"start": name}, keys)
    )
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    settings = settings_to_run(scene)
    return FullFormulation.of(system, state, settings, REDUNDANT.get(name, 0)), state


def come_from_afar(formulation):
    """The parallelogram has been at -1 rad, far from its singular pose."""
    far, start = formulation_of(-1.0)
    formulation.policy.advance(jacobian(far.system, pose_of(start.q)))


def states_near(formulation, state, count=12):
    """States at small distances from one, some so small that a singular pose stays one."""
    rng = np.random.default_rng(7)
    for k in range(count):
        size = 10.0 ** rng.uniform(-9.0, -2.0)
        q = state.q + size * rng.normal(size=state.q.shape)
        v = state.v + size * rng.normal(size=state.v.shape)
        yield 0.01 * k, formulation.layout.vector_of({"positions": q, "velocities": v})


@pytest.mark.parametrize("name", SCENES)
def test_derivatives_have_the_same_bits_in_any_order_of_calls(name):
    formulation, state = formulation_of(name)
    if not isinstance(name, str):
        come_from_afar(formulation)
    formulation.policy.advance(jacobian(formulation.system, pose_of(state.q)))
    cases = list(states_near(formulation, state))
    first = [formulation.derivative(t, y) for t, y in cases]
    rng = np.random.default_rng(3)
    for k in [*rng.permutation(len(cases)), *rng.integers(len(cases), size=20)]:
        # A stage of a step that looks at the pose, and a projection in between, have no say.
        other = cases[int(rng.integers(len(cases)))]
        formulation.watched_derivative(*other)
        formulation.project_between(*other)
        np.testing.assert_array_equal(formulation.derivative(*cases[k]), first[k])


def test_some_of_these_states_leave_rows_out():
    """Otherwise the test above would be about nothing."""
    formulation, state = formulation_of(1e-6)
    come_from_afar(formulation)
    formulation.policy.advance(jacobian(formulation.system, pose_of(state.q)))
    held = formulation.policy.rows.to_move(pose_of(state.q), NO_DRIVE, state.v)
    assert held.left_out is not None
    assert held.nearness < 0.1


@pytest.mark.parametrize("name", REGULAR)
def test_regular_mechanisms_never_combine_rows(name, monkeypatch):
    entered = []
    monkeypatch.setattr(RowSet, "_combined", lambda *arguments: entered.append(arguments))
    formulation, state = formulation_of(name, duration="0.05")
    assert len(list(march(formulation, state, Tally()))) > 1
    assert not entered


def test_what_is_saved_is_plain_data_and_restored_goes_on_the_same():
    """Of a mechanism that passes near a singular pose: the same answers as the policy that was never saved."""
    formulation, state = formulation_of(1e-3)
    system, rng = formulation.system, np.random.default_rng(5)
    lived = RowPolicy(system)
    poses = [state.q + 10.0 ** rng.uniform(-6, -1) * rng.normal(size=state.q.shape) for _ in range(10)]
    for k, q in enumerate(poses[:5]):
        lived.see(rng.uniform())
        lived.advance(jacobian(system, pose_of(q)))
        lived.keep(np.full(system.constraints, float(k)))
    restored = RowPolicy(system)
    restored.restore(json.loads(json.dumps(lived.save())))
    for q in poses[5:]:
        C_q = jacobian(system, pose_of(q))
        held = [policy.rows.to_move(pose_of(q), NO_DRIVE, state.v) for policy in (lived, restored)]
        np.testing.assert_array_equal(held[0].C_q, held[1].C_q)
        np.testing.assert_array_equal(lived.rows.multipliers, restored.rows.multipliers)
        assert lived.advance(C_q) == restored.advance(C_q)
        assert (lived.nearest, lived.rows.watching) == (restored.nearest, restored.rows.watching)
    assert lived.save() == restored.save()


@pytest.mark.parametrize("name", [-0.3, full("n_four_bar")])
def test_recording_has_no_say_in_the_steps(name):
    """The same bits at the end, with samples inside the steps and without, also past a singular pose."""
    ends = []
    for every in ("5 ms", "0.6"):
        options = {"duration": "0.6", "tolerance": "1e-5", "integrator": "dopri5"}
        formulation, state = formulation_of(name, output_step=every, **options)
        ends.append(list(march(formulation, state, Tally()))[-1])
    np.testing.assert_array_equal(ends[0].state.q, ends[1].state.q)
    np.testing.assert_array_equal(ends[0].state.v, ends[1].state.v)


@needs_kernel
def test_a_walk_past_speeds_that_overflow_tells_the_rows(recwarn):
    """A joint 4e11 m away: a push of the walk turns its body so fast that the squares of its speeds overflow."""
    text = (ROOT / "mechanisms" / "quarter_car.yaml").read_text()
    far = text.replace("location: [0, 0.4, 0.2175]", "location: [0, 4e11, 0.2175]")
    assert far != text
    scene = read_scene_text(far, "scene.yaml", {}, {})
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    assert choose(system, state, settings_to_run(scene)).compiled is not None
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]


@needs_kernel
def test_a_walk_that_enters_a_singular_branch_tells_the_rows_of_the_other():
    """Where the links of the governor reach the height of the pins, its collar may stay there while the arms turn: most
    poses of the walk are singular."""
    text = (ROOT / "mechanisms" / "governor.yaml").read_text()
    scene = read_scene_text(text.replace("speed: 0}", "speed: 23}"), "scene.yaml", {"link": "98 mm"}, {})
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    rows = choose(system, state, settings_to_run(scene)).compiled.model.rows
    assert rows.redundant == 0 and min(rows.pivots) > 1e-3 and rows.even > 1e-3
