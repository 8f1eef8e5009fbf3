"""Runs in the kernel: the same motion and the same bits, alone and in blocks, and how they fail."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from dataclasses import replace
from time import process_time
from typing import Any

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.errors import SimulationError
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.kernel import core
from mbproj.motion.formulations.choice import choose
from mbproj.motion.simulate import simulate
from mbproj.motion.steppers.tableau import load_tableau
from mbproj.scene.scene import read_scene, read_scene_text
from tests.cli.commands import FIVE_BAR
from tests.crossed import crossed, full
from tests.kernel.scenes import SCENES, bits, mechanism, needs_kernel, parallelogram, print_bits, run
from tests.support import MECHANISMS, ROOT, Recorder, assembled, random_chain

pytestmark = needs_kernel


# Runs in the kernel against the full formulation: the same motion, and the same bits each time.

TIGHT = {"tolerance": 1e-12, "integrator": "dop853"}
KERNEL = [("five_bar", "reduced"), ("five_bar", "planar"), ("spatial_slider_crank", "reduced")]


@pytest.fixture
def chain() -> Scene:
    return random_chain(12, ["revolute", "universal", "spherical"])


@pytest.mark.parametrize(
    ("name", "duration"), [("five_bar", 0.4), full("five_bar", 1.0), full("spatial_slider_crank", 0.4)]
)
def test_tight_trajectories_are_one_to_a_nanometre(name, duration):
    """Positions and reactions of all formulations, at output times inside steps and at their ends."""
    keys = {"duration": duration, "output_step": duration / 10, **TIGHT}
    exact, _ = run(mechanism(name), formulation="full", **keys)
    for formulation in [formulation for other, formulation in KERNEL if other == name]:
        found, report = run(mechanism(name), formulation=formulation, **keys)
        assert report.formulation == formulation
        np.testing.assert_array_equal(found["time"], exact["time"])
        for path, tolerance in {"bodies/position": 1e-9, "bodies/velocity": 1e-8, "joints/coordinate": 1e-8}.items():
            np.testing.assert_allclose(found[path], exact[path], rtol=0, atol=tolerance)
        size = np.abs(exact["joints/reaction_force"]).max()
        np.testing.assert_allclose(
            found["joints/reaction_force"], exact["joints/reaction_force"], rtol=0, atol=1e-7 * size
        )


@crossed("integrator, name, formulation", ["heun2", "rk4"], [pytest.param(*each) for each in KERNEL], together=1)
def test_the_difference_to_full_falls_with_the_order_of_the_integrator(name, formulation, integrator):
    order, difference = load_tableau(integrator).order, []
    for step in (0.005, 0.0025):
        keys = {"duration": 0.1, "step": step, "integrator": integrator, "output_step": 0.05}
        numpy, kernel = (run(mechanism(name), formulation=kind, **keys)[0] for kind in ("full", formulation))
        difference.append(np.abs(numpy["bodies/position"] - kernel["bodies/position"]).max())
    assert np.log2(difference[0] / difference[1]) > order - 0.5 or difference[0] < 1e-13
    assert difference[0] < 1e-4


def test_baumgarte_is_that_of_full_to_the_truncation_error(chain):
    """C'' + 2αC' + β²C = 0 with gains that differ, so that neither term can stand in for the other."""
    difference = []
    for step in (0.02, 0.01):
        keys = {"duration": 0.4, "step": step, "projection": {"method": "baumgarte", "gains": (20.0, 10.0)}}
        full, kernel = (run(chain, formulation=kind, **keys)[0] for kind in ("full", "reduced"))
        difference.append(np.abs(full["bodies/position"] - kernel["bodies/position"])[-1].max())
    assert np.log2(difference[0] / difference[1]) > 3.0
    assert difference[0] < 1e-6


def test_baumgarte_closes_an_open_joint_as_its_gains_say():
    """Critically damped, |C| falls as (1 + αt) exp(-αt) from a joint open by 1e-6."""
    system, state = assembled(random_chain(4, ["spherical"]))
    q = state.q.copy()
    q[:3] += 1e-6
    settings = Settings(duration=0.5, step=1e-3, projection=ProjectionSettings(method="baumgarte", gains=(25.0, 25.0)))
    recorder = Recorder()
    simulate(system, state.changed(positions=q), settings, recorder)
    rows = recorder["joints/violation"][:, 0]
    t = recorder["time"]
    np.testing.assert_allclose(rows, rows[0] * (1.0 + 25.0 * t) * np.exp(-25.0 * t), rtol=0, atol=2e-9)


