"""Stability maps: limits that theory knows, by steps and by small motions."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.linalg import expm

from mbproj import InputError, SimulationError, compile_system, read_scene, read_scene_text
from mbproj.base.registry import explicit_integrators
from mbproj.linear.equilibrium.start import start_state
from mbproj.linear.instants import round_of
from mbproj.linear.reference import reference_at
from mbproj.motion.steppers.runge_kutta import real_axis_limit
from mbproj.motion.steppers.tableau import load_tableau
from mbproj.studies.measure.setting import Setting
from mbproj.studies.stability import (
    QUANTITIES,
    Limits,
    StateChange,
    Subject,
    ValueSpan,
    growth,
    judged,
    judged_in_blocks,
    quantity_named,
    stability,
    values,
)
from mbproj.studies.variants import joints_from_ground, rescaled, with_inertia_ratio, with_mass_ratio, with_speed
from tests.mechanisms.running import run_scene
from tests.studies.scenes import OSCILLATOR, PENDULUM
from tests.support import REDUNDANT, ROOT

# Stability maps: limits that theory knows, what each quantity does to a scene, and what a scene does not have.

SLIDER_CRANK = read_scene(ROOT / "mechanisms" / "spatial_slider_crank.yaml")


def limit(found) -> StateChange:
    (track,) = found.tracks
    return track.changes[0]


@pytest.mark.parametrize("name", explicit_integrators())
def test_baumgartes_limit_is_that_of_the_tableau(name):
    """α h at which |R(-α h)| passes 1, within 2 %, on a pendulum that turns by less than 1e-3 rad in a step."""
    scene = read_scene_text(PENDULUM, "scene.yaml", {}, {"integrator": name, "step": "1e-4"})
    found = stability(scene, "baumgarte-gain", points=8, processes=1)
    assert found.analytic == pytest.approx(1e4 * real_axis_limit(load_tableau(name)))
    assert [(change.below.state, change.above.state) for change in found.tracks[0].changes] == [("holds", "fails")]
    assert limit(found).value == pytest.approx(found.analytic, rel=0.02)
    near = min(found.tracks[0].points, key=lambda point: abs(np.log(point.value / 1e4)))
    assert near.closure < 1e-3 * 1e-8  # α h = 1: after 300 steps nothing is left of the offset


@pytest.mark.parametrize(("given", "own"), [({}, 25.0), ({"gains": 40}, 40.0)])
def test_the_own_gain_is_that_of_a_run(given, own):
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml", {}, {"projection": "baumgarte", **given})
    span = QUANTITIES["baumgarte-gain"].span(Subject(scene, Setting.of(scene.settings), 1.0, Limits()))
    assert (span.own, span.own) == scene.settings.projection.gains == (own, own)


@pytest.mark.full
@pytest.mark.parametrize(("step", "part"), [(1e-2, 0.78), (2e-3, 0.94), (5e-4, 0.98)])
def test_the_limit_comes_near_that_of_the_tableau_as_steps_become_short(step, part):
    """The numbers of the guide's page on stability."""
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml", {}, {"step": step})
    found = stability(scene, "baumgarte-gain", points=5, processes=1)
    assert limit(found).value / found.analytic == pytest.approx(part, abs=0.01)


@pytest.mark.full
def test_the_limit_is_the_same_in_the_full_formulation():
    options = {"integrator": "heun2", "step": "1e-4", "formulation": "full"}
    scene = read_scene_text(PENDULUM, "scene.yaml", {}, options)
    setting = replace(Setting.of(scene.settings), projection="baumgarte")
    below, above = (part * 2.0 / 1e-4 for part in (0.98, 1.02))
    assert growth(Subject(scene, replace(setting, gains=(below, below)), 1.0, Limits()), below).state == "holds"
    with pytest.raises(SimulationError, match=r"stiff: α h = 2\.04, and heun2 is stable up to 2\.01"):
        growth(Subject(scene, replace(setting, gains=(above, above)), 1.0, Limits()), above)


@pytest.mark.parametrize(("name", "expected"), [("heun2", 2.0), ("bs32", 2.5127), ("rk4", 2.7853), ("dopri5", 3.3066)])
def test_real_stability_limits(name, expected):
    """Those of the Taylor polynomials of order 2, 3 and 4 (Hairer & Wanner 1996, sect. IV.2), and of DOPRI5's R(z)."""
    assert real_axis_limit(load_tableau(name)) == pytest.approx(expected, abs=1e-4)


