"""Implicit steps in the kernel: order, closed joints beside stiff forces, events."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.errors import SimulationError
from mbproj.base.registry import implicit_integrators, integrators
from mbproj.base.settings import Settings
from mbproj.kernel import core
from mbproj.motion.formulations.reduced import Reduced
from mbproj.motion.steppers.tableau import load_implicit_tableau
from mbproj.scene.records import Body
from mbproj.scene.scene import read_scene, read_scene_text
from tests.integrate.event_scenes import rotor
from tests.kernel.scenes import PATHS, bits, mechanism, needs_kernel, run
from tests.support import assembled, scene_of

pytestmark = needs_kernel


# Implicit steps in the kernel: their order, closed joints beside forces of any stiffness, samples.

#: Bars in space on a universal joint and a pin, with forces of every kind: on both angles of one joint and on that of
#: another, one of them an expression, along a line, and a bushing; all stiffer with the dial.
BARS = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {dial: 1}
bodies:
  upper: {mass: 2, inertia: [0.02, 0.05, 0.06, 0.005, 0, 0.002], position: [0.5, 0, 0], angular_velocity: [0, 0.5, 2]}
  lower: {mass: 1, inertia: [0.02, 0.03, 0.01], position: [1.5, 0, 0]}
  end: {mass: 0.5, inertia: [0.002, 0.003, 0.004], position: [2, 0.1, 0]}
joints:
  shoulder: {type: universal, bodies: [ground, upper], location: [0, 0, 0], axes: [[0, 1, 0], [0, 0, 1]]}
  elbow: {type: revolute, bodies: [upper, lower], location: [1, 0, 0], axis: [0, 1, 0], speed: 1}
forces:
  one: {type: torsion_spring_damper, joint: shoulder, coordinate: angle_1, stiffness: 70 * dial, damping: 0.3}
  other: {type: torsion_spring_damper, joint: shoulder, coordinate: angle_2, stiffness: 90 * dial}
  knee: {type: torsion_spring_damper, joint: elbow, torque: -dial * (20 * sinh(angle) + tanh(3 * angle_dot))}
  tie: {type: spring_damper, points: {ground: [0, 1, 0], upper: [1, 0, 0]}, stiffness: 100 * dial, damping: 2}
  rubber:
    type: bushing
    bodies: [lower, end]
    location: [2, 0, 0]
    stiffness: {translation: [300 * dial, 200 * dial, 250 * dial], rotation: [3, 2, 4]}
    damping: {translation: [1, 1, 2], rotation: [0.05, 0.05, 0.05]}
"""
ESDIRK: dict[str, Any] = {"integrator": "esdirk4"}
both = pytest.mark.parametrize("integrator", implicit_integrators())


def bars(dial: float = 1.0) -> Scene:
    return read_scene_text(BARS, parameters={"dial": repr(dial)})


def split_coupler(softness: float) -> Scene:
    return read_scene(PATHS["split_coupler"], {"softness": repr(softness)})


def ends(scene: Scene, duration: float, counts: tuple[int, ...], **keys: Any) -> list[np.ndarray]:
    """Where the bodies are after so many steps."""
    return [
        run(scene, duration=duration, step=duration / count, output_step=duration, **keys)[0]["bodies/position"][-1]
        for count in counts
    ]


def observed_order(errors: list[float]) -> float:
    """Of errors of steps of which each is half of the one before."""
    return float(np.log2(errors[0] / errors[-1]) / (len(errors) - 1))


@both
@pytest.mark.parametrize(
    ("scene", "formulation", "duration", "steps"),
    [
        (mechanism("five_bar"), "planar", 0.4, 10),
        (mechanism("spatial_slider_crank"), "reduced", 0.4, 40),
        (bars(), "reduced", 0.5, 50),
        (split_coupler(1.0), "planar", 0.05, 25),
    ],
    ids=["loop", "loop in space", "forces", "bushing"],
)
def test_their_orders(scene, formulation, duration, steps, integrator):
    keys = {"duration": duration, "output_step": duration, "formulation": formulation}
    exact = run(scene, tolerance=1e-13, integrator="dop853", **keys)[0]["bodies/position"][-1]
    found = ends(scene, duration, (steps, 2 * steps, 4 * steps), integrator=integrator, formulation=formulation)
    assert observed_order([np.abs(each - exact).max() for each in found]) > integrators()[integrator].order - 0.3


