"""Runs that are too stiff for their step say so, with the force, its ω h and what to do; others never do."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from mbproj.base.errors import SimulationError
from mbproj.motion.simulate import simulate
from mbproj.motion.steppers.runge_kutta import reach
from mbproj.motion.steppers.tableau import load_tableau
from mbproj.scene.scene import read_scene
from mbproj.scene.settings import settings_to_run
from tests.crossed import crossed, full
from tests.integrate.stiff_scenes import WHEEL, held_by, rod
from tests.kernel.scenes import needs_kernel, run
from tests.support import DATA, MECHANISMS, ROOT, assembled

EACH = ["full", pytest.param("reduced", marks=needs_kernel), pytest.param("planar", marks=needs_kernel)]
COIL = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {slider: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.3, 0, 0]}}
joints: {guide: {type: prismatic, bodies: [ground, slider], location: [0, 0, 0], axis: [1, 0, 0]}}
"""
SPRING = "{type: spring_damper, points: {ground: [0, 0, 0], slider: [0.3, 0, 0]}, stiffness: 1.0e7, free_length: 0.31}"


def stopped(scene, **keys):
    with pytest.raises(SimulationError) as caught:
        run(scene, **keys)
    return caught.value


@crossed("method, formulation", ["none", "gpopm"], [full("full"), *EACH[1:]])
def test_a_spring_beyond_the_stability_of_rk4_is_named(formulation, method):
    """√(1e7 / 1) 1e-3 = 3.162 where |R(i ω h)| = 2.11; √8 is the limit, 0.8 ms well within it."""
    error = stopped(
        held_by(SPRING, COIL), duration=1.0, step=1e-3, formulation=formulation, projection={"method": method}
    )
    assert error.where == "force 'rod'"
    assert error.cause == (
        "stiff: ω h = 3.16 on the masses that it moves, and rk4 is stable up to 2.83, so that errors grow 2.11-fold in "
        "each step of 0.001 s"
    )
    assert error.hint.startswith(
        "take steps of 0.0008 s or less, dop853, which is stable up to 5.97, or a softer force; "
    )
    assert "gpopm" not in str(error)
    until = 0.016 if formulation == "full" else 0.08
    _, report = run(
        held_by(SPRING, COIL), duration=until, step=8e-4, formulation=formulation, projection={"method": method}
    )
    assert report.stiffness == ""


@crossed(
    "law, what, formulation",
    [
        pytest.param("damping: 2000", "c h / m = 4"),
        pytest.param("torque: -100*tanh(angle_dot/0.05)", "c h / m = 3.84"),
        pytest.param("torque: -8.0e6*angle**3 - 2000*angle_dot", "c h / m = 4"),
        pytest.param("stiffness: 8.0e6", "ω h = 4"),
        pytest.param("table: {rows: [[-1, 8.0e6], [1, -8.0e6]], between: linear}", "ω h = 4"),
    ],
    EACH,
    dear=["full"],
)
def test_every_law_that_is_too_stiff_is_named(law, what, formulation):
    """On 0.5 kg m², at steps of 1 ms."""
    scene = held_by(
        f"{{type: torsion_spring_damper, joint: pin, {law}}}", WHEEL.replace("speed: 2, angle: 0.1", "speed: 0.01")
    )
    keys = {"duration": 0.1, "step": 1e-3, "formulation": formulation}
    if "tanh" in law:  # bounded: it goes on, and is wrong
        said = run(scene, **keys)[1].stiffness
    else:
        error = stopped(scene, **keys | {"duration": 10.0})
        said = f"{error.where} {error.cause}"
    assert said.startswith("force 'rod'")
    assert what in said


def test_baumgartes_gains_are_named():
    error = stopped(
        rod(10.0, 0.0),
        duration=1.0,
        step=0.01,
        formulation="full",
        projection={"method": "baumgarte", "gains": (400.0, 400.0)},
    )
    assert error.where == "Baumgarte's gains of 400 and 400 1/s"
    assert "α h = 4, and rk4 is stable up to 2.79" in error.cause


@needs_kernel
def test_a_run_that_ends_before_it_is_lost_is_told_too():
    """30 steps multiply an error by 2.11^30 = 5e9."""
    _, report = run(held_by(SPRING, COIL), duration=0.03, step=1e-3)
    assert report.stiffness.startswith("force 'rod' is too stiff for steps of 0.001 s: ω h = 3.16 on the masses")
    assert "the motion is not to be trusted; take steps of 0.0008 s or less, " in report.stiffness


