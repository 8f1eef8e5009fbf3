"""Trials of a search have the bits of a run alone, or follow the steps of another."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj import settings_to_run
from mbproj.base.errors import SimulationError
from mbproj.kernel import core
from mbproj.motion.kernel_run import FollowedSteps
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import SceneText
from mbproj.studies import case_blocks
from mbproj.studies.design.spec import read_spec
from mbproj.studies.design.trial import Wish, tried, tried_by_arrays
from mbproj.studies.measure.solve import MeasuredSamples, Mechanism
from tests.studies.design.scenes import FOUR_BAR, SPRING, written

# What a search shares between its runs leaves no trace in them: a trial has the bits of a run of its scene alone.

CASES = {
    "kinematic": (
        FOUR_BAR,
        "  parameters.crank: [0.15, 0.25]\n  parameters.px: [0, 0.4]\n  bodies.c.position.0: [0.79, 0.81]\n",
        "marker: tip",
        ("position_x (m)", lambda results: results.marker("tip").position[:, 0]),
    ),
    "integrated": (
        SPRING,
        "  parameters.mass: [1, 3]\n  parameters.stiffness: [20, 90]\n",
        "joint: rail, quantity: displacement",
        ("displacement (m)", lambda results: results.coordinate("rail.displacement").value),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_trial_has_the_bits_of_a_run_whatever_ran_before(case, tmp_path):
    scene, vary, of, (heading, seen) = CASES[case]
    with mbproj.run(mbproj.read_scene_text(scene)) as results:
        rows = "".join(f"{t!r},0.0\n" for t in results.time.tolist())
    (tmp_path / "wanted.csv").write_text(f"time (s),{heading}\n{rows}", encoding="utf-8")
    match = f"match: {{it: {{{of}, through: wanted.csv}}}}\n"
    wish = Wish.of(read_spec(written(tmp_path, scene, f"vary:\n{vary}{match}")))
    designs = np.random.default_rng(5).random((3, len(wish.paths)))
    there = [tried(wish, u).residuals for u in designs]
    back = [tried(wish, u).residuals for u in designs[::-1]][::-1]
    for u, first, second in zip(designs, there, back, strict=True):
        values = dict(zip(wish.paths, wish.values(u).tolist(), strict=True))
        with mbproj.run(mbproj.read_scene_text(scene, "scene", values)) as results:
            alone = seen(results)
        assert first.tolist() == second.tolist()
        assert first.tolist() == alone.tolist()


@pytest.mark.parametrize("case", CASES)
def test_designs_that_are_tried_by_arrays_have_the_bits_that_they_have_alone(case, tmp_path, monkeypatch):
    """Also those that do not close; and most of the others are run in groups. A constraint is of parameters."""
    scene, vary, of, (heading, _) = CASES[case]
    (tmp_path / "wanted.csv").write_text(f"time (s),{heading}\n0.0,0.0\n0.5,0.1\n1.0,0.2\n", encoding="utf-8")
    first = vary.split(".")[1].split(":")[0]
    wanted = (
        f"match: {{it: {{{of}, through: wanted.csv}}}}\n"
        f"subject_to: {{own: {{expression: {first}*{first}, at_most: 1}}}}\n"
    )
    wide = vary.replace("[0.15, 0.25]", "[0.15, 0.8]")
    wish = Wish.of(read_spec(written(tmp_path, scene, f"vary:\n{wide}{wanted}")))
    designs = [*np.random.default_rng(5).random((24, len(wish.paths)))]
    grouped = []

    def counted(*given, **further):
        rows = case_blocks.by_arrays(*given, **further)
        grouped.extend(rows)
        return rows

    monkeypatch.setattr("mbproj.studies.design.trial.by_arrays", counted)
    together, alone = tried_by_arrays(wish, designs), [tried(wish, u) for u in designs]
    for one, other in zip(together, alone, strict=True):
        for name in ("residuals", "goals", "limits", "open"):
            assert getattr(one, name).tobytes() == getattr(other, name).tobytes()
        assert (one.cause, one.reached) == (other.cause, other.reached)
    runs = sum(trial.runs for trial in alone)
    assert len(grouped) >= 0.6 * runs and (runs < len(designs)) == (case == "kinematic")


def test_a_run_without_accounts_of_energy_moves_alike_and_claims_none():
    mechanism = Mechanism.of(mbproj.read_scene_text(SPRING))
    settings, kept, reports = settings_to_run(mechanism.scene), [], []
    for accounts in (True, False):
        kept.append(MeasuredSamples(mechanism, ()))
        reports.append(simulate(mechanism.system, mechanism.state, settings, kept[-1], accounts=accounts))
    assert reports[0].state.y.tolist() == reports[1].state.y.tolist()
    assert 0.0 < reports[0].energy_drift < 1e-5
    assert np.isnan([reports[1].energy_drift, reports[1].energy_drift_relative, reports[1].energy.work]).all()


# Runs that follow the steps of another: smooth functions of their numbers, to round-off.

#: A pendulum of two bars, which a force pushes from `begins` on.
SCENE = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {length: 1 m, begins: 0.4 s, push: 1 N}
bodies:
  upper: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [length/2, 0, 0]}
  lower: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [3*length/2, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, upper], location: [0, 0, 0], axis: [0, -1, 0]}
  B: {type: revolute, bodies: [upper, lower], location: [length, 0, 0], axis: [0, -1, 0]}
forces:
  wind: {type: force, body: lower, force: ["push*max(t - begins, 0 s)/(1 s)", 0, 0]}
simulation: {duration: 4 s, integrator: dopri5, tolerance: 1.0e-6, output_step: 0.1 s}
"""


