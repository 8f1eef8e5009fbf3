"""Derivatives are functions of (t, state, row set), in NumPy and in the kernel; the policy is what a run remembers."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mbproj import Scene, read_scene, settings_to_run
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.equations.constraints import jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.equations.motions import NO_DRIVE
from mbproj.equations.rank.row_policy import RowPolicy, RowSet
from mbproj.kernel import core
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.motion.formulations.choice import choose
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.formulations.reduced import InPlane, Reduced
from mbproj.motion.formulations.redundant_rows import settle_rows
from mbproj.motion.numpy_loop import march
from mbproj.motion.report import Tally
from mbproj.motion.steppers.tableau import load_tableau
from mbproj.motion.time_events import kernel_tableau
from mbproj.scene.scene import read_scene_text
from scripts.large_mechanisms.scenes import scissor_grid
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.closed_forms import PARALLELOGRAM
from tests.support import REDUNDANT, ROOT, assembled

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
    system, state = assembled(scene)
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
    system, state = assembled(scene)
    assert choose(system, state, settings_to_run(scene)).compiled is not None
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]


@needs_kernel
def test_a_walk_that_enters_a_singular_branch_tells_the_rows_of_the_other():
    """Where the links of the governor reach the height of the pins, its collar may stay there while the arms turn: most
    poses of the walk are singular."""
    text = (ROOT / "mechanisms" / "governor.yaml").read_text()
    scene = read_scene_text(text.replace("speed: 0}", "speed: 23}"), "scene.yaml", {"link": "98 mm"}, {})
    system, state = assembled(scene)
    rows = choose(system, state, settings_to_run(scene)).compiled.model.rows
    assert rows.redundant == 0 and min(rows.pivots) > 1e-3 and rows.even > 1e-3


# Derivatives are functions of (t, state, rows left out), and these of the pose at which a step begins.

#: The parallelogram at an angle from its singular pose, closed with redundant rows or without, shipped mechanisms.
SCENES_IN_KERNEL = (
    (1e-6, "point_on_line"),
    (1e-3, "point_on_line"),
    (1e-6, "revolute"),
    *((name, "") for name in (*REDUNDANT, "inline_four", "planar_four_bar", "spatial_slider_crank")),
)
#: Shipped mechanisms whose rows are independent at every pose, and whose masses leave S its digits.
REGULAR_IN_KERNEL = ("five_bar", "planar_four_bar", "double_pendulum", "heavy_top", "delta_robot", "hooke_shaft")
FOREVER = 100.0


def scene_of(name: str | float, closure: str = "point_on_line") -> Scene:
    """A shipped mechanism, or the parallelogram at an angle."""
    if isinstance(name, str):
        return read_scene(ROOT / "mechanisms" / f"{name}.yaml")
    return read_scene_text(PARALLELOGRAM.replace("CLOSURE", closure), "scene.yaml", {"start": name})


def compiled_of(scene: Scene, form: str = "reduced"):
    """In the kernel, with its redundant rows counted, and its start."""
    system, state = assembled(scene)
    if form == "reduced":
        compiled: Compiled = Reduced(core(), system)
    else:
        plane = planar_reduction(system, state.q)
        assert isinstance(plane, Plane)
        compiled = InPlane(core(), system, plane)
    settle_rows(compiled, state)
    return compiled, state


def kernel_states_near(compiled: Compiled, state, count: int = 12) -> list[tuple[float, np.ndarray]]:
    """States at small distances from one, some so small that a singular pose stays one."""
    rng, found = np.random.default_rng(7), []
    y = compiled.state(state.q, state.v)
    for k in range(count):
        found.append((0.01 * k, y + 10.0 ** rng.uniform(-9.0, -2.0) * rng.normal(size=y.shape)))
    return found


@needs_kernel
@pytest.mark.parametrize(("name", "closure"), SCENES_IN_KERNEL)
def test_derivatives_of_the_kernel_have_the_same_bits_in_any_order_of_calls(name, closure):
    compiled, state = compiled_of(scene_of(name, closure))
    equations, cases = compiled.equations(), kernel_states_near(compiled, state)
    rows = equations.left_out(compiled.state(state.q, state.v), state.t)
    first = [equations.derivative(y, t, left_out=rows) for t, y in cases]
    assert any(slope is not None for slope in first)
    rng = np.random.default_rng(3)
    for k in [*rng.permutation(len(cases)), *rng.integers(len(cases), size=20)]:
        # Other states, corrections and choices of rows in between have no say.
        t, y = cases[int(rng.integers(len(cases)))]
        equations.derivative(y, t, left_out=rows)
        equations.corrected(y, t)
        equations.left_out(y, t)
        equations.dependent_rows(y, t, 1e-8)
        np.testing.assert_array_equal(equations.derivative(cases[k][1], cases[k][0], left_out=rows), first[k])


@needs_kernel
def test_some_of_these_states_leave_rows_out_in_the_kernel():
    """Otherwise the test above would be about nothing."""
    for closure in ("point_on_line", "revolute"):
        compiled, state = compiled_of(scene_of(1e-6, closure))
        equations = compiled.equations()
        equations.derivative(compiled.state(state.q, state.v))
        assert equations.nearness == 0.0


def beside(scene: Scene, other: Scene) -> Scene:
    """A scene with the bodies and joints of another beside its own."""
    named = {"ground": "ground", **{body.name: f"{body.name} beside" for body in other.bodies}}
    bodies = [replace(body, name=named[body.name]) for body in other.bodies]
    joints = [
        replace(joint, name=f"{joint.name} beside", bodies=tuple(named[body] for body in joint.bodies))
        for joint in other.joints
    ]
    return replace(scene, bodies=(*scene.bodies, *bodies), joints=(*scene.joints, *joints))


@needs_kernel
@pytest.mark.parametrize("closure", ["point_on_line", "revolute"])
def test_a_mechanism_does_not_change_where_a_much_larger_one_beside_it_is_near_singular(closure):
    """Of a parallelogram of 20 µm, squared distances of rows from the others are 5e-9 of those of the larger one at
    every pose: where only less than 1e-8 counts as dependent, its rows would be left out, and its bars part."""
    text = PARALLELOGRAM.replace("CLOSURE", closure)
    small = read_scene_text(text, "f", {"start": 1.0, "crank": 2e-5, "coupler": 5e-5})
    regular, singular = (beside(read_scene_text(text, "f", {"start": start}), small) for start in (-0.6, 1e-5))
    compiled, _ = compiled_of(regular)
    _, state = assembled(singular)
    equations = compiled.equations()
    slope = equations.derivative(compiled.state(state.q, state.v))
    assert equations.nearness < 1e-8
    alone, state = compiled_of(small)
    np.testing.assert_allclose(slope[3:], alone.equations().derivative(alone.state(state.q, state.v)), atol=1e-14)


@needs_kernel
@pytest.mark.parametrize("name", REGULAR_IN_KERNEL)
def test_regular_mechanisms_never_enter_the_robust_code(name):
    scene = scene_of(name)
    compiled, state = compiled_of(scene, "plane" if name in ("five_bar", "planar_four_bar") else "reduced")
    run = compiled.run(state, Settings(duration=0.1, step=0.01))
    run.advance(100, FOREVER)
    assert run.outcome.status == core().Status.finished
    assert run.close_looks == 0


@needs_kernel
def test_pivots_that_masses_make_small_at_every_pose_are_no_singular_pose():
    """Of the slider-crank 0.02 to 0.05 of a diagonal entry, wherever it goes: each stage was looked at closely."""
    compiled, state = compiled_of(read_scene(ROOT / "mechanisms" / "spatial_slider_crank.yaml"))
    assert compiled.model.rows.redundant == 0
    run = compiled.run(state, Settings(duration=1.0, step=0.001))
    first = compiled.equations().pivots(compiled.state(state.q, state.v), state.t, [])[0]
    assert min(first) < 0.05
    run.advance(2000, FOREVER)
    assert run.outcome.status == core().Status.finished
    assert run.close_looks == 0


def from_sample(compiled: Compiled, block, at: int, step: float, steps: int):
    """A run of so many steps of RK4 and GPOPM from a recorded sample."""
    return compiled.core.Run(
        compiled.model,
        kernel_tableau(compiled.core, load_tableau("rk4"), kinematic=False),
        compiled.projection(ProjectionSettings()),
        compiled.core.Steps.fixed(float(block["t"][at]), steps * step, step, steps, 1),
        np.ascontiguousarray(block["y"][at]),
        np.rint(block["angles"][at] / (2.0 * np.pi)).astype(np.int64),
    )


#: A singular pose after 0.3 s or none; a step of a power of 1/2, so that times have the same bits from another start.
CONTINUED = ((-0.3, "point_on_line"), (-0.3, "revolute"), ("bennett", ""), ("locomotive", ""), ("n_four_bar", ""))


@needs_kernel
@pytest.mark.parametrize(("name", "closure"), CONTINUED)
def test_a_run_goes_on_from_a_mark_with_the_bits_of_the_long_run(name, closure):
    compiled, state = compiled_of(scene_of(name, closure))
    step, steps, part = 1.0 / 64.0, 40, 22
    run = compiled.run(state, Settings(duration=steps * step, step=step))
    run.keeps_marks = True
    before = run.advance(part + 1, FOREVER)
    assert len(before["t"]) == part + 1
    mark = run.mark()
    after = run.advance(steps, FOREVER)
    resumed = compiled.run(state, Settings(duration=steps * step, step=step))
    resumed.resume(mark)
    again = resumed.advance(steps + 1, FOREVER)
    assert len(again["t"]) == steps - part
    for key in ("t", "y", "acceleration", "multipliers", "angles"):
        np.testing.assert_array_equal(again[key], after[key])
    assert resumed.left_out == run.left_out


@needs_kernel
@pytest.mark.parametrize("name", ["bricard", "bennett", "stewart_platform", "n_four_bar", "locomotive"])
def test_a_run_that_starts_at_a_recorded_state_is_the_long_one(name):
    """To the bit: off the constraints, inside Runge-Kutta's stages, other rows are another differential equation. Runs
    that remembered the poses passed parted by its truncation error, here 1e-3 to 1e-6."""
    compiled, state = compiled_of(scene_of(name))
    step, steps = 1.0 / 128.0, 128
    long = compiled.run(state, Settings(duration=steps * step, step=step)).advance(1000, FOREVER)
    for at in (9, 35, 70, 101):
        again = from_sample(compiled, long, at, step, steps - at).advance(1000, FOREVER)
        np.testing.assert_array_equal(again["y"], long["y"][at:])


@needs_kernel
def test_a_step_on_which_the_rows_held_come_to_depend_on_each_other_takes_others():
    """Any 17 of the 20 rows of the linkage say the same where they are independent; those without these three are not
    at t = 0.746 s, where the second step ends. A row left out there would be a constraint less."""
    compiled, state = compiled_of(scene_of("bennett"))
    block = compiled.run(state, Settings(duration=179 / 256, step=1 / 256)).advance(1000, FOREVER)
    step = (0.74598875 - float(block["t"][-1])) / 2
    bad, ends = [3, 13, 16], []
    last = block["y"][-1].reshape(compiled.system.bodies, -1)
    pivots, even = compiled.equations().pivots(last, float(block["t"][-1]), bad)
    for rows in (compiled.model.rows, core().UsualRows(3, bad, [0.01 * pivot for pivot in pivots], 0.01 * even)):
        compiled.model.rows = rows
        run = from_sample(compiled, block, -1, step, 3)
        assert run.advance(2, FOREVER)["t"].size == 2
        assert run.left_out == rows.left_out
        ends.append(run.advance(1, FOREVER)["y"][-1])
    assert run.left_out != bad
    np.testing.assert_allclose(ends[1], ends[0], atol=2e-3)  # two RK4 steps of 23 ms


@needs_kernel
@pytest.mark.parametrize(
    ("name", "closure", "form"),
    [
        (-0.3, "point_on_line", "reduced"),
        (-0.3, "revolute", "reduced"),
        (-0.3, "revolute", "plane"),
        ("n_four_bar", "", "reduced"),
    ],
)
def test_recording_has_no_say_in_the_steps_of_the_kernel(name, closure, form):
    """The same bits at the end, with samples inside the steps and without, also past a singular pose."""
    ends = []
    for every in (0.005, 0.6):
        compiled, state = compiled_of(scene_of(name, closure), form)
        settings = Settings(duration=0.6, tolerance=1e-5, integrator="dopri5", output_step=every)
        run = compiled.run(state, settings)
        block = run.advance(1000, FOREVER)
        assert run.outcome.status == core().Status.finished
        ends.append((block["y"][-1], run.left_out))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    assert ends[0][1] == ends[1][1]


@needs_kernel
@pytest.mark.parametrize("rows", [[3, 3, 4], [4, 3], [-1], [99]])
def test_rows_from_elsewhere_are_checked(rows):
    compiled, state = compiled_of(scene_of("bennett"))
    y, equations = compiled.state(state.q, state.v), compiled.equations()
    assert equations.derivative(y, left_out=[9, 14, 18]) is not None
    with pytest.raises(ValueError, match=r"^left_out holds an index out of range"):
        equations.derivative(y, left_out=rows)
    with pytest.raises(ValueError, match=r"^left_out holds an index out of range"):
        compiled.model.rows = core().UsualRows(3, rows)


@needs_kernel
def test_usual_pivots_are_positive():
    with pytest.raises(ValueError, match=r"^rows have a pivot that is not positive"):
        core().UsualRows(3, [], [0.0])


@needs_kernel
@pytest.mark.parametrize("cells", [5, 8])
def test_steps_of_a_large_mechanism_hold_its_usual_rows(cells):
    """A grid of scissors has thousands of pivots, and some are always far from what they are at other poses: each step
    looked for its rows anew, at the cost of twenty steps, and found the same."""
    compiled, state = compiled_of(read_scene_text(scissor_grid(cells)))
    run = compiled.run(state, Settings(duration=0.02, step=0.001))
    run.advance(100, FOREVER)
    assert run.outcome.status == core().Status.finished
    assert run.close_looks == 0
    assert run.left_out == compiled.model.rows.left_out
    assert len(run.left_out) == {5: 355, 8: 907}[cells]


@needs_kernel
@needs_kernel
@pytest.mark.parametrize("method", ["gpopm", "gopm", "mass-orthogonal"])
def test_usual_pivots_are_those_of_the_rows_that_a_run_with_the_method_has(method):
    """A penalty keeps all joints in S: pivots that were found without them were read beyond their end, and equal input
    came out in two ways."""
    system, state = assembled(read_scene(ROOT / "mechanisms" / "spatial_slider_crank.yaml"))
    compiled, projection = Reduced(core(), system), ProjectionSettings(method=method)
    settle_rows(compiled, state, projection)
    pivots, _ = compiled.equations(projection).pivots(compiled.state(state.q, state.v), state.t, [])
    assert (len(pivots), len(compiled.model.rows.pivots)) == ((17, 0) if method == "mass-orthogonal" else (7, 7))