@needs_kernel
@pytest.mark.parametrize("integrator", ["bs32", "dopri5", "dop853"])
def test_a_damper_that_holds_the_step_is_told(integrator):
    """Of 2e4 N s/m on 1 kg: c / m = 2e4 1/s. A tolerance ten times looser changes no step."""
    scene = rod(1e6, 2e4)
    found = [
        run(scene, duration=0.2, tolerance=tol, integrator=integrator, output_step=1e-3)[1] for tol in (1e-4, 1e-5)
    ]
    steps = [report.counters["steps"] for report in found]
    assert steps[0] == pytest.approx(steps[1], rel=0.05)
    limit = reach(load_tableau(integrator), -1.0)
    assert 0.2 / steps[1] * 2e4 == pytest.approx(limit, rel=0.1)
    for report in found:
        assert "force 'rod' is stiff and holds the step at" in report.stiffness
        assert f"{integrator} is stable up to {limit:.3g}" in report.stiffness
        assert ("dop853, which is stable" in report.stiffness) == (integrator != "dop853")


@needs_kernel
def test_the_governor_says_what_holds_its_step():
    scene = read_scene(DATA / "stiff_governor.yaml")
    report = simulate(*assembled(scene), settings_to_run(scene))
    assert "'spring" in report.stiffness  # either of two alike
    assert "dop853 is stable up to 6.4" in report.stiffness


@pytest.mark.full
def test_the_governor_runs_in_the_full_formulation_too():
    """What it tries and rejects overflows there; NumPy warns of nothing (pytest makes errors of warnings)."""
    settings = {"formulation": "full", "duration": "0.003", "output_step": "0.001"}
    scene = read_scene(DATA / "stiff_governor.yaml", {}, settings)
    report = simulate(*assembled(scene), settings_to_run(scene))
    assert report.counters["steps"] > 10


@needs_kernel
@pytest.mark.parametrize("integrator", ["bs32", "dopri5", "dop853"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-8])
@pytest.mark.parametrize("amplitude", [0.2, 0.01])
def test_a_vibration_that_is_the_motion_is_not_stiff(integrator, tolerance, amplitude):
    """One oscillator at 20 rad/s, through rest."""
    scene = held_by(SPRING.replace("1.0e7", "400").replace("0.31", repr(0.3 + amplitude)), COIL)
    _, report = run(scene, duration=3.0, tolerance=tolerance, integrator=integrator, output_step=0.01)
    assert report.stiffness == ""


FORCED = [
    path
    for path in [*MECHANISMS, *sorted((ROOT / "mechanisms/validation").glob("*.yaml"))]
    if "\nforces:" in path.read_text(encoding="utf-8")
]


@needs_kernel
@crossed(
    "path, simulation",
    [pytest.param(path, id=path.stem) for path in FORCED],
    [
        pytest.param({}, id="own"),
        pytest.param({"integrator": "dop853", "tolerance": 1e-3, "duration": 0.03}, id="loose"),
    ],
    together=1,
)
def test_no_mechanism_that_is_shipped_is_stiff_but_for_rubber(path, simulation):
    scene = read_scene(path, {}, simulation)
    said = simulate(*assembled(scene), settings_to_run(scene)).stiffness
    if path.stem == "split_coupler" and simulation:  # its rubber is, for who does not ask how it rings
        assert said.startswith("force 'rubber' is stiff and holds the step at 0.00")
    else:
        assert said == ""


@needs_kernel
def test_of_a_long_chain_the_stiffest_springs_are_named():
    """200 links in a line with a torsion spring in every joint, one of them 1e4 times as stiff."""
    bodies = "".join(
        f"  b{k}: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [{k + 0.5}, 0, 0]}}\n" for k in range(200)
    )
    names = ["ground", *(f"b{k}" for k in range(200))]
    joints = "".join(
        f"  J{k}: {{type: revolute, bodies: [{names[k]}, b{k}], location: [{k}, 0, 0], axis: [0, 1, 0]}}\n"
        for k in range(200)
    )
    forces = "".join(
        f"  s{k}: {{type: torsion_spring_damper, joint: J{k}, stiffness: {1e7 if k == 77 else 1e3}}}\n"
        for k in range(1, 200)
    )
    from mbproj.scene.scene import read_scene_text

    text = f"mbproj: 1\ngravity: [0, 0, -9.81]\nbodies:\n{bodies}joints:\n{joints}forces:\n{forces}"
    error = stopped(read_scene_text(text), duration=3.0, step=1e-3)
    assert error.where == "force 's77'"
    assert error.cause.startswith("stiff: ω h = ")


