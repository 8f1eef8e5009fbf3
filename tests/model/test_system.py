"""The System: the blocks of y, the layouts of primitives that scenes share, and what it keeps for the last state."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text
from mbproj.base.arrays import Array, cross
from mbproj.base.errors import SimulationError
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.assembly.assemble import State
from mbproj.equations.energy import kinetic_energy, potential_energy
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.linear.states import stored_state
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.model.system import System
from mbproj.motion.formulations import choice as module
from mbproj.motion.formulations.choice import choose
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.simulate import simulate
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from mbproj.scene.scene import read_scene
from tests.crossed import crossed, full
from tests.integrate.event_scenes import bounce
from tests.kernel.scenes import needs_kernel
from tests.model.element_scenes import DRIVEN, FORMULATIONS, T1, T2, case, run
from tests.support import ROOT, Recorder

# States of elements are a block of y: an entry of the layout alone has them recorded, continued, looked at for numbers
# that are not finite, and controlled in their errors.

#: A mass that bounces on a rigid stop.
HITS = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, output_step: 0.05}
bodies: {ball: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
joints:
  guide: {type: prismatic, bodies: [ground, ball], location: [0, 0, 0], axis: [0, 0, 1],
          limits: {displacement: {range: [-0.2, 9], rigid: true, restitution: 0.6}}}
"""
FIXED = {"integrator": "rk4", "step": "0.005"}
BY_ERROR = {"integrator": "dopri5", "tolerance": "1e-9"}


def brief(formulation):
    """How long runs take, s: the full formulation takes milliseconds a step."""
    return 0.4 if formulation == "full" else 1.0


def exact(t):
    """x and z of the lags in closed form, from 0 and 0.5."""
    gain = 1.0 / (1.0 + 1j * DRIVEN * T1)
    first = (gain * np.exp(1j * DRIVEN * t)).imag
    left = -gain.imag  # of what decays with T1
    share = left * T1 / (T1 - T2)  # z' = (x - z)/T2 with x = left exp(-t/T1)
    steady = gain / (1.0 + 1j * DRIVEN * T2)
    second = (steady * np.exp(1j * DRIVEN * t)).imag + share * np.exp(-t / T1)
    return np.stack([first + left * np.exp(-t / T1), second + (0.5 - second[0]) * np.exp(-t / T2)], axis=1)


@crossed("integrator, formulation", ["dop853", "dopri5", "esdirk4", "radau5"], FORMULATIONS, dear=["full"])
def test_lags_are_those_of_the_closed_form(formulation, integrator):
    tolerance = "1e-7" if integrator in ("esdirk4", "radau5") else "1e-9"
    options = {"formulation": formulation, "integrator": integrator, "tolerance": tolerance}
    _, found, _ = run(options)
    np.testing.assert_allclose(found["states/value"], exact(found["time"]), atol=30 * float(tolerance))


@pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS[1:]])
def test_fixed_steps_keep_their_order(formulation):
    errors = []
    for step in ("0.01", "0.005"):
        _, found, _ = run({"formulation": formulation, "integrator": "rk4", "step": step}, until=brief(formulation))
        errors.append(np.abs(found["states/value"] - exact(found["time"])).max())
    assert 3.7 < np.log2(errors[0] / errors[1]) < 4.3


@pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS[1:]])
def test_errors_of_states_are_controlled_by_their_scale(formulation):
    """A quick state holds the steps; one whose scale is large does not, nor do quadratures and followed angles."""
    steps = []
    for scale in (1.0, 1e6):
        quick = ("300*cos(300*t)", "0*x")
        options = {"formulation": formulation, "integrator": "dopri5", "tolerance": "1e-6"}
        report, found, _ = run(options, brief(formulation), texts=quick, start=(0.0, 0.0), scale=(scale, 1.0))
        steps.append(report.counters["steps"])
        error = np.abs(found["states/value"][:, 0] - np.sin(300.0 * found["time"])).max()
        assert (error < 1e-4) == (scale == 1.0)
    assert steps[0] > 5 * steps[1]


@pytest.mark.full_where(formulation="full")
@crossed(
    "options, formulation",
    [FIXED, BY_ERROR, BY_ERROR | {"integrator": "radau5", "tolerance": "1e-5"}],
    FORMULATIONS,
    dear=["full"],
)
def test_they_go_on_with_the_bits_of_one_long_run(formulation, options):
    assert_goes_on(options | {"formulation": formulation}, brief(formulation))


