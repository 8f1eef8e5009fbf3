"""Forces and motions in the kernel are those of the full formulation; its functions, and its own sine and cosine."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import compile_system
from mbproj.base.errors import SimulationError
from mbproj.functions.program import TIME, Op, Program, apply, variable
from mbproj.functions.program_set import flatten
from mbproj.functions.series import constant_series, run, time_series
from mbproj.kernel import core
from mbproj.kernel.models import programs
from mbproj.motion.formulations.choice import choose
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.formulations.reduced import Reduced, space_acceleration
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run
from tests.crossed import full
from tests.dynamics.force_scenes import BUSHINGS, FORCES, HEAD, ON_BODIES, reference
from tests.functions.texts import SMOOTH, T, expression
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.running import run_scene
from tests.support import assembled

pytestmark = needs_kernel


# Forces and motions in the kernel are those of the full formulation: functions, accelerations, powers, failures.


def test_every_function_has_the_values_and_derivatives_of_numpy():
    functions = flatten([Program(expression(text)) for text in SMOOTH])
    kernel = core().Programs(functions=programs(functions))
    for index, text in enumerate(SMOOTH):
        for t in T:
            expected = run(functions, index, [time_series(t), constant_series(t), constant_series(t)])
            found = kernel.run(index, t, 0.0, 0.0)
            np.testing.assert_allclose(found, [float(part) for part in expected], rtol=1e-13, atol=1e-13, err_msg=text)


def test_tables_between_and_beyond_their_rows():
    scene = read_scene_text(
        HEAD + "  s: {type: torsion_spring_damper, joint: R, table: [[-1, 4], [0, 0], [0.5, 1], [2, -3]]}\n"
    )
    forces = compile_system(scene).forces
    kernel = core().Programs(functions=programs(forces.programs))
    for s in (-3.0, -1.0, -0.4, 0.0, 0.3, 1.9, 2.0, 5.0):
        expected = run(forces.programs, 0, [time_series(0.0), constant_series(s), constant_series(0.0)])[0]
        assert kernel.run(0, 0.0, s, 0.0)[0] == pytest.approx(float(expected), abs=1e-14)


def moving(text: str, seed: int = 3):
    """A system and a closed state of it that moves at random."""
    scene = read_scene_text(text)
    system, state = assembled(scene)
    rng = np.random.default_rng(seed)
    formulation = FullFormulation.of(system, state, settings_to_run(scene))
    v = state.v + 0.5 * rng.normal(size=state.v.shape)
    settings = settings_to_run(scene)
    Λ = state.q.reshape(-1, 7)[:, 3:]
    rows = v.reshape(-1, 7)
    rows[:, 3:] -= np.sum(rows[:, 3:] * Λ, axis=1, keepdims=True) * Λ
    return system, replace(state.changed(velocities=rows.ravel()), t=0.8), formulation, settings


MOTIONS = "motions:\n  m: {joint: R, angle: {harmonic: {amplitude: 0.4, frequency: 3}}}\n"


@pytest.mark.parametrize(
    "text",
    [FORCES, BUSHINGS, ON_BODIES, FORCES + BUSHINGS + ON_BODIES, FORCES + ON_BODIES + MOTIONS],
    ids=["laws", "bushings", "on bodies", "all", "driven"],
)
def test_accelerations_and_multipliers_are_those_of_the_full_equations(text):
    system, state, full, _ = moving(HEAD + text)
    kernel = Reduced(core(), system)
    y = kernel.state(state.q, state.v)
    at = reference(system, state.q)
    found, multipliers = kernel.equations().accelerations(y, state.t, at.tolist())
    expected = full.accelerations(state.t, full.layout.vector_of({"positions": state.q, "velocities": state.v}), at)
    acceleration = space_acceleration(y[None], found[None])
    size = np.abs(expected.acceleration).max()
    np.testing.assert_allclose(acceleration[0], expected.acceleration, rtol=0, atol=1e-12 * size)
    size = np.abs(expected.multipliers).max()
    np.testing.assert_allclose(multipliers, expected.multipliers[system.bodies :], rtol=0, atol=1e-11 * size)


SLIDER = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 0.4, tolerance: 1e-11, integrator: dop853, output_step: 0.05}
bodies:
  crank: {mass: 1, inertia: [0.1, 0.2, 0.3], position: [0.25, 0.1, 0]}
  rod: {mass: 0.5, inertia: [0.01, 0.04, 0.04], position: [1, -0.2, 0]}
  block: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [1.5, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0], speed: 3 rad/s}
  B: {type: revolute, bodies: [crank, rod], location: [0.5, 0, 0], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [rod, block], location: [1.5, 0, 0], axis: [0, 1, 0]}
  D: {type: point_in_plane, bodies: [ground, block], location: [1.5, 0, 0], axis: [0, 0, 1]}
forces:
  spring: {type: spring_damper, points: {ground: [3, 0, 0], block: [1.5, 0, 0]}, stiffness: 40, damping: 2}
  hinge: {type: torsion_spring_damper, joint: C, stiffness: 3, damping: 0.1}
  wind: {type: force, body: rod, location: [1.2, 0, 0.1], force: [sin(3*t), 5, 1]}
  own: {type: force, body: crank, location: [0.3, 0.1, 0.05], force: [1, 2, t], axes: body}
  torque: {type: torque, body: crank, torque: [0.3, 0.2*t, 1], axes: body}
"""