def test_the_same_input_gives_the_same_bits(capsys):
    """Twice in one process, and in a fresh one."""
    runs = []
    for _ in range(2):
        print_bits()
        runs.append(capsys.readouterr().out)
    code = "from tests.kernel.scenes import print_bits; print_bits()"
    runs.append(
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True).stdout
    )
    assert len(set(runs[0].split())) == 3
    assert runs[0] == runs[1] == runs[2]


@pytest.mark.parametrize("way", [{"step": 0.01, "integrator": "rk4"}, {"tolerance": 1e-7, "integrator": "dop853"}])
@pytest.mark.parametrize("scene", ["five_bar", "loops 1", "star 0"])
def test_eq_75_a_run_with_popm_is_one_with_gpopm(scene, way):
    """Bit for bit."""
    found = [
        bits(run(SCENES[scene](), duration=0.1, output_step=0.05, projection={"method": method}, **way)[0].blocks)
        for method in ("popm", "gpopm", "gopm")
    ]
    assert found[0] == found[1] != found[2]


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_the_exact_motion_is_approached_with_the_order_of_the_integrator(formulation):
    """Each integrator by itself, in the kernel alone."""
    exact, _ = run(mechanism("five_bar"), duration=1.0, output_step=1.0, formulation=formulation, **TIGHT)
    for integrator in ("heun2", "rk4", "dopri5"):
        order, error = load_tableau(integrator).order, []
        for step in (0.01, 0.005):
            found, _ = run(
                mechanism("five_bar"), duration=1.0, step=step, integrator=integrator, formulation=formulation
            )
            error.append(np.abs(found["bodies/position"][-1] - exact["bodies/position"][-1]).max())
        assert np.log2(error[0] / error[1]) == pytest.approx(order, abs=0.6)


# Runs of a block advance in one call, each with the bits of the same run by itself, in whatever parts.

MOST, FOREVER = 2**31, 1e9
DOP853 = {"integrator": "dop853", "tolerance": 1e-8, "output_step": 0.013}
RK4 = {"integrator": "rk4", "step": 0.005, "output_step": 0.02}
RADAU = {"integrator": "radau5", "tolerance": 1e-6, "output_step": 0.05}


def run_of(scene: Scene, duration: float = 0.3, **keys: Any) -> Any:
    """A run of the kernel that has not begun."""
    system, state = assembled(scene)
    settings = Settings(projection=ProjectionSettings(method="gpopm"), duration=duration, **keys)
    compiled = choose(system, state, settings).compiled
    assert compiled is not None
    return compiled.run(state, settings)


def alike(name: str, count: int) -> list[Scene]:
    """A shipped mechanism under different gravity."""
    scene = read_scene(next(path for path in MECHANISMS if path.stem == name))
    return [replace(scene, gravity=tuple(g * factor for g in scene.gravity)) for factor in np.linspace(0.9, 1.1, count)]


def advanced(runs: Sequence[Any], most: int, seconds: float) -> tuple[list[list[Any]], int]:
    """The samples of each run in parts, and the number of calls."""
    running, parts, calls = core().Status.running, [[] for _ in runs], 0
    while any(run.outcome.status == running for run in runs):
        for own, part in zip(parts, core().advance_runs(list(runs), most, seconds), strict=True):
            own.append(part)
        calls += 1
        assert calls < 100_000
    return parts, calls


def assert_one_motion(run: Any, parts: Sequence[Any], other: Any) -> None:
    """The run, whose samples are in parts, is the other, which has not begun."""
    for name, expected in other.advance(MOST, FOREVER).items():
        np.testing.assert_array_equal(np.concatenate([part[name] for part in parts]), expected, name)
    assert run.outcome.status == other.outcome.status
    np.testing.assert_array_equal(run.counters, other.counters)
    np.testing.assert_array_equal(run.standing["y"], other.standing["y"])
    assert run.standing["t"] == other.standing["t"] and run.standing["turns"] == other.standing["turns"]


@crossed(
    "name, keys, most, seconds",
    ["five_bar", "spatial_slider_crank"],
    [pytest.param(DOP853, id="dop853"), pytest.param(RK4, id="rk4"), pytest.param(RADAU, id="radau5")],
    [pytest.param(*each) for each in ((MOST, FOREVER), (1, FOREVER), (3, FOREVER), (MOST, 1e-6), (2, 1e-6))],
    together=1,
)
def test_runs_of_a_block_have_the_bits_of_single_ones(name, keys, most, seconds):
    scenes = alike(name, 4)
    runs = [run_of(scene, **keys) for scene in scenes]
    parts, calls = advanced(runs, most, seconds)
    assert (calls == 1) == (most == MOST and seconds == FOREVER)
    for member, own, scene in zip(runs, parts, scenes, strict=True):
        assert member.outcome.status == core().Status.finished
        assert_one_motion(member, own, run_of(scene, **keys))