@pytest.mark.parametrize("integrator", ["dopri5", "auto"])
@pytest.mark.parametrize("text", [bounce(), HITS], ids=["kinks", "impacts"])
def test_they_go_on_across_events_and_methods(text, integrator):
    """The kink of a law, and a rigid stop between whose impacts are legs: the end of one is the start of the next."""
    assert_goes_on(BY_ERROR | {"integrator": integrator}, text=text)


def assert_goes_on(options, until=1.0, **own):
    (_, whole, _), (_, _, marks) = run(options, until, **own), run(options, 0.5 * until, **own)
    _, rest, _ = run(options, until, resumed=marks[-1], **own)
    np.testing.assert_allclose(whole["states/value"], exact(whole["time"]), atol=1e-3)
    first = int(np.searchsorted(whole["time"], marks[-1]["t"], side="right"))
    assert 0 < first < len(whole["time"])
    for path in whole.blocks[0]:
        np.testing.assert_array_equal(rest[path], whole[path][first:], err_msg=path)


def test_a_results_file_has_them(tmp_path):
    scene, system, state, settings = case(BY_ERROR)
    recorder = Recorder()
    with ResultsWriter(tmp_path / "found.h5", scene, system.names.as_mapping()) as writer:
        simulate(system, state, settings, writer)
    simulate(system, state, settings, recorder)
    with open_results(tmp_path / "found.h5") as results:
        assert results.names("states") == ("lag.x", "lag.z")
        assert results.names("state_units") == ("V", "A/s")
        np.testing.assert_array_equal(results["states/value"], recorder["states/value"])
        again = stored_state(system, results, 0.5)
        np.testing.assert_array_equal(again.x, results["states/value"][10])


@pytest.mark.full_where(formulation="full")
@crossed("options, formulation", [FIXED, BY_ERROR], FORMULATIONS, dear=["full"])
def test_a_rate_without_a_value_names_its_state(formulation, options):
    with pytest.raises(SimulationError, match=r"state 'lag\.z'.*sqrt"):
        run(options | {"formulation": formulation}, texts=("-x", "sqrt(0.5 - t)"))


def test_a_projection_moves_the_blocks_that_say_so():
    _, system, state, settings = case(FIXED | {"formulation": "full"})
    formulation = FullFormulation.of(system, state, settings)
    layout = formulation.layout
    y = layout.vector_of(state.layout.common_blocks(state.y, layout))
    y = y + 1e-3 * np.random.default_rng(0).normal(size=len(y))
    moved, _ = formulation.project_between(0.0, y)
    for block in layout.blocks:
        assert block.size
        assert np.array_equal(moved[layout[block.name]], y[layout[block.name]]) != block.projected


# What sets of primitives share: scenes that differ in numbers alone have one layout, which nobody can write to.

PENDULUMS = """
mbproj: 1
gravity: [0, 0, -9.8]
parameters: {length: 1 m, teeth: 20}
simulation: {duration: 1 s, step: 0.01 s}
bodies:
  upper: {mass: 1 kg, inertia: [0.1, 0.2, 0.3], position: [length / 2, 0, 0]}
  lower: {mass: 2 kg, inertia: [0.1, 0.2, 0.3], position: [1.5 * length, 0, 0]}
joints:
  hip: {type: revolute, bodies: [ground, upper], location: [0, 0, 0], axis: [1, 2, 2]}
  knee: {type: revolute, bodies: [upper, lower], location: [length, 0, 0], axis: [1, 2, 2]}
"""
GEAR = "  mesh: {type: gear, joints: [hip, knee], teeth: [teeth, 30]}\n"


def compiled(text: str = PENDULUMS, **parameters: float) -> System:
    return compile_system(read_scene_text(text, parameters=parameters))


def test_scenes_that_differ_in_numbers_share_their_layout() -> None:
    short, long = compiled(), compiled(length=3.0)
    assert short.joints.layout is long.joints.layout and short.coordinates.layout is long.coordinates.layout
    assert np.abs(long.joints.local - short.joints.local).max() > 0.9
    with pytest.raises(ValueError, match="read-only"):
        short.joints.body[0] = 1


def test_numbers_of_a_primitive_are_of_its_layout() -> None:
    text = PENDULUMS + GEAR
    coarse, fine, again = compiled(text), compiled(text, teeth=40), compiled(text)
    assert coarse.joints.layout is again.joints.layout is not fine.joints.layout
    assert coarse.couplings.weight.tolist() != fine.couplings.weight.tolist()


def samples(count: int) -> tuple[System, Plane, Array, Array, Array]:
    """Random motions of the pendulums in their plane, which stands at an angle."""
    system = compiled()
    plane = planar_reduction(system, initial_guess(read_scene_text(PENDULUMS), system).q)
    assert isinstance(plane, Plane)
    p, u, change = np.random.default_rng(1).normal(size=(3, count, 6))
    return system, plane, p, u, change