#: Off the plane of the motion, askew to it, with coupled stiffness; what its forces have across the plane loads the
#: joints.
BUSH = """\
  bush:
    type: bushing
    bodies: [ground, rod]
    location: {ground: [1.1, 0.3, 0.1], rod: [0.1, -0.1, 0]}
    axes: {rod: {axis: [1, 2, 3], angle: 0.5}, ground: {axis: [1, 2, 3], angle: 0.5}}
    stiffness: {translation: [[90, 20, 0], [20, 70, 5], [0, 5, 60]], rotation: [[9, 1, 0], [1, 8, 2], [0, 2, 7]]}
    damping: {translation: [1, 0.5, 2], rotation: [0.4, 0.3, 0.2]}
    preload: {translation: [1, -2, 3], rotation: [0.1, 0.3, -0.2]}
"""


@pytest.mark.parametrize("more", [full(""), BUSH], ids=["laws", "bushing"])
def test_a_planar_scene_with_forces_moves_as_the_full_one(more):
    """Forces across the plane load the joints only."""
    runs = {}
    for formulation in ("planar", "reduced", "full"):
        scene = read_scene_text(SLIDER + more, "s.yaml", {}, {"formulation": formulation})
        runs[formulation] = run_scene(scene)
    for path in ("bodies/position", "bodies/velocity", "diagnostics/work", "diagnostics/dissipation", "forces/force"):
        for other in ("planar", "reduced"):
            np.testing.assert_allclose(runs[other][path], runs["full"][path], rtol=0, atol=2e-8, err_msg=path)
    size = np.abs(runs["full"]["joints/reaction_force"]).max()
    for path in ("joints/reaction_force", "joints/reaction_torque"):
        np.testing.assert_allclose(runs["planar"][path], runs["full"][path], rtol=0, atol=1e-7 * size, err_msg=path)
    assert np.abs(runs["planar"]["diagnostics/energy_balance"]).max() < 1e-7
    assert np.abs(runs["planar"]["diagnostics/dissipation"][-1]) > 0.1


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
def test_a_function_that_fails_names_its_force_and_time(formulation):
    text = SLIDER.replace("force: [sin(3*t), 5, 1]", "force: [sqrt(0.05 - t), 0, 0]")
    scene = read_scene_text(text, "s.yaml", {}, {"formulation": formulation})
    with pytest.raises(SimulationError) as caught:
        run_scene(scene)
    assert 0.05 < caught.value.time < 0.15
    assert caught.value.where == "force 'wind'"
    assert "fails: sqrt(" in str(caught.value)


@pytest.mark.parametrize(
    ("line", "name", "why"),
    [
        ("", "planar", "in the plane normal to"),
        (BUSH, "planar", "in the plane normal to"),
        (
            BUSH.replace("axes: {rod: {axis: [1, 2, 3], angle: 0.5}", "axes: {rod: {axis: [1, 2, 3], angle: 0.6}"),
            "reduced",
            "not planar: the frames of force 'bush' lean against each other",
        ),
        (
            "  far: {type: spring_damper, points: {ground: [3, 1, 0], block: [1.5, 0, 0]}, stiffness: 1}\n",
            "reduced",
            "not planar: force 'far' acts between points at different depths",
        ),
    ],
)
def test_what_a_plane_cannot_hold_is_computed_in_space(line, name, why):
    scene = read_scene_text(SLIDER + line)
    choice = choose(*assembled(scene), scene.settings)
    assert choice.name == name
    assert why in choice.why


# The kernel's own sine and cosine, for one double and for four at once.

#: Units in the last place: the polynomials' and the last rounding; beside a multiple of π/2 the reduction's, too.
MOST_OFF, BESIDE = 0.9, 1.1


def values(x: np.ndarray) -> np.ndarray:
    """Sine and cosine of each number as functions of a scene have them, (2, n)."""
    own = core().Programs(functions=programs(flatten([Program(apply(op, variable(TIME))) for op in (Op.SIN, Op.COS)])))
    return np.array([[own.run(number, float(t), 0.0, 0.0)[0] for t in x] for number in (0, 1)])


def off(x: np.ndarray) -> float:
    """The largest error, in units in the last place of what is right."""
    right = np.array([np.sin(x.astype(np.longdouble)), np.cos(x.astype(np.longdouble))])
    return float((np.abs(values(x) - right) / np.spacing(np.abs(right).astype(float))).max())


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="needs numbers longer than doubles")
def test_they_are_right_to_the_last_place_but_for_rounding():
    rng = np.random.default_rng(0)
    for size in (1e-9, 0.8, 3.0, 50.0, 1e4, 5e5):
        assert off(rng.uniform(-size, size, 2000)) < MOST_OFF
    turns = np.concatenate([np.arange(1, 500), rng.integers(500, 300_000, 500)]) * (0.5 * np.pi)
    assert off(np.concatenate([turns, np.nextafter(turns, 0.0), np.nextafter(turns, 1e9)])) < BESIDE


def test_beyond_its_reduction_they_are_those_of_the_standard_library():
    x = np.random.default_rng(1).uniform(1e6, 1e15, 500)
    np.testing.assert_allclose(values(x), [np.sin(x), np.cos(x)], rtol=0, atol=2e-16)
    assert np.isnan(values(np.array([np.inf, np.nan]))).all()


def test_zeros_keep_their_signs():
    sine, cosine = values(np.array([0.0, -0.0]))
    assert np.signbit(sine).tolist() == [False, True] and cosine.tolist() == [1.0, 1.0]
