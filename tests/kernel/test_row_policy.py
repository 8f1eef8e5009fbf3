"""Derivatives are functions of (t, state, row set), and the policy is what a run remembers between its steps."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.formulations.compiled import _tableau as tableau_of
from mbproj.integrate.formulations.planar import InPlane
from mbproj.integrate.formulations.reduced import Reduced
from mbproj.integrate.formulations.redundant_rows import count_redundant
from mbproj.integrate.steppers.tableau import load_tableau
from mbproj.kernel import core
from mbproj.model.planar import Plane, planar_reduction
from mbproj.scene import read_scene, read_scene_text
from mbproj.scene.records import ProjectionSettings, Scene, Settings
from tests.kernel.scenes import assembled, needs_kernel
from tests.mechanisms.exact.parallelogram import PARALLELOGRAM
from tests.support import REDUNDANT, ROOT

pytestmark = needs_kernel
#: The parallelogram at an angle from its singular pose, closed with redundant rows or without, shipped mechanisms.
SCENES = (
    (1e-6, "point_on_line"),
    (1e-3, "point_on_line"),
    (1e-6, "revolute"),
    *((name, "") for name in (*REDUNDANT, "inline_four", "planar_four_bar", "spatial_slider_crank")),
)
#: Shipped mechanisms whose rows are independent at every pose, and whose masses leave S its digits.
REGULAR = ("five_bar", "planar_four_bar", "double_pendulum", "heavy_top", "delta_robot", "hooke_shaft")
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
    compiled.model.redundant = count_redundant(compiled, state) or 0
    return compiled, state


def rows_from_afar(compiled: Compiled, state, name: str | float, closure: str):
    """The rows that a run began with, of the parallelogram far from its singular pose."""
    if isinstance(name, str):
        return compiled.equations().rows(compiled.state(state.q, state.v), state.t)
    far = assembled(scene_of(-1.0, closure))[1]
    return compiled.equations().rows(compiled.state(far.q, far.v), far.t)


def states_near(compiled: Compiled, state, count: int = 12) -> list[tuple[float, np.ndarray]]:
    """States at small distances from one, some so small that a singular pose stays one."""
    rng, found = np.random.default_rng(7), []
    y = compiled.state(state.q, state.v)
    for k in range(count):
        found.append((0.01 * k, y + 10.0 ** rng.uniform(-9.0, -2.0) * rng.normal(size=y.shape)))
    return found


@pytest.mark.parametrize(("name", "closure"), SCENES)
def test_derivatives_have_the_same_bits_in_any_order_of_calls(name, closure):
    compiled, state = compiled_of(scene_of(name, closure))
    rows = json.loads(json.dumps(rows_from_afar(compiled, state, name, closure)))
    equations, cases = compiled.equations(), states_near(compiled, state)
    first = [equations.derivative(y, t, rows=rows) for t, y in cases]
    assert any(slope is not None for slope in first)
    rng = np.random.default_rng(3)
    for k in [*rng.permutation(len(cases)), *rng.integers(len(cases), size=20)]:
        # Other states, corrections and choices of rows in between have no say.
        t, y = cases[int(rng.integers(len(cases)))]
        equations.derivative(y, t, rows=rows)
        equations.corrected(y, t)
        equations.rows(y, t)
        equations.dependent_rows(y, t, 1e-8)
        np.testing.assert_array_equal(equations.derivative(cases[k][1], cases[k][0], rows=rows), first[k])


def test_some_of_these_states_leave_rows_out():
    """Otherwise the test above would be about nothing."""
    for closure in ("point_on_line", "revolute"):
        compiled, state = compiled_of(scene_of(1e-6, closure))
        equations = compiled.equations()
        equations.derivative(compiled.state(state.q, state.v), rows=rows_from_afar(compiled, state, 1e-6, closure))
        assert equations.nearness == 0.0


@pytest.mark.parametrize("name", REGULAR)
def test_regular_mechanisms_never_enter_the_robust_code(name):
    scene = scene_of(name)
    compiled, state = compiled_of(scene, "plane" if name in ("five_bar", "planar_four_bar") else "reduced")
    run = compiled.run(state, Settings(duration=0.1, step=0.01))
    run.advance(100, FOREVER)
    assert run.outcome.status == core().Status.finished
    assert run.close_looks == 0


def from_sample(compiled: Compiled, block, at: int, step: float, steps: int):
    """A run of so many steps of RK4 and GPOPM from a recorded sample."""
    return compiled.core.SpaceRun(
        compiled.model,
        tableau_of(compiled.core, load_tableau("rk4")),
        compiled.projection(ProjectionSettings()),
        compiled.core.Steps.fixed(float(block["t"][at]), steps * step, step, steps, 1),
        np.ascontiguousarray(block["y"][at]),
        np.ascontiguousarray(block["turns"][at]),
    )


#: A singular pose after 0.3 s or none; a step of a power of 1/2, so that times have the same bits from another start.
CONTINUED = ((-0.3, "point_on_line"), (-0.3, "revolute"), ("bennett", ""), ("locomotive", ""), ("n_four_bar", ""))


@pytest.mark.parametrize(("name", "closure"), CONTINUED)
def test_a_run_goes_on_from_saved_rows_with_the_bits_of_the_long_run(name, closure):
    compiled, state = compiled_of(scene_of(name, closure))
    step, steps, part = 1.0 / 64.0, 40, 22
    run = compiled.run(state, Settings(duration=steps * step, step=step))
    run.keeps_marks = True
    before = run.advance(part + 1, FOREVER)
    assert len(before["t"]) == part + 1
    mark, looks = run.mark(), run.close_looks
    mark["rows"] = json.loads(json.dumps(mark["rows"]))
    after = run.advance(steps, FOREVER)
    assert looks > 0
    resumed = compiled.run(state, Settings(duration=steps * step, step=step))
    resumed.resume(mark)
    again = resumed.advance(steps + 1, FOREVER)
    assert len(again["t"]) == steps - part
    for key in ("t", "y", "acceleration", "multipliers", "turns"):
        np.testing.assert_array_equal(again[key], after[key])
    assert resumed.rows == run.rows


def test_a_step_on_which_the_rows_held_come_to_depend_on_each_other_takes_others():
    """Any 17 of the 20 rows of the linkage say the same where they are independent; those without these three are not
    near t = 0.746 s, which the second step comes to. A row left out there would be a constraint less."""
    compiled, state = compiled_of(scene_of("bennett"))
    block = compiled.run(state, Settings(duration=179 / 256, step=1 / 256)).advance(1000, FOREVER)
    start = float(block["t"][-1])
    step = (0.7458 - start) / 2.5
    bad = [[0, 1, 2, 4], [0, 1, 2, 3, 4], [0, 1, 2, 4], [0, 2, 3, 4]]
    rows = compiled.equations().rows(block["y"][-1].reshape(compiled.system.bodies, -1), start)
    ends, held = [], []
    for given in (rows, rows | {"held": bad, "chosen_pivots": []}):
        begun, run = (from_sample(compiled, block, -1, step, 3) for _ in range(2))
        begun.keeps_marks = True
        begun.advance(1, FOREVER)
        run.resume(begun.mark() | {"rows": given})
        ends.append(run.advance(1, FOREVER)["y"][-1])
        held.append(run.rows["held"])
        ends.append(run.advance(1, FOREVER)["y"][-1])
        held.append(run.rows["held"])
    assert held[2] == bad
    assert held[3] != bad
    np.testing.assert_allclose(ends[3], ends[1], atol=1e-3)


@pytest.mark.parametrize(
    ("name", "closure", "form"),
    [
        (-0.3, "point_on_line", "reduced"),
        (-0.3, "revolute", "reduced"),
        (-0.3, "revolute", "plane"),
        ("n_four_bar", "", "reduced"),
    ],
)
def test_recording_has_no_say_in_the_steps(name, closure, form):
    """The same bits at the end, with samples inside the steps and without, also past a singular pose."""
    ends = []
    for every in (0.005, 0.6):
        compiled, state = compiled_of(scene_of(name, closure), form)
        settings = Settings(duration=0.6, tolerance=1e-5, integrator="dopri5", output_step=every)
        run = compiled.run(state, settings)
        block = run.advance(1000, FOREVER)
        assert run.outcome.status == core().Status.finished
        ends.append((block["y"][-1], run.rows))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    assert ends[0][1] == ends[1][1]


WRONG_ROWS = [
    ({"held": [[0, 0, 1]]}, "held has a wrong number of joints"),
    ({"held": [[0, 99], [], [], []]}, "held holds an index out of range"),
    ({"held": [[1, 0], [], [], []]}, "held holds an index out of range"),
    ({"usual": 0.0}, "usual is not positive"),
    ({"usual": float("nan")}, "usual is negative or not finite"),
    ({"before": -1.0}, "before is negative or not finite"),
    ({"chosen_pivots": [1.0]}, "chosen_pivots has a wrong shape"),
]


@pytest.mark.parametrize(("changes", "message"), WRONG_ROWS)
def test_rows_from_elsewhere_are_checked(changes, message):
    compiled, state = compiled_of(scene_of("bennett"))
    y, equations = compiled.state(state.q, state.v), compiled.equations()
    rows = equations.rows(y)
    assert equations.derivative(y, rows=rows) is not None
    with pytest.raises(ValueError, match=f"^{message}"):
        equations.derivative(y, rows=rows | changes)
