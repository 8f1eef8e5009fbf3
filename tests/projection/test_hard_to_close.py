"""Positions that are hard to close: damped corrections, what becomes of a failure, round-off of long chains."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

from mbproj import Report, Scene
from mbproj.base.arrays import Array
from mbproj.base.errors import SimulationError
from mbproj.base.registry import PROJECTIONS
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_at, jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.equations.of_motion import mass_matrix
from mbproj.equations.rank.row_policy import RowSet
from mbproj.kernel import core
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.model.system import System
from mbproj.motion.formulations.reduced import InPlane, Reduced
from mbproj.motion.projection import correct_position, damped, make_method
from mbproj.motion.simulate import simulate
from mbproj.scene.records import Body, Joint, Pair
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.support import Recorder, assembled, scene_of

# Planar chains of five bars of 1 m whose masses alternate while their moments are alike, with open joints.
#
# Heavy bars that turn easily leave closing the joints to turns about their centres. Where two of these are further
# apart than the bars between them reach, turns alone cannot close them, and Newton's method without damping fails in
# one of seven random poses from a mass ratio of 1e6 on.

#: mbproj.motion.projection's methods that have a penalty need one to suit the masses.
PENALISED = ("mass-orthogonal", "mmopm")
BARS = 5
AXIS = (0.0, 1.0, 0.0)


def uneven_chain(ratio: float, seed: int, open_by: float = 1e-2) -> tuple[System, Plane, Array]:
    """A chain in a random pose, its plane, and q (7n,) with the bars off by `open_by`, in m and rad."""
    rng = np.random.default_rng(seed)
    bodies, joints, end, below = [], [], np.zeros(3), "ground"
    for number, angle in enumerate(rng.uniform(0.0, 2.0 * np.pi, size=BARS)):
        along = np.array([np.sin(angle), 0.0, np.cos(angle)])
        at, centre = ((float(x), 0.0, float(z)) for x, _, z in (end, end + 0.5 * along))
        turn = (float(np.cos(0.5 * angle)), 0.0, float(np.sin(0.5 * angle)), 0.0)
        moments = ((1 / 12, 0.0, 0.0), (0.0, 1 / 12, 0.0), (0.0, 0.0, 1 / 12))
        bodies.append(Body(f"bar{number}", 1.0 if number % 2 else ratio, moments, centre, turn))
        joints.append(Joint(f"J{number}", "revolute", (below, f"bar{number}"), Pair(at, at), Pair(AXIS, AXIS)))
        end, below = end + along, f"bar{number}"
    system = compile_system(scene_of(bodies, joints))
    q = np.array([[*body.position, *body.orientation] for body in bodies]).ravel()
    plane = planar_reduction(system, q)
    assert isinstance(plane, Plane)
    p, u = plane.reduce(q, np.zeros_like(q))
    return system, plane, plane.expand(p + open_by * rng.normal(size=p.shape), u, np.zeros_like(u))[0]


def suited(method: str, ratio: float, **keys: object) -> ProjectionSettings:
    """A method's settings for masses up to `ratio` kg."""
    alpha = max(1e7, 1e2 * ratio) if method in PENALISED else None
    return ProjectionSettings(method=method, **{"alpha": alpha, **keys})


# Where bodies are asked for turns that the linearised rows promise too much of: the corrections are damped.

#: With Euler parameters M is singular, so that popm is no method of the full formulation.
METHODS = [name for name, entry in PROJECTIONS.items() if entry.corrects and name != "popm"]
COMPILED = [name for name, entry in PROJECTIONS.items() if entry.corrects and entry.compiled]
#: Random poses by seed: of the second, Newton's method without damping fails from a mass ratio of 1e4 on.
EASY, HARD = (0, 1, 3), (28, 49, 54, 80, 88, 95)
ONE_HARD = [HARD[0], *map(full, HARD[1:])]
SEEDS = [pytest.param((EASY[0], HARD[0]), id="few"), full((*EASY[1:], *HARD[1:]), id="many")]
RATIOS = (1.0, 1e4, 1e8, 1e12)


def closed(method: str, ratio: float, seed: int):
    """The chain's projection and what it leaves open."""
    system, _, q = uneven_chain(ratio, seed)
    settings = suited(method, ratio)
    found = correct_position(system, make_method(settings), settings, RowSet.regular(system), q)
    return found, np.abs(constraint_at(system, found.q)).max()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("seeds", SEEDS)
def test_every_method_closes_uneven_chains(method, ratio, seeds):
    """Few passes do: every one brings the violation down by half at least, and by its square at last."""
    for seed in seeds:
        found, violation = closed(method, ratio, seed)
        assert found.met, seed
        assert violation <= 1e-13
        assert found.passes <= 12


