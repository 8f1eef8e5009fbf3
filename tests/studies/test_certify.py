"""The trust horizon is where the true error says, or in a range that holds."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import SimulationError, read_scene, read_scene_text, settings_to_run
from mbproj.base.mechanisms_folder import mechanism
from mbproj.commands.report.summary import lines_on
from mbproj.results.analysis.trust import Growth
from mbproj.studies.certify import certify, ladder, simulate_certified, trust_of
from mbproj.studies.measure.reference import perturbed
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Mechanism, sample_times, solve
from tests.crossed import once
from tests.integrate.event_scenes import TROLLEY
from tests.support import ROOT, Recorder

EXACT = np.genfromtxt(ROOT / "tests" / "data" / "five_bar.csv", delimiter=",", skip_header=1)
#: The error of the five-bar's exact solution, m: 1e-13 at 5 s, 1e-9 at 10 s.
LEFT = 1e-13 * np.exp(np.log(1e4) / 5.0 * (EXACT[:, 0] - 5.0))


class Kept(Recorder):
    """A recorder of blocks and of the certificate."""

    def trust(self, trust):
        self.certificate = trust


def certified(name, limits, **simulation):
    scene = read_scene(mechanism(name), {}, simulation)
    recorder = Kept()
    _, trust = simulate_certified(Mechanism.of(scene), settings_to_run(scene), recorder, limits=limits)
    assert trust is recorder.certificate
    return recorder, trust


@pytest.mark.full
def test_the_five_bar_at_the_papers_settings_is_8_mm_off_at_5_s_and_a_metre_at_8():
    _, trust = certified("five_bar", [7e-3], formulation="full", duration=5.1)
    at = np.searchsorted(trust.time, 5.0 - 1e-9)
    assert trust.error[at, 0] == pytest.approx(7.9e-3, rel=0.02)
    assert trust.horizon[0, 0] == pytest.approx(4.95, abs=0.1)
    _, trust = certified("five_bar", [1.0], duration=10)
    assert trust.horizon[0, 0] == pytest.approx(8.05, abs=0.05)
    assert trust.growth_law == ("exponential",)
    assert 1.5 < trust.growth_rate[0] < 2.5


@pytest.fixture(scope="module")
def truths():
    """Exact enough solutions by another method, step control and formulation than those of the certificate."""
    found = {}
    for name, step, until in (("five_bar", 5e-4, 8.0), ("spatial_slider_crank", 5e-4, 10.0)):
        ready = Mechanism.of(read_scene(mechanism(name)))
        times = sample_times(until, round(until / 0.01))
        found[name] = solve(ready, Setting(integrator="dopri5", step=step, formulation="reduced"), times).position
    return found


@pytest.mark.parametrize(
    ("name", "simulation"),
    [
        ("five_bar", {"step": 0.01, "duration": 8}),
        ("five_bar", {"step": 0.01, "duration": 8, "projection": "none"}),
        ("five_bar", {"step": 0.005, "duration": 8, "integrator": "heun2", "output_step": 0.01}),
        ("five_bar", {"tolerance": 1e-6, "duration": 8, "integrator": "bs32", "output_step": 0.01}),
        ("five_bar", {"tolerance": 1e-7, "duration": 8, "integrator": "dop853", "output_step": 0.01}),
        ("spatial_slider_crank", {"step": 0.01}),
        ("spatial_slider_crank", {"tolerance": 1e-5, "integrator": "dopri5", "output_step": 0.01}),
    ],
)
def test_horizons_are_within_a_tenth_of_the_true_ones(truths, name, simulation):
    limits = np.array([1e-5, 1e-4, 1e-3, 1e-2])
    recorder, trust = certified(name, limits, **simulation)
    path = recorder["markers/position"][:, 0]
    error = np.linalg.norm(path - truths[name][: len(path), 0], axis=1)
    for limit, horizon, low, high in zip(
        limits, trust.horizon[0], trust.horizon_low[0], trust.horizon_high[0], strict=True
    ):
        exceeded = trust.time[error > limit]
        true = exceeded[0] if len(exceeded) else np.inf
        assert horizon == pytest.approx(true, rel=0.1, abs=0.01)
        assert low <= true <= high


@pytest.mark.parametrize(("tolerance", "formulation"), once([1e-10, 1e-12, 1e-13, 1e-14], ["auto", "reduced"]))
def test_near_round_off_the_ranges_hold(tolerance, formulation):
    simulation = {"tolerance": tolerance, "integrator": "dop853", "output_step": 0.5, "formulation": formulation}
    limits = np.array([1e-12, 1e-11, 1e-10, 1e-9, 1e-8])
    recorder, trust = certified("five_bar", limits, **simulation)
    error = np.linalg.norm(recorder["markers/position"][:, 0, ::2] - EXACT[:, 1:3], axis=1)
    for limit, low, high in zip(limits, trust.horizon_low[0], trust.horizon_high[0], strict=True):
        can, must = (trust.time[bound > limit].min(initial=np.inf) for bound in (error + LEFT, error - LEFT))
        assert low <= must
        assert can <= high
    if tolerance <= 1e-12:
        assert "round-off" in trust.remark


def test_the_better_solution_is_always_better():
    for simulation in ({"step": 0.01}, {"tolerance": 1e-3}, {"tolerance": 1e-9}, {"tolerance": 1e-13}):
        settings = settings_to_run(read_scene(mechanism("free_body"), {}, {"integrator": "dop853", **simulation}))
        rungs = list(ladder(settings))
        assert rungs == sorted(rungs, reverse=True)
        assert rungs[-1] == 1e-14
        assert rungs[0] <= min(1e-8, 0.1 * (settings.tolerance or 1.0))


def test_a_perturbed_start_differs_by_round_off_and_is_consistent():
    ready = Mechanism.of(read_scene(mechanism("five_bar")))
    other = perturbed(ready, 1)
    apart = np.abs(other.state.q - ready.state.q).max()
    assert 1e-16 < apart < 1e-14
    np.testing.assert_array_equal(perturbed(ready, 1).state.q, other.state.q)


FAILING = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 3, step: 0.01}
bodies: {crank: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.5, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}}
forces: {w: {type: torque, body: crank, torque: [0, sqrt(1.5 - t), 0]}}
"""


