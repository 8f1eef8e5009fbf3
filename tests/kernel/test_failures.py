"""Runs in the kernel that do not reach their end: what stopped them, when, at which joint; Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from time import process_time, sleep

import numpy as np
import pytest

from mbproj import Scene, open_results
from mbproj.base.errors import SimulationError
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene
from tests.cli.commands import FIVE_BAR
from tests.kernel.scenes import assembled, needs_kernel, parallelogram
from tests.support import ROOT, Recorder, random_chain

pytestmark = needs_kernel
#: Crank, coupler and rocker in one line after 0.2 s at 2 rad/s: the coupler may then go on or fold back.
NEARLY_DEAD = float(np.pi / 2 - 0.4)


def run(scene: Scene, **keys):
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
    _, error = run(random_chain(12, ["revolute"] * 3), duration=50 * step, step=step, projection={"method": method})
    assert error.time <= 4 * step
    too_long = "at J1.angle: the step is too long to tell its turns: the rates lead "
    assert too_long in str(error) or "% at once: the step has lost the motion" in str(error)


def test_a_step_far_too_large_leaves_the_joints_open():
    """Balls have no angle that could be counted."""
    balls = random_chain(12, ["spherical"] * 3)
    _, error = run(balls, duration=1000.0, step=20.0, projection={"method": "none"})
    assert error.time <= 80.0
    assert "at joint 'J" in str(error)
    assert "it has drifted open by" in str(error)


@pytest.mark.filterwarnings("ignore:.*encountered in:RuntimeWarning")
@pytest.mark.parametrize("formulation", ["full", "reduced"])
def test_a_step_that_overflows_is_no_singular_position(formulation):
    _, error = run(random_chain(12, ["revolute"] * 3), duration=1e300, step=1e300, formulation=formulation)
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


def test_ctrl_c_on_the_command_line_keeps_the_results(tmp_path):
    """Exit code 130; without it the run would take hours."""
    program = [sys.executable, "-c", "from mbproj.commands.main import main; main()", "run", FIVE_BAR, "--quiet"]
    options = ["--duration", "1e6", "--step", "1e-4", "--output-step", "0.1"]
    process = subprocess.Popen(
        [*program, *options],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        text=True,
    )
    part = tmp_path / "results.h5.part"
    while not part.exists() and process.poll() is None:
        sleep(0.01)
    sleep(0.7)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=20)
    assert process.returncode == 130, stderr
    assert "Traceback" not in stderr
    kept = open_results(tmp_path / "results.h5").time
    assert len(kept) > 1
    np.testing.assert_allclose(np.diff(kept), 0.1, rtol=1e-9)