FAILING = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.3}
bodies:
  bar: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  f: {type: force, body: bar, force: [sqrt(END - t), 0, 0]}
"""


@crossed("failing, most, seconds", [0, 2, 4], [pytest.param(MOST, FOREVER), pytest.param(2, 1e-6)], together=1)
def test_a_run_that_fails_does_not_touch_the_others(failing, most, seconds):
    """Its force is the root of a negative number from 0.1 s on; it has the samples of before."""
    ends = [1.0 + each / 8.0 for each in range(5)]
    ends[failing] = 0.1
    scenes = [read_scene_text(FAILING.replace("END", repr(end))) for end in ends]
    runs = [run_of(scene, **RK4) for scene in scenes]
    parts, _ = advanced(runs, most, seconds)
    finished = core().Status.finished
    assert [run.outcome.status == finished for run in runs] == [number != failing for number in range(5)]
    assert np.concatenate([part["t"] for part in parts[failing]])[-1] == pytest.approx(0.08, abs=0.021)
    for member, own, scene in zip(runs, parts, scenes, strict=True):
        assert_one_motion(member, own, run_of(scene, **RK4))


def test_what_is_no_run_is_refused():
    with pytest.raises((TypeError, ValueError)):
        core().advance_runs([run_of(alike("five_bar", 1)[0], **RK4), None], MOST, FOREVER)


# Runs in the kernel that do not reach their end: what stopped them, when, at which joint; Ctrl-C.

#: Crank, coupler and rocker in one line after 0.2 s at 2 rad/s: the coupler may then go on or fold back.
NEARLY_DEAD = float(np.pi / 2 - 0.4)


def run_text(scene: Scene, **keys):
    """(recorder, SimulationError) of a run that must fail."""
    projection = ProjectionSettings(**keys.pop("projection", {}))
    recorder = Recorder()
    with pytest.raises(SimulationError) as caught:
        simulate(*assembled(scene), Settings(projection=projection, **keys), recorder)
    return recorder, caught.value


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_a_dead_pose_that_a_step_lands_on_is_passed_on_the_same_branch(formulation):
    """Without gravity the crank turns evenly, at 2 rad/s."""
    recorder = Recorder()
    settings = Settings(duration=1.0, step=0.01, formulation=formulation, integrator="dop853")
    simulate(*assembled(parallelogram(regular=True, angle=NEARLY_DEAD)), settings, recorder)
    np.testing.assert_allclose(recorder["joints/coordinate"][:, 0], 2.0 * recorder["time"], rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", ["none", "gpopm"])
@pytest.mark.parametrize("step", [1.0, 20.0, 1e6])
def test_a_step_far_too_large_cannot_count_the_turns_of_its_joints(step, method):
    _, error = run_text(
        random_chain(12, ["revolute"] * 3), duration=50 * step, step=step, projection={"method": method}
    )
    assert error.time <= 4 * step
    too_long = "at J1.angle: the step is too long to tell its turns: the rates lead "
    assert too_long in str(error) or "% at once: the step has lost the motion" in str(error)


def test_a_step_far_too_large_leaves_the_joints_open():
    """Balls have no angle that could be counted."""
    balls = random_chain(12, ["spherical"] * 3)
    _, error = run_text(balls, duration=1000.0, step=20.0, projection={"method": "none"})
    assert error.time <= 80.0
    assert "at joint 'J" in str(error)
    assert "it has drifted open by" in str(error)


@pytest.mark.filterwarnings("ignore:.*encountered in:RuntimeWarning")
@pytest.mark.parametrize("formulation", ["full", "reduced"])
def test_a_step_that_overflows_is_no_singular_position(formulation):
    _, error = run_text(random_chain(12, ["revolute"] * 3), duration=1e300, step=1e300, formulation=formulation)
    assert error.time == 1e300
    assert "the solution is no longer finite" in str(error)
    assert error.hint == "try a smaller step or tolerance"


FAST = {"duration": 1e6, "step": 1e-4, "output_step": 1e5}
DENSE = {"duration": 1.0, "tolerance": 1e-6, "integrator": "dop853", "output_step": 1e-6}


@pytest.mark.parametrize("keys", [FAST, DENSE], ids=["no output", "a million samples"])
def test_an_interrupted_run_stops_within_a_fifth_of_a_second(keys):
    """Of processor time, which a busy machine does not stretch: with nothing to record in sight, and with nothing but
    samples inside one step."""
    system, state = assembled(read_scene(FIVE_BAR))
    recorder, asked = Recorder(), []

    def interrupt():
        asked.append(process_time())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.3, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        simulate(system, state, Settings(**keys), recorder)
    waited = process_time() - asked[0]
    timer.join()
    assert waited < 0.2
    assert recorder["time"][0] == 0.0
