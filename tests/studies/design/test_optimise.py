"""Designs that serve a goal best, against what calculus says."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.studies.design import run as searches
from mbproj.studies.design.run import undominated
from tests.studies.design.scenes import BALL, FOUR_BAR, found, table, written

FAR = "maximise: {far: {body: ball, quantity: position, component: x, at: end}}\n"
LANDS = "subject_to: {lands: {body: ball, quantity: position, component: z, at: end, at_least: 0 m}}\n"


def test_the_farthest_throw_that_is_still_in_the_air(tmp_path):
    """v sin α T = g T²/2, that is sin α = 1/2."""
    design, numbers = found(written(tmp_path, BALL, "vary: {parameters.angle: [0.1, 1.5]}\nstarts: 2\n" + FAR + LANDS))
    assert numbers["angle"] == pytest.approx(np.pi / 6.0, abs=1e-8)
    assert -design.trial.goals[0] == pytest.approx(10.0 * np.cos(np.pi / 6.0), rel=1e-9)
    assert design.searches[0].broken == 0.0


def test_evolution_finds_the_same(tmp_path):
    path = written(tmp_path, BALL, "vary: {parameters.angle: [0.1, 1.5]}\nstarts: 1\n" + FAR + LANDS)
    _, numbers = found(path, engine="cma")
    assert numbers["angle"] == pytest.approx(np.pi / 6.0, abs=1e-4)


def test_constraints_may_be_equations_of_parameters(tmp_path):
    """x = v cos α with v = 10 α: largest where cot α = α."""
    limit = 'subject_to: {tied: {expression: "speed - 10*angle", equals: 0}}\n'
    vary = "vary: {parameters.angle: [0.1, 1.5], parameters.speed: [1 m/s, 20 m/s]}\nstarts: 2\n"
    _, numbers = found(written(tmp_path, BALL, vary + FAR + limit))
    assert numbers["angle"] == pytest.approx(0.860333589, abs=1e-6)
    assert numbers["speed"] == pytest.approx(10.0 * numbers["angle"], abs=1e-7)


def test_a_fit_under_a_constraint_lies_on_it(tmp_path):
    times = np.linspace(0.0, 1.0, 11)
    x, z = 12.0 * np.cos(0.7) * times, 12.0 * np.sin(0.7) * times - 5.0 * times**2
    table(tmp_path / "flight.csv", time__s=times, position_x__m=x, position_z__m=z)
    spec = "vary: {parameters.speed: [1, 30], parameters.angle: [0, 1.5]}\nstarts: 2\n"
    match = "match: {flight: {body: ball, through: flight.csv}}\nsubject_to: {slow: {expression: speed, at_most: 11}}\n"
    _, numbers = found(written(tmp_path, BALL, spec + match))
    assert numbers == pytest.approx({"speed": 11.0, "angle": 0.7}, abs=1e-5)


def test_no_design_keeps_what_cannot_be_kept(tmp_path):
    limit = LANDS.replace("at_least: 0 m", "at_least: 100 m")
    design, _ = found(written(tmp_path, BALL, "vary: {parameters.angle: [0.1, 1.5]}\nstarts: 2\n" + FAR + limit))
    assert design.searches[0].broken > 90.0
    assert design.notes[-1].startswith("no design keeps all constraints: the best one found is off by ")


@pytest.mark.full
def test_a_crank_that_has_to_turn_is_a_constraint(tmp_path, monkeypatch):
    """The largest swing of a rocker: its crank is as long as it may be and still turn round, 0.2 + 0.1 by Grashof's
    rule: crank + frame <= coupler + rocker here, where the crank is shortest. So few runs are enough to be near."""
    monkeypatch.setattr(searches, "EVOLVED", 60)
    goal = "maximise: {swing: {joint: D, quantity: angle, at: range}}\n"
    scene = FOUR_BAR.replace("coupler: 0.8 m", "coupler: 0.7 m").replace("rocker: 0.7 m", "rocker: 0.4 m")
    design, numbers = found(
        written(tmp_path, scene, "vary: {parameters.crank: [0.05, 0.6]}\nstarts: 1\n" + goal), engine="cma"
    )
    assert 0.28 < numbers["crank"] <= 0.3 + 1e-9
    assert design.trial.runs


def test_several_goals_give_a_front(tmp_path):
    """Far and high after 1 s, at a speed of 10 m/s: x² + (z + 5 m)² = 100 m², from z = 0 on."""
    goals = """\
maximise:
  far: {body: ball, quantity: position, component: x, at: end}
  high: {body: ball, quantity: position, component: z, at: end}
"""
    design, _ = found(written(tmp_path, BALL, "vary: {parameters.angle: [0.1, 1.5]}\nstarts: 1\n" + goals + LANDS))
    front = -np.array([each.goals for each in design.searches])
    assert design.engine == "nsga2"
    assert len(front) > 20
    np.testing.assert_allclose(np.hypot(front[:, 0], front[:, 1] + 5.0), 10.0, rtol=1e-9)
    assert front[:, 1].min() >= -1e-8
    order = np.argsort(front[:, 0])
    assert np.all(np.diff(front[order, 1]) < 0.0)
    best = front[0]
    assert 0.2 < (best[0] - front[:, 0].min()) / np.ptp(front[:, 0]) < 0.9


def test_fronts_leave_out_what_another_beats():
    goals = np.array([[1.0, 4.0], [2.0, 2.0], [2.0, 3.0], [4.0, 1.0], [4.0, 1.0]])
    assert undominated(goals).tolist() == [True, True, False, True, True]