def test_the_energy_of_an_oscillator_is_lost_as_rk4_damps_it():
    """Over N = 2000 steps of h ω = θ, RK4 leaves (1 - θ⁶/72 + θ⁸/576)ᴺ of the energy E; the kinetic energy and |ΔV| are
    2 E together, so that 1 % and 10 % are off where 98 % and 80 % are left."""
    found = stability(
        read_scene_text(OSCILLATOR), "stiffness", projections=["none"], low=1, high=100, points=3, processes=1
    )
    (track,) = found.tracks
    assert [change.above.state for change in track.changes] == ["degrades", "fails"]
    for change, left in zip(track.changes, (0.98, 0.8), strict=True):
        theta = 0.1 * np.sqrt(change.value)
        assert (1.0 - theta**6 / 72.0 + theta**8 / 576.0) ** 2000 == pytest.approx(left, abs=0.006)
        assert change.above.cause == "the energy is off by 1.0e-02"


def test_where_a_run_first_goes_wrong_is_told():
    found = stability(SLIDER_CRANK, "step", projections=["none", "gpopm"], low=0.005, high=0.04, points=4, processes=1)
    none, gpopm = found.tracks
    assert none.points[0].state != "holds"
    assert none.points[0].joint in {"joint 'A'", "joint 'B'", "joint 'C'", "joint 'D'"}
    assert 0.0 < none.points[0].time < 10.0
    assert gpopm.points[0].state == "holds"
    assert (gpopm.points[0].time, gpopm.points[0].joint, gpopm.points[0].cause) == (None, None, "")
    assert gpopm.points[0].closure <= 2e-12  # 1e-13 over the smallest length
    for change in gpopm.changes:
        assert change.above.value / change.below.value < 1.01


def test_the_size_of_a_mechanism_does_not_matter():
    """From a millionth to a million times the size: the joints are closed to the same part of it."""
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml", {}, {"duration": "1"})
    found = stability(scene, "length-scale", projections=["gpopm"], points=5, processes=1)
    (track,) = found.tracks
    assert [point.state for point in track.points] == ["holds"] * 5
    assert max(point.closure for point in track.points) <= 3e-13
    assert np.ptp([point.energy for point in track.points]) <= 1e-6 * track.points[0].energy


@pytest.mark.parametrize("vary", [name for name in QUANTITIES if name not in ("stiffness", "damping", "penalty")])
def test_at_its_own_value_a_quantity_changes_nothing(vary):
    subject = Subject(SLIDER_CRANK, Setting.of(SLIDER_CRANK.settings), 0.5, Limits())
    quantity = QUANTITIES[vary]
    own = quantity.span(subject).own
    changed = quantity.changed(subject, own)
    if vary == "baumgarte-gain":
        assert changed.setting.gains == (own, own)
        return
    assert (changed.setting, changed.until) == (subject.setting, 0.5)
    for name in ("bodies", "joints", "forces", "gravity"):
        assert getattr(changed.scene, name) == getattr(subject.scene, name)


def test_neighbours_have_the_ratio_that_is_asked_for():
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml")
    assert list(joints_from_ground(scene).values()) == [1, 2, 3, 4, 5]
    heavy = with_mass_ratio(scene, 1e6)
    ratios = [one.mass / other.mass for one, other in zip(heavy.bodies, heavy.bodies[1:], strict=False)]
    np.testing.assert_allclose(ratios, [1e6, 1e-6, 1e6, 1e-6], rtol=1e-12)
    np.testing.assert_allclose(np.array(heavy.bodies[0].inertia), 1e3 * np.array(scene.bodies[0].inertia))
    spun = with_inertia_ratio(scene, 1e4)
    assert [body.mass for body in spun.bodies] == [body.mass for body in scene.bodies]
    np.testing.assert_allclose(np.array(spun.bodies[1].inertia), 1e-2 * np.array(scene.bodies[1].inertia))


@pytest.mark.parametrize("name", ["locomotive", "hooke_shaft", "inline_four", "stewart_platform"])
def test_a_scene_in_another_unit_of_length_moves_alike(name):
    """With forces, motions, gears and redundant joints: positions k times, reactions k times, angles the same. Of
    redundant joints the smallest reactions are recorded, which depend on the unit."""
    k = 1e3
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml")
    own = scene.settings
    step = own.step or 1e-4
    scene = replace(scene, settings=replace(own, duration=20 * step, step=step, tolerance=None, output_step=None))
    one, other = run_scene(scene), run_scene(rescaled(scene, k))
    paths = {"bodies/position": k, "joints/reaction_force": k, "joints/reaction_torque": k**2}
    for path, factor in list(paths.items())[: 1 if name in REDUNDANT else None]:
        size = max(np.abs(one[path]).max(), 1.0)
        np.testing.assert_allclose(other[path] / factor, one[path], rtol=0, atol=1e-8 * size, err_msg=path)
    np.testing.assert_allclose(other["bodies/orientation"], one["bodies/orientation"], rtol=0, atol=1e-10)


