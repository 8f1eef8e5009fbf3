"""Designs that serve a goal best, and what is wrong with a design, said before anything runs."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.studies.design import run as searches
from mbproj.studies.design.run import find_design, undominated
from mbproj.studies.design.spec import read_spec
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


# What is wrong with a design is said at its place, before anything runs.

VARY = "vary: {parameters.speed: [1 m/s, 30 m/s]}\n"
MATCH = "match: {flight: {body: ball, through: flight.csv}}\n"
#: A design's text below its scene, and what is said of it: the line, and how the message begins.
WRONG = {
    "nothing wanted": (VARY, "1:1: error: nothing is matched, minimised or maximised"),
    "two kinds": (VARY + MATCH + FAR, "5:1: error: 'match' and 'maximise' cannot both be given"),
    "nothing varies": ("vary: {}\n" + FAR, "3:1: error: 'vary' is empty"),
    "no bounds": ("vary: {parameters.speed: 3}\n" + FAR, "3:26: error: 'parameters.speed' needs [low, high]"),
    "bounds the wrong way": (VARY.replace("30", "0.3") + FAR, "3:26: error: 'parameters.speed' has"),
    "unknown parameter": (VARY.replace("speed", "sped") + FAR, "3:8: error: unknown parameter 'sped'"),
    "a unit of another kind": (
        VARY.replace("30 m/s", "30 kg") + FAR,
        "3:34: error: a velocity and a mass",
    ),
    "a bound that the scene refuses": (
        "vary: {bodies.ball.mass: [-1 kg, 2 kg]}\n" + FAR,
        "3:27: error: 'mass' must",
    ),
    "no file": (VARY + MATCH.replace("flight.csv", "none.csv"), "4:39: error: cannot read "),
    "unknown marker": (VARY + MATCH.replace("body: ball", "marker: tip"), "4:26: error: unknown marker 'tip'"),
    "no such quantity": (
        VARY + MATCH.replace("ball,", "ball, quantity: colour,"),
        "4:40: error: unknown quantity",
    ),
    "over what is not there": (
        VARY + MATCH.replace("csv}", "csv, over: pin.angle}"),
        "4:57: error: nothing is over 'pin",
    ),
    "a deviation in kg": (VARY + MATCH.replace("csv}", "csv, deviation: 1 kg}"), "4:62: error: 'deviation' is in m"),
    "no such column": (
        VARY + MATCH.replace("ball,", "ball, quantity: velocity,"),
        "flight.csv:1: error: no column is of",
    ),
    "a goal without a time": (VARY + FAR.replace(", at: end", ""), "4:12: error: missing key 'at'"),
    "a goal of three components": (
        VARY + FAR.replace(", component: x", ""),
        "4:40: error: 'position' has 3 components",
    ),
    "a constraint without a side": (
        VARY + FAR + "subject_to: {high: {expression: speed}}\n",
        "5:14: error: missing key 'at_least', 'at_most' or 'equals'",
    ),
    "an expression of nothing": (
        VARY + FAR + "subject_to: {high: {expression: sped, at_most: 1}}\n",
        "5:33: error: an expression of parameters: unknown name 'sped'",
    ),
    "a constraint without a quantity": (
        VARY + FAR + "subject_to: {high: {body: ball, at: end, at_most: 1}}\n",
        "5:14: error: missing key 'quantity'",
    ),
    "bounds in another unit": (
        VARY.replace("1 m/s, 30 m/s", "1 s, 30 s") + FAR,
        "3:8: error: 'speed' is in m/s, and its bounds are in s",
    ),
    "an expression in another unit": (
        VARY
        + FAR
        + "subject_to: {high: {expression: speed * idle, at_most: 1 m/s}, low: {expression: 2*speed, at_least: 1 m}}\n",
        "5:101: error: '2*speed' is in m/s; give 'at_least' so",
    ),
    "a heading that is not there": (
        VARY + MATCH.replace("csv}", "csv, columns: {position_x: far}}"),
        "4:61: error: 'flight.csv' has no column 'far'",
    ),
    "a heading of nothing": (
        VARY + MATCH.replace("csv}", "csv, columns: {position_y: time, range: position_x}}"),
        "4:79: error: 'range' is no column of this match",
    ),
    "a constraint in another unit": (
        VARY + FAR + "subject_to: {high: {body: ball, quantity: position, component: z, at: end, at_most: 1 s}}\n",
        "5:85: error: 'position' is in m",
    ),
}


@pytest.fixture
def folder(tmp_path):
    times = np.linspace(0.0, 1.0, 5)
    table(tmp_path / "flight.csv", time__s=times, position_x__m=5.0 * times)
    return tmp_path


@pytest.mark.parametrize("what", WRONG)
def test_wrong_designs(what, folder):
    text, said = WRONG[what]
    with pytest.raises(mbproj.InputError) as caught:
        read_spec(written(folder, BALL, text))
    message = str(caught.value)
    where = said if said.startswith("flight") else f"design.yaml:{said}"
    assert where in message, message


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time (s),position_x (kg)\n0,1\n", "flight.csv:1: error: column 'position_x' is in m, and 'kg' is not"),
        ("time (s),position_x (m)\n0,1\n5,2\n", "flight.csv:3: error: 5 s is outside the run, which is from 0 to 1 s"),
        ("time (s),position_x (m)\n0,one\n", "flight.csv:2: error: 'one' is not a number"),
        ("time (s),position_x (m)\n0,1\n1,7_3\n", "flight.csv:3: error: '7_3' is not a number"),
        ("time (s),position_x (m)\n0,1\n1,１２\n", "flight.csv:3: error: '１２' is not a number"),
        ("time (s),position_x (m)\n0,1\n1,infinity\n", "flight.csv:3: error: a number is not finite"),
        ("time (s),position_x (m),position_x (mm)\n0,1,2\n", "flight.csv:1: error: two columns are of 'position_x'"),
        ("time (s),t (s),position_x (m)\n0,1,2\n", "flight.csv:1: error: 'time' and 't' could both be 'time'"),
        (
            "time (s),x (m),ball.x (m)\n0,1,2\n",
            "flight.csv:1: error: 'x' and 'ball.x' could both be 'position_x'",
        ),
        ("time (s),position_x (m)\n", "flight.csv:1: error: it has no row below its headings"),
        ("position_x (m)\n1\n", "flight.csv:1: error: no column is of 'time'"),
    ],
)
def test_wrong_measurements(text, said, folder):
    (folder / "flight.csv").write_text(text)
    with pytest.raises(mbproj.InputError, match=said.replace("(", r"\(").replace(")", r"\)")):
        read_spec(written_again(folder))


def written_again(folder):
    return written(folder, BALL, VARY + MATCH)


def test_more_numbers_than_data(folder):
    table(folder / "flight.csv", time__s=np.ones(1), position_x__m=np.ones(1))
    vary = "vary: {parameters.speed: [1, 3], parameters.angle: [0, 1]}\n"
    with pytest.raises(mbproj.InputError, match="3:1: error: 2 numbers vary, and there are 1 to match"):
        read_spec(written(folder, BALL, vary + MATCH))


def test_a_column_without_a_unit_is_said(folder):
    (folder / "flight.csv").write_text("time (s),position_x\n0,0\n1,5\n")
    spec = read_spec(written_again(folder))
    assert spec.notes == ("'flight.csv' has no unit for 'position': it is read in m",)
    assert find_design(spec, 1).notes[:1] == spec.notes
    (folder / "flight.csv").write_text("time (s),position_x (m)\n0,0\n1,5\n")
    assert read_spec(written_again(folder)).notes == ()


def test_a_box_in_which_nothing_runs(folder):
    text = BALL.replace("position: [0, 0, 0]", "position: [0, 0, 0 m * sqrt(abs(speed / (5 m/s) - 1) - 1)]")
    spec = "vary: {parameters.speed: [0.1 m/s, 9.9 m/s]}\nstarts: 1\n"
    with pytest.raises(mbproj.InputError, match="no design runs; most often: "):
        find_design(read_spec(written(folder, text, spec + MATCH)), 1)