@pytest.mark.parametrize("method", ["mass-orthogonal", "mmopm", "gpopm", "gpopm-pinv"])
@pytest.mark.parametrize("seed", ONE_HARD)
def test_newtons_method_alone_does_not_close_them(method, seed):
    """In the metrics by masses; so that the test above needs the damping."""
    ratio = 1e8
    system, _, q = uneven_chain(ratio, seed)
    for _ in range(25):
        pose = pose_of(q)
        C, C_q = constraint_at(system, q), jacobian(system, pose)
        q = q + make_method(suited(method, ratio)).correction(mass_matrix(system, pose), C_q, C)
    assert not np.abs(constraint_at(system, q)).max() < 1e-6


@needs_kernel
@pytest.mark.parametrize("method", COMPILED)
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("seeds", SEEDS)
def test_the_kernel_closes_uneven_chains(method, ratio, seeds):
    for seed in seeds:
        system, plane, q = uneven_chain(ratio, seed)
        for coordinates in (Reduced(core(), system), InPlane(core(), system, plane)):
            equations = coordinates.equations(suited(method, ratio))
            closed = equations.corrected(coordinates.state(q, np.zeros_like(q)))
            assert np.abs(equations.constraint(closed)).max() <= 1e-13, seed


@needs_kernel
@pytest.mark.parametrize("method", [name for name in COMPILED if name != "gopm"])
@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_newtons_method_alone_does_not_in_the_kernel(formulation, method):
    """`newton` is a correction as it is."""
    system, plane, q = uneven_chain(1e4, 54)
    coordinates = Reduced(core(), system) if formulation == "reduced" else InPlane(core(), system, plane)
    equations, alone = coordinates.equations(suited(method, 1e4)), coordinates.state(q, np.zeros_like(q))
    for _ in range(25):
        alone = equations.newton(alone)
    assert not np.abs(equations.constraint(alone)).max() < 1e-6


def corrections(method: str, ratio: float, seed: int):
    """M, C_q, C, and the corrections to try, with the turn that each asks of each bar, (5,)."""
    system, _, q = uneven_chain(ratio, seed)
    pose = pose_of(q)
    M, C_q, C = mass_matrix(system, pose), jacobian(system, pose), constraint_at(system, q)
    tried = list(damped(make_method(suited(method, ratio)), M, C_q, C, q))
    turns = [
        2.0 * np.linalg.norm((pose.L[:-1] @ change.reshape(-1, 7)[:, 3:, None])[..., 0], axis=-1) for change, _ in tried
    ]
    return M, C_q, C, tried, np.array(turns)


@pytest.mark.parametrize("seed", ONE_HARD)
def test_corrections_turn_less_and_less_and_close_the_rows_to_first_order(seed):
    """Those that are not shortened; what then is shortened is the whole."""
    _, C_q, C, tried, turns = corrections("gpopm", 1e8, seed)
    widest = np.array([turn.max() for turn, (_, part) in zip(turns, tried, strict=True) if part == 1.0])
    assert len(widest) >= 4
    assert widest[0] <= THRESHOLDS.widest_turn
    assert np.all(widest[1:] <= 0.25 * widest[:-1])
    for change, part in tried:
        np.testing.assert_allclose(C_q @ change, -part * C, rtol=0, atol=1e-6 * np.abs(C).max())


@pytest.mark.parametrize("seed", ONE_HARD)
def test_what_turns_less_is_the_smallest_in_energy_that_does(seed):
    """The conditions of min ½ΔᵀMΔ subject to C_qΔ = -C and bounds on |δθ_b|: in the null space of C_q, MΔ is balanced
    by moments against the turns, E_b Δ, with multipliers μ_b that pull back and never push."""
    M, C_q, _, tried, turns = corrections("gpopm", 1e8, seed)
    N = np.linalg.svd(C_q)[2][len(C_q) :].T
    for change, _ in tried[1:4]:  # the first may be the whole, without bounds
        against = np.zeros((len(change), len(turns[0])))
        for bar in range(len(turns[0])):
            of_bar = slice(7 * bar + 3, 7 * bar + 7)
            against[of_bar, bar] = change[of_bar]
        multipliers, *_ = np.linalg.lstsq(N.T @ against, -(N.T @ M @ change), rcond=None)
        left = N.T @ (M @ change + against @ multipliers)
        assert np.abs(left).max() <= 1e-6 * np.abs(M @ change).max()
        assert multipliers.max() > 0.0
        assert multipliers.min() >= -1e-6 * multipliers.max()


def test_gopm_knows_no_masses_and_is_shortened():
    *_, tried, _ = corrections("gopm", 1e8, HARD[0])
    parts = [part for _, part in tried]
    assert parts[:3] == [1.0, 0.5, 0.25]
    for change, part in tried:
        np.testing.assert_allclose(change, part * tried[0][0], rtol=1e-14)