@pytest.mark.parametrize("formulation", EACH)
def test_an_error_in_a_run_without_stiffness_keeps_its_own_reason(formulation):
    error = stopped(
        held_by("{type: linear_spring_damper, joint: slide, force: sqrt(0.05 - t)}"),
        duration=1.0,
        step=1e-3,
        formulation=formulation,
    )
    assert error.where == "force 'rod'"
    assert "'sqrt(0.05 - t)' fails" in error.cause


@pytest.mark.full_where(formulation="full")
@crossed("integrator, formulation", ["dop853", "bs32"], EACH, dear=["full"])
def test_a_step_into_where_a_force_has_no_value_is_shortened(formulation, integrator):
    """A bob flies at 5 m/s towards a barrier of the potential 1e-3 / √(0.5 - s), which has no value beyond s = 0.5: it
    turns back where ½ m v² is used up, and conserves its energy."""
    scene = held_by(
        "{type: linear_spring_damper, joint: guide, force: -0.5e-3 * (0.5 - displacement)**-1.5}",
        COIL.replace("axis: [1, 0, 0]}", "axis: [1, 0, 0], speed: 0.5}").replace("-9.81", "0"),
    )
    recorder, report = run(
        scene, duration=2.0, tolerance=1e-6, integrator=integrator, output_step=0.01, formulation=formulation
    )
    assert report.counters["rejected_steps"] > 0
    assert recorder["joints/coordinate"][-1, 0] < 0.02
    np.testing.assert_allclose(recorder["joints/speed"][-1, 0], -0.5, atol=0.01)
    farthest = 0.5 - (1e-3 / (0.125 + 1e-3 / sqrt(0.5))) ** 2
    assert recorder["joints/coordinate"].max() <= farthest + 1e-4


@pytest.mark.parametrize("formulation", EACH)
def test_a_step_that_overflows_is_shortened_with_error_control_and_stops_with_a_fixed_one(formulation):
    """cosh overflows at 711: a force of sinh(1e4 s) overflows 0.07 m out, where a long step would be."""
    scene = held_by(
        "{type: linear_spring_damper, joint: guide, force: -1.0e-3*sinh(1.0e4*displacement)}",
        COIL.replace("axis: [1, 0, 0]}", "axis: [1, 0, 0], speed: 3}"),
    )
    recorder, report = run(
        scene,
        duration=2e-3 if formulation == "full" else 0.01,
        tolerance=1e-6,
        integrator="dopri5",
        output_step=1e-4,
        formulation=formulation,
    )
    assert report.counters["rejected_steps"] > 0
    energy = recorder["diagnostics/energy_balance"]
    assert np.abs(energy).max() < 1e-3
    assert np.abs(recorder["joints/coordinate"]).max() < 2e-3
    error = stopped(scene, duration=1.0, step=0.1, formulation=formulation)
    assert error.time <= 0.1
    assert (
        "'-1.0e-3*sinh(1.0e4*displacement)' fails" in str(error)
        or "no longer finite" in str(error)
        or "stiff" in str(error)
    )


@pytest.mark.parametrize("formulation", EACH)
def test_a_body_that_has_run_away_is_not_told_to_project(formulation):
    """A spring that pushes: 1e160 m/s², and round-off of the place leaves the guide open by more than its length."""
    scene = held_by(
        "{type: linear_spring_damper, joint: guide, force: 1.0e12*t}", COIL.replace("[1, 0, 0]}}", "[1, 0.7, 0.3]}}")
    )
    error = stopped(scene, duration=1e6, step=100.0, formulation=formulation)
    assert "its bodies have run away" in error.cause
    assert error.hint == "try a smaller step or tolerance"


TWO_HINGES = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  a: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.5, 0, 0]}
  b: {mass: 1, inertia: [0.001, 0.001, 0.001], position: [1, 0, 0.1]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0], speed: 50}
  B: {type: revolute, bodies: [a, b], location: [1, 0, 0], axis: [0, 1, 0], speed: 50}
"""


@pytest.mark.parametrize("formulation", EACH)
def test_a_torsion_spring_is_named_where_turns_cannot_be_told_before_errors_have_grown_by_much(formulation):
    """c h / m = 8 at 50 rad/s: the first step or two turn the joint too far, long before errors are 1000-fold."""
    damped = held_by("{type: torsion_spring_damper, joint: B, stiffness: 1000, damping: 10}", TWO_HINGES)
    error = stopped(damped, duration=0.1, step=0.01, formulation=formulation)
    assert error.where == "force 'rod'"
    assert error.cause.startswith("stiff: c h / m = 8")