class End:
    """The last state of a run."""

    def write(self, block):
        self.q = block["bodies/position"][-1]


def ran(steps, text=SCENE, **parameters):
    """The last positions of a run, and how many steps it took."""
    scene = SceneText(text, "scene").scene(parameters)
    mechanism, end = Mechanism.of(scene), End()
    report = simulate(mechanism.system, mechanism.state, settings_to_run(scene), end, steps=steps)
    end.steps = report.counters["steps"]
    return end


@pytest.mark.skipif(core() is None, reason="no compiled kernel")
def test_the_same_numbers_give_the_same_run():
    steps = FollowedSteps()
    own = ran(steps)
    assert (len(steps.ends), steps.ends[-1]) == (own.steps, 4.0)
    again = ran(steps.of_another())
    np.testing.assert_allclose(again.q, own.q, rtol=1e-13)  # a size is a difference of times


@pytest.mark.skipif(core() is None, reason="no compiled kernel")
def test_a_run_beside_it_is_smooth():
    """Fourth differences of a smooth function are of the order of h⁴: none at h = 1e-5. Among runs with steps of their
    own there are some in which a step more is rejected: they jump."""
    steps, text, lengths = FollowedSteps(), SCENE.replace("1.0e-6", "1.0e-3"), 1.0 + 1e-5 * np.arange(-8, 9)
    ran(steps, text)
    rough = {}
    for follows in (True, False):
        ends = [ran(steps.of_another() if follows else None, text, length=length) for length in lengths]
        rough[follows] = np.abs(np.diff([end.q for end in ends], 4, axis=0)).max()
        if follows:
            assert {end.steps for end in ends} == {len(steps.ends)}
    assert rough[True] < 1e-11 < 1e-4 < rough[False]


@pytest.mark.skipif(core() is None, reason="no compiled kernel")
def test_other_breaks_are_not_followed():
    steps = FollowedSteps()
    ran(steps)
    other = steps.of_another()
    own, free = ran(other, begins=0.5), ran(None, begins=0.5)
    assert other.left
    assert own.q.tobytes() == free.q.tobytes()


@pytest.mark.skipif(core() is None, reason="no compiled kernel")
@pytest.mark.parametrize("setting", ["step: 0.01 s", "integrator: esdirk4, tolerance: 1.0e-6"])
def test_fixed_steps_and_implicit_ones_are_not_recorded(setting):
    steps = FollowedSteps()
    ran(steps, SCENE.replace("integrator: dopri5, tolerance: 1.0e-6", setting))
    assert not steps.are_recorded


@pytest.mark.skipif(core() is None, reason="no compiled kernel")
def test_a_step_that_cannot_be_followed_stops_the_run():
    """Far from the numbers that chose them the steps are too long: an angle turns untold."""
    steps = FollowedSteps()
    ran(steps, push=0.0)
    with pytest.raises(SimulationError):
        ran(steps.of_another(), push=1e7)
