"""Runs in the kernel against the full formulation: the same motion, and the same bits each time."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from mbproj import Scene
from mbproj.integrate import load_tableau, simulate
from mbproj.scene import ProjectionSettings, Settings
from tests.crossed import crossed, full
from tests.kernel.scenes import SCENES, assembled, bits, mechanism, needs_kernel, print_bits, run
from tests.support import ROOT, Recorder, random_chain

pytestmark = needs_kernel
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
    scene = random_chain(4, ["spherical"])
    system, state = assembled(scene)
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