@both
@pytest.mark.parametrize(
    ("scene", "duration", "steps"),
    [(mechanism("five_bar"), 0.2, 10), (bars(), 0.1, 20), (split_coupler(1e-2), 0.1, 20)],
    ids=["loop", "forces", "bushing"],
)
def test_the_same_states_as_in_full(scene, duration, steps, integrator):
    """They differ by less than by the error of their steps: rotations are integrated in other coordinates."""
    keys = {"integrator": integrator}
    coarse, fine = ends(scene, duration, (steps, 2 * steps), formulation="reduced", **keys)
    (full,) = ends(scene, duration, (steps,), formulation="full", **keys)
    assert np.abs(coarse - full).max() < {"esdirk4": 0.2, "radau5": 0.9}[integrator] * np.abs(coarse - fine).max()


@both
def test_the_same_states_as_in_full_where_nothing_turns(integrator):
    """To round-off: two masses on rails, which a stiff spring and a damper tie to each other."""
    text = """
mbproj: 1
gravity: [0, 0, 0]
bodies:
  a: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0], velocity: [1, 0, 0]}
  b: {mass: 2, inertia: [1, 1, 1], position: [0, 1, 0]}
joints:
  A: {type: prismatic, bodies: [ground, a], location: [0, 0, 0], axis: [1, 0, 0]}
  B: {type: prismatic, bodies: [ground, b], location: [0, 1, 0], axis: [1, 0, 0]}
forces:
  tie: {type: spring_damper, points: {a: [0, 0, 0], b: [0, 1, 0]}, stiffness: 1.0e6, damping: 100}
"""
    scene, keys = read_scene_text(text), {"duration": 0.2, "output_step": 0.02, "step": 0.01, "integrator": integrator}
    found = [run(scene, formulation=name, **keys)[0] for name in ("reduced", "full")]
    for name in ("bodies/position", "bodies/velocity", "joints/speed"):
        np.testing.assert_allclose(found[0][name], found[1][name], atol=1e-10)


@both
def test_the_order_of_rotations(integrator):
    """A free body with three moments of inertia, whose axes turn far within a step."""
    inertia = ((1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 3.0))
    body = Body("top", 1.0, inertia, (0.0, 0.0, 0.0), angular_velocity=(0.3, 2.0, 0.5))
    scene = scene_of([body], [], gravity=(0.0, 0.0, 0.0))

    def turned(steps: int, integrator: str) -> np.ndarray:
        keys = {"duration": 4.0, "step": 4.0 / steps, "output_step": 4.0, "integrator": integrator}
        return run(scene, formulation="reduced", **keys)[0]["bodies/orientation"][-1]

    exact = turned(4000, "rk4")
    found = [np.abs(turned(steps, integrator) - exact).max() for steps in (20, 40, 80)]
    assert observed_order(found) > integrators()[integrator].order - 0.2
    assert found[-1] < 1e-5


@both
@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_joints_stay_closed_at_any_stiffness(formulation, integrator):
    """1e5 N/m to 1e11 N/m, with one step: the solution hardly depends on it any more."""
    states = []
    for softness in (1.0, 1e-2, 1e-4, 1e-6):
        scene, keys = split_coupler(softness), {"duration": 0.2, "step": 0.002, "output_step": 0.2}
        recorder, report = run(scene, formulation=formulation, integrator=integrator, **keys)
        assert report.position_violation.value <= 1e-13
        assert report.velocity_violation.value <= 1e-13
        assert report.counters["evaluations"] < {"esdirk4": 30, "radau5": 60}[integrator] * report.counters["steps"]
        states.append(recorder["bodies/position"][-1])
    assert np.abs(states[2] - states[3]).max() < 1e-7


@both
def test_error_control_of_stiff_forces(integrator):
    """An explicit method needs 3,600 steps for the same."""
    keys = {"duration": 0.5, "output_step": 0.01, "formulation": "reduced"}
    recorder, report = run(bars(1e3), tolerance=1e-4, integrator=integrator, **keys)
    fine, _ = run(bars(1e3), tolerance=1e-9, integrator="dop853", **keys)
    assert report.counters["steps"] < {"esdirk4": 400, "radau5": 600}[integrator]
    assert np.abs(recorder["bodies/position"] - fine["bodies/position"]).max() < 1e-3