def test_a_run_that_fails_is_certified_up_to_there():
    scene, recorder = read_scene_text(FAILING), Kept()
    with pytest.raises(SimulationError, match=r"at t = 1\.50"):
        simulate_certified(Mechanism.of(scene), settings_to_run(scene), recorder)
    trust = recorder.certificate
    assert trust.names == ("crank",)
    assert trust.time[-1] == pytest.approx(1.5)
    assert np.all(np.isfinite(trust.error))


def test_where_the_better_solution_fails_nothing_is_certified_after_it():
    scene = read_scene_text(FAILING)
    ready, times = Mechanism.of(scene), sample_times(3.0, 300)
    still = np.broadcast_to(ready.state.q[:3], (301, 1, 3))
    trust = certify(ready, settings_to_run(scene), times, still, [100.0])
    assert "the better solution stopped at t = 1.5" in trust.remark
    assert trust.horizon_low[0, 0] == pytest.approx(1.5, abs=0.011)
    assert trust.horizon_high[0, 0] == np.inf
    assert trust.untrusted_from(100.0) == trust.horizon_low[0, 0]
    np.testing.assert_array_equal(np.linalg.norm(still - trust.better.position, axis=-1), trust.error)
    assert np.isnan(trust.better.orientation[-1]).all()
    turned = trust.better.orientation[:150]
    np.testing.assert_allclose(np.linalg.norm(turned, axis=-1), 1.0, atol=1e-12)


def test_a_move_between_two_rests_is_right_and_certified():
    """The load rests until 3 s. The better solution and its check do not pass over the move of 0.2 s either."""
    mechanism = Mechanism.of(read_scene_text(TROLLEY))
    settings, times = settings_to_run(mechanism.scene), sample_times(10.0, 10)
    _, trust = simulate_certified(mechanism, settings)
    own = solve(mechanism, Setting.of(settings), times)
    fine = solve(mechanism, Setting(integrator="rk4", step=2e-3), times)
    off = np.abs(own.marker_position - fine.marker_position).max()
    assert 0.2 < np.abs(fine.marker_position[5:, 0, 0] - 0.5).max() < 0.5
    assert off < 1e-7
    assert trust.error.max() < 1e-7 and trust.uncertainty.max() < 1e-9


def test_points_that_do_not_move_say_nothing_of_a_wheel_that_turns():
    """Its error was 0 m at its centre, with Heun's method and long steps too."""
    wheel = """
mbproj: 1
gravity: [0, 0, 0]
bodies:
  wheel: {mass: 1, inertia: [0.1, 0.1, 0.2], position: [0, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0], angle: 1, speed: 2}
forces:
  spring: {type: torsion_spring_damper, joint: pin, stiffness: 5}
simulation: {duration: 2, step: 0.1, integrator: heun2}
"""
    rim = "markers: {rim: {body: wheel, location: [0.3, 0, 0]}}\n"
    lines = []
    for text in (wheel, wheel + rim):
        scene = read_scene_text(text)
        _, trust = simulate_certified(Mechanism.of(scene), settings_to_run(scene))
        lines.append("\n".join(lines_on(trust)))
    assert "no figure: errors are measured at the centres of mass" in lines[0]
    assert "put a marker on a body that turns" in lines[0]
    assert "no figure" not in lines[1]
    assert 1e-4 < np.nanmax(trust.error[np.isfinite(trust.error)]) < 1.0


def test_it_takes_the_arguments_of_simulate():
    """With the scene of the system, by position and by name, the certificate is that of the mechanism."""
    scene = read_scene(mechanism("five_bar"), {}, {"duration": 0.2})
    ready, settings = Mechanism.of(scene), settings_to_run(scene)
    report, trust = simulate_certified(ready.system, ready.state, settings, scene=scene, limits=[1e-3])
    assert report.state.t == pytest.approx(0.2)
    by_name = simulate_certified(system=ready.system, state=ready.state, settings=settings, scene=scene, limits=[1e-3])
    for other in (by_name[1], simulate_certified(ready, settings, limits=[1e-3])[1]):
        np.testing.assert_array_equal(trust.error, other.error)
    with pytest.raises(TypeError, match="lacks the argument 'scene'"):
        simulate_certified(ready.system, ready.state, settings)


def test_what_the_better_solution_may_be_off_counts_against_the_run():
    """An error of 1 mm a second and an uncertainty of 0.5 mm reach 2.05 mm at 1.6 s, the error alone at 2.1 s."""
    times = np.linspace(0.0, 3.0, 31)
    error = 1e-3 * times[:, None]
    trust = trust_of(("tip",), times, error, np.full_like(error, 5e-4), [2.05e-3], [Growth()], "", "")
    assert trust.untrusted_from(2.05e-3) == pytest.approx(1.6)