def test_motions_run_faster():
    """A driven crank at thrice the speed is after a third of the time where it was."""
    scene = read_scene(ROOT / "mechanisms" / "inline_four.yaml")
    settings = replace(scene.settings, duration=3e-3, step=1e-4, tolerance=None, output_step=3e-3)
    slow = run_scene(replace(scene, settings=settings))
    fast = run_scene(replace(with_speed(scene, 3.0), settings=replace(settings, duration=1e-3, output_step=1e-3)))
    np.testing.assert_allclose(fast["bodies/position"][-1], slow["bodies/position"][-1], atol=1e-9)


def test_all_methods_run_with_the_scenes_own_schedule():
    """A projection after every hundredth step leaves the joints open, whichever the method."""
    options = {"projection": "gopm", "every": "100", "duration": "2"}
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml", {}, options)
    found = stability(scene, "step", projections=["gopm", "gpopm"], low=0.009, high=0.01, points=2, processes=1)
    for track in found.tracks:
        assert min(point.closure for point in track.points) > 1e-6


def test_values_are_even_and_have_the_scenes_own():
    assert values(ValueSpan(1e-2, 1.0, 1e2), 5) == pytest.approx([1e-2, 1e-1, 1.0, 10.0, 100.0])
    assert 3.0 in values(ValueSpan(1e-2, 3.0, 1e2), 5)


def test_a_study_resumes(monkeypatch):
    from mbproj.studies import stability as bisection

    options = {"projections": ["gopm", "gpopm"], "points": 3, "processes": 1}
    scene = read_scene_text(PENDULUM)
    first = stability(scene, "duration", **options)
    monkeypatch.setattr(bisection, "_points_of", None)  # nothing is left to be run
    again = stability(scene, "duration", **options)
    assert again.tracks == first.tracks


@pytest.mark.parametrize(
    ("vary", "options", "said", "hint"),
    [
        ("stifness", {}, "unknown quantity 'stifness'", "did you mean 'stiffness'"),
        ("stiffness", {}, "no force of the scene has a 'stiffness' to vary", "add a spring_damper"),
        ("speed", {}, "the scene starts at rest and has no motions", "give a joint a 'speed'"),
        ("mass-ratio", {}, "no two bodies are joined to each other", "vary something else"),
        ("penalty", {"projections": ["gpopm"]}, "'gpopm' has no 'alpha' to vary", "mass-orthogonal, mmopm"),
        ("step", {"projections": ["gpom"]}, "unknown projection method 'gpom'", "did you mean 'gpopm'"),
        ("step", {"low": 1.0, "high": 0.1}, "there is nothing between 1 and 0.1", "let --from be below --to"),
    ],
)
def test_what_a_scene_does_not_have(vary, options, said, hint):
    with pytest.raises(InputError) as caught:
        stability(read_scene_text(PENDULUM), vary, **options)
    (problem,) = caught.value.problems
    assert said in problem.message
    assert hint in problem.hint


@pytest.mark.parametrize(("vary", "low", "high"), [("step", 1e-49, 1e49), ("duration", 1.0, 1e49)])
def test_runs_that_would_not_end_are_refused(vary, low, high):
    with pytest.raises(InputError, match=r"a run of .* would take .*e\+\d\d steps, and at most 1e\+08 are made"):
        stability(SLIDER_CRANK, vary, low=low, high=high, points=2, processes=1)


@pytest.mark.parametrize(
    ("name", "vary", "least"),
    [
        ("five_bar", "mass-ratio", 12),
        ("five_bar", "length-scale", 8),
        ("five_bar", "parameters.length", 8),
        ("spatial_slider_crank", "speed", 8),
    ],
)
def test_values_of_a_block_have_the_points_that_each_has_alone(name, vary, least):
    """A run that does not come to its end goes alone; so does each with a setting of its own."""
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml", {}, {"duration": "1"})
    subject, quantity = Subject(scene, Setting.of(scene.settings), 1.0, Limits()), quantity_named(vary)
    span = quantity.span(subject)
    grid = values(span, 12)
    found = judged_in_blocks(partial(quantity.changed, subject), grid)
    assert len(found) >= least
    for number, point in found.items():
        alone = judged(quantity.changed(subject, grid[number]), grid[number])
        assert repr(point) == repr(alone)
    step = QUANTITIES["step"]
    assert judged_in_blocks(partial(step.changed, subject), values(step.span(subject), 12)) == {}


# Limits of parameters beyond which small motions grow: sampled controllers and springs, against closed forms.

