"""What is wrong with a design is said at its place, before anything runs."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.studies.design.run import find_design
from mbproj.studies.design.spec import read_spec
from tests.studies.design.scenes import BALL, table, written

VARY = "vary: {parameters.speed: [1 m/s, 30 m/s]}\n"
MATCH = "match: {flight: {body: ball, through: flight.csv}}\n"
FAR = "maximise: {far: {body: ball, quantity: position, component: x, at: end}}\n"
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