def test_what_turns_nothing_is_not_asked_to_turn_less():
    """A correction that shifts a body alone, and by round-off turns it a little when it is asked again."""

    class Shift:
        calls = 0

        def correction(self, M, C_q, violation):
            self.calls += 1
            return np.array([1.0, 0.0, 0.0, 0.0, 1e-20 * (self.calls > 1), 0.0, 0.0])

    q = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parts = [part for _, part in damped(Shift(), np.eye(7), np.eye(7), q, q)]
    assert parts[0] == 1.0 and parts == sorted(parts, reverse=True)


# What becomes of a position that a method does not close: the run stops, or takes GOPM's metric where that is allowed.
#
# The mass-orthogonal projection with a penalty far below the masses leaves most of a violation at each pass.

FORMULATIONS = ["full", *(["reduced", "planar"] if core() is not None else [])]
SOFT = {"method": "mass-orthogonal", "alpha": 1.0}
STEP = 1e-3


def after_one_step(formulation: str, **projection: object) -> tuple[Report, Recorder]:
    """A step from rest of a chain with masses 1e6 apart whose joints are open by some hundredths of a metre."""
    system, _, q = uneven_chain(1e6, 0)
    state = State.of(system, 0.0, positions=q, velocities=np.zeros_like(q))
    settings = Settings(duration=STEP, step=STEP, formulation=formulation, projection=ProjectionSettings(**projection))
    recorder = Recorder()
    return simulate(system, state, settings, recorder), recorder


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_without_a_fallback_the_run_stops_and_says_what_may_help(formulation):
    with pytest.raises(SimulationError) as caught:
        after_one_step(formulation, **SOFT)
    error = caught.value
    assert error.time == STEP
    assert re.fullmatch(r"joint 'J\d'", error.where)
    assert re.fullmatch(r"the projection did not close it: \S+ is left after \d+ passes", error.cause)
    assert error.hint.endswith("where masses differ widely, --projection-fallback gopm may help")


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_with_the_fallback_it_begins_again_in_gopms_metric_and_counts(formulation):
    """From where the method began: the state is GOPM's own, to round-off."""
    report, recorder = after_one_step(formulation, **SOFT, fallback="gopm")
    assert (report.counters["projection_fallbacks"], report.counters["projection_failures"]) == (1, 0)
    assert recorder["diagnostics/position_violation"][-1] <= 1e-13
    expected = after_one_step(formulation, method="gopm")[1]
    for path in ("bodies/position", "bodies/orientation"):
        np.testing.assert_allclose(recorder[path], expected[path], rtol=0, atol=1e-14)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_method_that_converges_has_no_use_for_it(formulation):
    report, recorder = after_one_step(formulation, method="gpopm", fallback="gopm")
    assert report.counters["projection_fallbacks"] == 0
    other = after_one_step(formulation, method="gopm")[1]
    assert np.abs(recorder["bodies/position"][-1] - other["bodies/position"][-1]).max() > 1e-3


# Chains whose far end closes no better than to round-off that is large at the near one: that is no failure.

Y = (0.0, 1.0, 0.0)


def chain(lengths: np.ndarray) -> Scene:
    """Rods that hang on each other in one line, in a plane; the first turns at 1 rad/s."""
    bodies, joints, above, depth = [], [], "ground", 0.0
    for number, length in enumerate(map(float, lengths)):
        name, moment, at = f"rod{number}", length * length / 12.0, (0.0, 0.0, -depth)
        moments = ((moment, 0.0, 0.0), (0.0, moment, 0.0), (0.0, 0.0, 0.01 * moment))
        bodies.append(Body(name, 1.0, moments, (0.0, 0.0, -depth - 0.5 * length)))
        speed = {} if number else {"angle": 1.0}
        joints.append(Joint(f"pin{number}", "revolute", (above, name), Pair(at, at), Pair(Y, Y), speed=speed))
        above, depth = name, depth + length
    return scene_of(bodies, joints)


@needs_kernel
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_each_step_of_a_chain_from_a_centimetre_to_a_kilometre_takes_one_factor_beyond_its_stages(formulation):
    """The last joints are 20 km away, where positions are known to 4e-12 m; the first are open by 1e-13 m at most."""
    system, state = assembled(chain(np.geomspace(1e-2, 1e3, 100)))
    steps = 200
    settings = Settings(duration=steps * 1e-3, step=1e-3, output_step=0.2, formulation=formulation)
    counters = simulate(system, state, settings).counters
    assert counters["projection_failures"] == 0
    assert counters["factorisations"] <= 4.2 * steps