CART = """
mbproj: 1
gravity: [0, 0, 0]
parameters: {T: 50 ms, none: 0, d: 8}
simulation: {duration: 0.2 s, step: 10 ms}
bodies:
  cart: {mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.1}
controllers:
  pd: {period: T, hold: {u: -80*rail.displacement - d*rail.displacement_dot}}
forces:
  drive: {type: linear_spring_damper, joint: rail, force: pd.u}
"""
CONTROLLED_PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {k: 30}
simulation: {duration: 0.1 s, step: 10 ms}
bodies:
  rod: {mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.5]}
joints:
  pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  spring: {type: torsion_spring_damper, joint: pin, stiffness: k, damping: 0.1}
"""


def small_motions(text, vary, **options):
    """The track of them, in a map with a method's own."""
    found = stability(read_scene_text(text), vary, projections=["gpopm"], points=3, processes=1, **options)
    small, method = found.tracks
    assert (small.method, method.method) == ("small motions", "gpopm")
    assert [point.state for point in method.points] == ["holds"] * 3
    return found, small


@pytest.mark.full
def test_the_limit_of_a_period_is_that_of_the_discrete_equations():
    """A mass m with u = -k x - d x' held over T: the eigenvalues of its matrix are below 1 up to T = 2 d/k."""
    found, small = small_motions(CART, "parameters.T", low=0.15, high=0.3)
    (change,) = small.changes
    assert change.value == pytest.approx(2 * 8 / 80, rel=1e-7)
    assert (found.unit, change.below.state, change.above.state) == ("s", "holds", "fails")
    assert "small motions 0.2000000" in found.line
    assert small.points[-1].cause.startswith("a small motion grows by 0.")


def test_the_limit_of_a_spring_that_holds_a_pendulum_upright():
    (change,) = small_motions(CONTROLLED_PENDULUM, "parameters.k", low=5.0, high=20.0)[1].changes
    assert change.value == pytest.approx(2 * 9.81 * 0.5, rel=1e-7)
    assert (change.below.state, change.above.state) == ("fails", "holds")


def rounds(text):
    scene = read_scene_text(text)
    system = compile_system(scene)
    return round_of(reference_at(system, start_state(scene, system), "start"))


def test_a_round_of_two_controllers_is_the_product_of_what_they_do():
    """Periods of 20 and 30 ms, and what the second computes stands 5 ms later: a round is 60 ms."""
    second = "  slow: {period: 30 ms, delay: 5 ms, hold: {w: -3*pd.u - 2*rail.displacement}}\n"
    text = (
        CART.replace("T: 50 ms", "T: 20 ms").replace("forces:", f"{second}forces:").replace(" pd.u}", " pd.u + slow.w}")
    )
    found = rounds(text)
    A = np.zeros((5, 5))  # place, speed, u, w, and w as computed
    A[0, 1], A[1, 2], A[1, 3] = 1.0, 0.5, 0.5
    pd, slow, stands = np.eye(5), np.eye(5), np.eye(5)
    pd[2] = [-80, -8, 0, 0, 0]
    slow[4] = [-2, 0, -3, 0, 0]
    stands[3] = [0, 0, 0, 0, 1]
    order = [(0.005, [stands]), (0.02, [pd]), (0.03, [slow]), (0.035, [stands]), (0.04, [pd]), (0.06, [pd, slow])]
    expected, at = np.eye(5), 0.0
    for time, actions in order:
        expected = expm(A * (time - at)) @ expected
        for action in actions:
            expected = action @ expected
        at = time
    assert found.time == pytest.approx(0.06, rel=1e-15)
    of = np.sort_complex(np.linalg.eigvals(expected))
    np.testing.assert_allclose(np.sort_complex(found.multipliers), of, atol=1e-7)
    np.testing.assert_allclose(found.multipliers[:2], of[np.argsort(-np.abs(of))][:2], rtol=1e-12)


WRONG = {
    "no": (CART, "parameters.Q", "the scene has no parameter 'Q'; parameters are: T, none, d"),
    "zero": (CART, "parameters.none", "parameter 'none' is 0, and values are varied by their logarithms"),
    "path": (CART, "parametrs.T", "did you mean 'parameters.NAME'"),
}


@pytest.mark.parametrize("case", WRONG)
def test_mistakes_are_told(case):
    text, vary, message = WRONG[case]
    with pytest.raises(InputError, match=message):
        stability(read_scene_text(text), vary, points=2, processes=1)


def test_what_has_no_round_is_told():
    with pytest.raises(InputError, match="the scene has no controller"):
        rounds(CONTROLLED_PENDULUM)
    other = "  odd: {period: 0.0314159 s, hold: {w: 0}}\n"
    with pytest.raises(InputError, match="no short common multiple"):
        rounds(CART.replace("forces:", f"{other}forces:"))
    with pytest.raises(InputError, match=r"what sets 'pd\.u' has a kink"):
        rounds(CART.replace("u: -80*rail", "u: abs(rail.displacement - 0.1) - 80*rail"))