def chain_of_links(count: int) -> Scene:
    """Links on pins one after another, each with a stiff torsion spring."""
    lines = ["mbproj: 1", "gravity: [0, 0, -9.81]", "bodies:"]
    names = ["ground", *(f"link{number}" for number in range(count))]
    moments = "inertia: [0.01, 0.02, 0.02]"
    lines += [f"  {name}: {{mass: 1, {moments}, position: [{at + 0.5}, 0, 0]}}" for at, name in enumerate(names[1:])]
    lines += ["joints:"]
    for at, (before, name) in enumerate(pairwise(names)):
        pin = f"bodies: [{before}, {name}], location: [{at}, 0, 0], axis: [0, 1, 0]"
        lines.append(f"  J{at}: {{type: revolute, {pin}}}")
    lines += ["forces:"]
    law = "stiffness: 1.0e6, damping: 1.0e4"
    lines += [f"  S{at}: {{type: torsion_spring_damper, joint: J{at}, {law}}}" for at in range(count)]
    return read_scene_text("\n".join(lines) + "\n")


def kernel_run(scene: Scene, **keys: Any) -> Any:
    """The kernel's own run in space."""
    system, state = assembled(scene)
    return Reduced(core(), system).run(state, Settings(**ESDIRK, **keys))


def test_a_stiff_hinge_is_eliminated_with_its_body():
    """So that work grows with the length of a chain; the bodies of a bushing stay among the loops."""
    assert kernel_run(chain_of_links(30), duration=0.1, step=0.01).loop_joints == 0
    assert kernel_run(split_coupler(1.0), duration=0.1, step=0.01).loop_joints > 0


@both
def test_stiff_hinges_of_a_tree(integrator):
    """Bars that 1e6 N m/rad hold sag to what statics say."""
    count, stiffness = 4, 1e6
    (found,) = ends(chain_of_links(count), 0.4, (20,), formulation="reduced", integrator=integrator)
    carried = np.arange(count, 0, -1)
    turned = np.cumsum(9.81 * carried * carried / 2 / stiffness)  # by the weights beyond each pin, at their middle
    sagged = np.cumsum(turned) - 0.5 * turned
    np.testing.assert_allclose(-found[:, 2], sagged, rtol=1e-5)


@both
@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_equal_input_has_equal_bits(formulation, integrator):
    keys = {"duration": 0.1, "tolerance": 1e-6, "output_step": 0.01, "formulation": formulation}
    first, second = (run(split_coupler(1e-2), integrator=integrator, **keys)[0] for _ in range(2))
    assert bits(first.blocks) == bits(second.blocks)


@both
def test_samples_do_not_change_the_steps(integrator):
    keys = {"duration": 0.1, "tolerance": 1e-6, "formulation": "reduced"}
    sparse, few = run(bars(1e2), output_step=0.1, integrator=integrator, **keys)
    dense, many = run(bars(1e2), output_step=0.001, integrator=integrator, **keys)
    assert few.counters["steps"] == many.counters["steps"]
    np.testing.assert_array_equal(sparse["bodies/position"][-1], dense["bodies/position"][-1])


@both
def test_samples_inside_steps_are_of_order_four(integrator):
    """What the extension gives between steps is as exact as the steps; so are accelerations."""
    keys = {"duration": 0.3, "output_step": 0.003, "formulation": "reduced"}
    found, _ = run(bars(), tolerance=1e-7, integrator=integrator, **keys)
    exact, _ = run(bars(), tolerance=1e-11, integrator="dop853", **keys)
    assert np.abs(found["bodies/position"] - exact["bodies/position"]).max() < 1e-6
    scale = np.abs(exact["bodies/acceleration"]).max()
    assert np.abs(found["bodies/acceleration"] - exact["bodies/acceleration"]).max() < 1e-4 * scale


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gamma": 0.0}, "gamma is not positive"),
        ({"gamma": 0.3}, "splitting does not have gamma on its diagonal"),
        ({"splitting": np.ones((6, 6)) * 0.25 - np.diag([0.25, *(5 * [0.0])])}, "splitting is not lower triangular"),
        ({"b": np.zeros(6)}, "b is not the last stage"),
        ({"error": np.zeros(7)}, "error has a wrong shape"),
        ({"dense": np.zeros((6, 0))}, "dense has a wrong shape"),
        ({"a": np.ones((6, 6))}, "a does not begin with the start of the step"),
        ({"splitting": np.zeros((3, 3))}, "splitting has a wrong shape"),
    ],
)
def test_tableaus_that_do_not_fit_are_refused(change, message):
    good = vars(load_implicit_tableau("esdirk4"))
    with pytest.raises(ValueError, match=message):
        core().Tableau(tableau=good | change, kinematic=False)


# Implicit steps in the kernel at jumps in time, at events, and with laws that saturate or have no solution.


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