def test_samples_are_the_same_in_blocks_of_any_length() -> None:
    system, plane, p, u, change = samples(101)
    whole = plane.expand(p, u, change)
    energies = (
        kinetic_energy(system, pose := pose_of(whole[0]), twist_of(pose, whole[1])),
        potential_energy(system, pose),
    )
    for block in (slice(0, 1), slice(1, 4), slice(4, 101)):
        parts = plane.expand(p[block], u[block], change[block])
        assert all(np.array_equal(part, all_of_it[block]) for part, all_of_it in zip(parts, whole, strict=True))
        pose = pose_of(parts[0])
        assert np.array_equal(kinetic_energy(system, pose, twist_of(pose, parts[1])), energies[0][block])
        assert np.array_equal(potential_energy(system, pose), energies[1][block])


def test_what_is_expanded_is_reduced_again() -> None:
    _, plane, p, u, change = samples(50)
    p[:, 2::3] = np.remainder(p[:, 2::3], 4.0 * np.pi) - 2.0 * np.pi
    q, v, _ = plane.expand(p, u, change)
    back, rate = plane.reduce(q * np.tile([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0], 2), v)
    assert np.abs(back - p).max() < 1e-14
    assert np.abs(plane.reduce(q, v)[1] - u).max() < 4e-15 * np.abs(u).max()
    assert rate.shape == u.shape


def test_products_of_vectors_are_those_of_numpy() -> None:
    a, b = np.random.default_rng(2).normal(size=(2, 4, 5, 3))
    assert np.abs(cross(a, b[0]) - np.cross(a, b[0])).max() == 0.0
    assert cross(a[0, 0], 1j * b[0, 0]).dtype == complex


# What a system keeps: results for the last state asked for, which have the bits of a system that keeps nothing.

RUN = {"integrator": "dop853", "tolerance": 1e-7, "step": None, "duration": 0.05, "output_step": 0.01}


@pytest.fixture
def five_bar() -> tuple[System, State]:
    return assembled("five_bar")


def assembled(name: str) -> tuple[System, State]:
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml")
    system = compile_system(scene)
    return system, assemble(system, initial_guess(scene, system))


def test_a_result_is_kept_until_another_is_asked_for(five_bar):
    """An array that was changed in place is another one."""
    system, _ = five_bar
    calls, at = [], np.array([1.0, 2.0])

    def ask(*given: object) -> int:
        return system.cached("sum", given, lambda: calls.append(given) or len(calls))

    assert [ask(at, "a"), ask(at.copy(), "a"), ask(at, "b"), ask(at, "a")] == [1, 1, 2, 3]
    at[0] = np.nextafter(1.0, 2.0)
    assert ask(at, "a") == 4
    assert pickle.loads(pickle.dumps(system)).cached("sum", (at, "a"), lambda: "anew") == "anew"
    assert replace(system).cached("sum", (at, "a"), lambda: "anew") == "anew"


@needs_kernel
@pytest.mark.parametrize("name", ["five_bar", "bennett", "locomotive", "spatial_slider_crank"])
def test_a_second_run_chooses_by_what_the_first_has_found(name, monkeypatch):
    """It looks for no plane and no rows, and has the bits of a first run. The locomotive and the Bennett linkage have
    redundant rows."""
    system, state = assembled(name)
    settings = replace(read_scene(ROOT / "mechanisms" / f"{name}.yaml").settings, **RUN)

    def recorded(system: System) -> bytes:
        recorder = Recorder()
        simulate(system, state, settings, recorder)
        paths = ("bodies/velocity", "joints/reaction_force", "diagnostics/energy_balance")
        return b"".join(recorder[path].tobytes() for path in paths)

    first = recorded(system)
    looked = []
    for function in ("planar_reduction", "settle_rows"):
        own = getattr(module, function)
        monkeypatch.setattr(module, function, lambda *given, own=own: looked.append(given) or own(*given))
    assert recorded(system) == first
    assert not looked
    assert recorded(replace(system)) == first
    assert looked


@needs_kernel
def test_another_pose_or_projection_is_looked_at_anew(five_bar):
    system, state = five_bar
    settings = replace(read_scene(ROOT / "mechanisms" / "five_bar.yaml").settings, **RUN)
    first = choose(system, state, settings)
    beside = state.changed(positions=np.nextafter(state.q, 9.0))
    assert choose(system, beside, settings).compiled.plane is not first.compiled.plane
    other = replace(settings, projection=ProjectionSettings("gopm"))
    assert choose(system, state, other).compiled.settled == other.projection
    assert choose(system, state, settings).compiled.settled == settings.projection
