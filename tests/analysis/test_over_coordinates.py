"""Quantities over a coordinate in place of time: passages, ratios, transmission angles; their pictures and tables."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from mbproj import InputError, read_scene_text, run
from mbproj.results.analysis.expectations import curves_at, outcomes, time_of_passage
from mbproj.results.reader import open_results
from mbproj.scene.records import Passage
from mbproj.show.figures.kinds import KINDS, draw, why_not
from tests.cli.commands import mbproj
from tests.crossed import full

# A slider-crank whose crank turns at a constant speed, and where its piston is in closed form.

#: A slider-crank in the plane: crank r = 0.1 m, rod l = 0.3 m, at θ = 0 stretched out along x.
R, L, SPEED = 0.1, 0.3, 7.0
SCENE = f"""
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 1, step: 0.01}}
bodies:
  crank: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [{R / 2}, 0, 0]}}
  rod: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [{R + L / 2}, 0, 0]}}
  piston: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [{R + L}, 0, 0]}}
joints:
  main: {{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1]}}
  pin: {{type: revolute, bodies: [crank, rod], location: [{R}, 0, 0], axis: [0, 0, 1]}}
  wrist: {{type: point_on_line, bodies: [piston, rod], location: [{R + L}, 0, 0], axis: [0, 0, 1]}}
  bore: {{type: prismatic, bodies: [ground, piston], location: [{R + L}, 0, 0], axis: [1, 0, 0]}}
motions: {{drive: {{joint: main, angle: {{constant_speed: {SPEED} rad/s}}}}}}
markers:
  pin: {{body: crank, location: {{crank: [{R / 2}, 0, 0]}}}}
  wrist: {{body: piston, location: {{piston: [0, 0, 0]}}}}
  across: {{body: piston, location: {{piston: [0, 1, 0]}}}}
expect:
"""


def place(θ):
    """Of the piston from where it is at θ = 0, and its slope."""
    root = np.sqrt(L**2 - (R * np.sin(θ)) ** 2)
    return float(R * np.cos(θ) + root - R - L), float(-R * np.sin(θ) - R**2 * np.sin(θ) * np.cos(θ) / root)


# Quantities over a coordinate in place of time: passages, ratios and transmission angles against closed forms.


def expected(*lines):
    return SCENE + "".join(f"  e{k}: {{{line}, source: closed form}}\n" for k, line in enumerate(lines))


def test_quantities_where_the_crank_is_at_an_angle_are_those_of_the_closed_form():
    """100 samples on 1.1 turns: the polynomial of six points is right to 1e-9."""
    at_90, slope_90 = place(np.pi / 2)
    _, slope_200 = place(np.radians(200.0))
    μ = float(np.pi / 2 - np.arcsin(R / L))
    text = expected(
        f"joint: bore, quantity: displacement, at: {{main.angle: 90 deg}}, value: {at_90!r}, absolute: 1e-9",
        f"joint: bore, quantity: displacement_speed, at: {{main.angle: 90 deg}}, value: {slope_90 * SPEED!r},"
        " absolute: 1e-7",
        f"joint: bore, quantity: displacement_velocity_ratio, over: main.angle, at: {{main.angle: 200 deg}},"
        f" value: {slope_200!r}, absolute: 1e-8",
        f"joint: bore, quantity: displacement_mechanical_advantage, over: main.angle, at: {{main.angle: 200 deg}},"
        f" value: {1.0 / slope_200!r}, relative: 1e-6",
        f"marker: wrist, quantity: transmission_angle, between: [pin, across], at: {{main.angle: 90 deg}},"
        f" value: {μ!r} rad, absolute: 1e-8",
        f"marker: wrist, quantity: transmission_angle, between: [pin, across], at: minimum, above: {μ - 1e-3!r}",
        "diagnostic: total_energy, at: {bore.displacement: -0.1 m}, above: 0",
    )
    for outcome in outcomes(read_scene_text(text, "crank").expectations, run(text)):
        assert outcome.holds, (outcome.expectation, outcome.measured)
        assert outcome.checked


def test_a_place_that_is_never_passed_is_not_checked():
    text = expected("joint: bore, quantity: displacement, at: {bore.displacement: 1 m}, above: 0")
    (outcome,) = outcomes(read_scene_text(text, "crank").expectations, run(text))
    assert not outcome.checked


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("joint: bore, quantity: displacement, at: {main.angel: 1}, above: 0", "unknown joint coordinate 'main.angel'"),
        ("joint: bore, quantity: displacement, at: {main.angle: 1 m}, above: 0", "'main.angle' is in rad"),
        ("joint: bore, quantity: displacement, at: {a: 1, b: 2}, above: 0", "a place {A.angle: 90 deg}"),
        ("joint: bore, quantity: displacement_velocity_ratio, at: end, above: 0", "add  over: JOINT.COORDINATE"),
        ("joint: bore, quantity: displacement, over: main.angle, at: end, above: 0", "'displacement' has no input"),
        ("joint: bore, quantity: angle_velocity_ratio, over: main.angle, at: end, above: 0", "prismatic and has no"),
        ("joint: bore, quantity: displacement_velocity_ratio, over: x.y, at: end, above: 0", "joint coordinate 'x.y'"),
        ("marker: pin, quantity: transmission_angle, at: end, above: 0", "add  between: [FIRST, SECOND]"),
        ("marker: pin, quantity: transmission_angle, between: [pin, wrist], at: end, above: 0", "the corner itself"),
        ("marker: pin, quantity: transmission_angle, between: [a, wrist], at: end, above: 0", "unknown marker 'a'"),
        ("joint: bore, quantity: displacement, between: [pin, wrist], at: end, above: 0", "only a transmission angle"),
        (
            "joint: bore, quantity: displacement_velocity_ratio, over: main.angle, at: end, below: 3 rad",
            "'displacement_velocity_ratio' is in m",
        ),
    ],
)
def test_what_is_wrong_is_said_at_its_key(line, said):
    with pytest.raises(InputError) as raised:
        read_scene_text(expected(line), "crank")
    assert any(said in str(problem) for problem in raised.value.problems), raised.value


def test_the_first_passage_counts_modulo_a_turn_and_no_polynomial_crosses_an_event():
    t = np.linspace(0.0, 1.0, 51)
    angle = 0.3 - 9.0 * t
    found = time_of_passage(Passage("A.angle", 6.0, "rad"), t, angle, np.zeros(0))
    assert found == pytest.approx((0.3 - 6.0 + 2.0 * np.pi) / 9.0, abs=1e-12)
    length = time_of_passage(Passage("A.displacement", -6.0, "m"), t, angle, np.zeros(0))
    assert length == pytest.approx(0.7, abs=1e-12)
    kinked = np.abs(t - 0.41)
    assert curves_at(t, kinked[:, None], 0.43, np.array([0.41]))[0] == pytest.approx(0.02, abs=1e-12)
    assert time_of_passage(Passage("A.angle", 0.3, "rad"), t, angle, np.zeros(0)) == 0.0


# Pictures and tables over a joint coordinate in place of time, ratios, and transmission angles.

OVER = [kind for kind, entry in KINDS.items() if entry.over and entry.needs in (None, "markers", "joints", "motions")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With the results of a slider-crank that turns 1.1 times."""
    path = tmp_path_factory.mktemp("over")
    (path / "crank.yaml").write_text(SCENE.replace("expect:\n", ""))
    assert mbproj("run", "crank.yaml", "-o", "crank.h5", "--output-step", "0.02", folder=path).returncode == 0
    return path


@pytest.fixture(scope="module")
def results(folder):
    with open_results(folder / "crank.h5") as opened:
        yield opened


@pytest.mark.parametrize("kind", [kind if kind in ("joints", "violation") else full(kind) for kind in OVER])
def test_every_panel_over_time_is_over_the_angle_with_a_gap_at_each_turn(results, kind):
    corners = [("pin", "wrist", "across")] if kind == "transmission" else []
    figure = draw(kind, [results.over("main.angle", modulo=True)], ["run"], corners=corners)
    figure.draw_without_rendering()
    below = [axis for axis in figure.axes if axis.get_xlabel()]
    assert {axis.get_xlabel() for axis in below} == {"main.angle (°)"}
    angle = np.degrees(SPEED * results.time)
    for axis in below:
        assert axis.get_xlim() == (0.0, 360.0)
        for line in axis.lines:
            x = np.asarray(line.get_xdata(), dtype=float)
            assert np.isnan(x).sum() == 1
            np.testing.assert_allclose(x[~np.isnan(x)], angle % 360.0, atol=1e-9)


def test_without_modulo_the_angle_goes_on(results):
    figure = draw("markers", [results.over("main.angle")], ["run"])
    x = np.asarray(figure.axes[0].lines[0].get_xdata(), dtype=float)
    np.testing.assert_allclose(x, np.degrees(SPEED * results.time), atol=1e-9)


def test_ratios_are_the_slopes_of_the_closed_form(results):
    figure = draw("ratios", [results.select(joints=["bore"]).over("main.angle", of=results)], ["run"])
    ratio, advantage = (np.asarray(axis.lines[0].get_ydata(), dtype=float) for axis in figure.axes)
    slopes = np.array([place(SPEED * t)[1] for t in results.time])
    np.testing.assert_allclose(ratio, slopes, atol=1e-12)
    drawn = np.isfinite(advantage)
    assert drawn.sum() > 40
    np.testing.assert_allclose(advantage[drawn], 1.0 / slopes[drawn], rtol=1e-9)


def test_the_transmission_angle_is_that_of_the_rod(results):
    figure = draw("transmission", [results], ["run"], corners=[("pin", "wrist", "across")])
    drawn = np.radians(np.asarray(figure.axes[0].lines[0].get_ydata(), dtype=float))
    expected = np.pi / 2 - np.abs(np.arcsin(R / L * np.sin(SPEED * results.time)))
    np.testing.assert_allclose(drawn, expected, atol=1e-9)


def test_what_is_not_over_time_says_so(results):
    over = results.over("main.angle")
    assert "not over time" in str(why_not("paths", [over]))
    assert "--over" in str(why_not("ratios", [results]))


def test_tables_begin_with_the_coordinate_and_ratios_have_one(folder):
    done = mbproj(
        *("export", "crank.h5", "--over", "main.angle", "--table", "ratios", "--table", "marker-wrist"),
        *("--transmission", "pin,wrist,across", "--table", "transmission-wrist"),
        folder=folder,
    )
    assert (done.returncode, done.stderr) == (0, "")
    with (folder / "crank-ratios.csv").open() as file:
        headings, *rows = csv.reader(file)
    assert headings[:2] == ["main.angle (rad)", "time (s)"]
    values = np.array(rows, dtype=float)
    slopes = [place(angle)[1] for angle in values[:, 0]]
    column = headings.index("bore.displacement velocity ratio (m/rad)")
    np.testing.assert_allclose(values[:, column], slopes, atol=1e-12)
    with (folder / "crank-transmission-wrist.csv").open() as file:
        assert next(csv.reader(file)) == ["main.angle (rad)", "time (s)", "angle between pin and across (rad)"]


@pytest.mark.parametrize(("options", "turn"), [((), np.inf), (("--per-turn",), 2.0 * np.pi)])
def test_a_table_begins_with_the_angle_modulo_a_turn_where_asked(folder, results, options, turn):
    whole = ("export", "crank.h5", "--over", "main.angle", "--table", "marker-wrist", "--force")
    assert mbproj(*whole, *options, folder=folder).returncode == 0
    with (folder / "crank-marker-wrist.csv").open() as file:
        angle = np.array([row[0] for row in list(csv.reader(file))[1:]], dtype=float)
    exact = SPEED * results.time
    np.testing.assert_allclose(angle, exact if np.isinf(turn) else exact % turn, atol=1e-9)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--over", "main.angel"), "did you mean 'main.angle'?"),
        (("--per-turn",), "--per-turn is for --over"),
        (("--transmission", "pin,wrist"), "'pin,wrist' is not three markers"),
        (("--transmission", "pin,wrist,acros"), "acros"),
        (("--kind", "transmission"), "add --transmission A,B,C"),
        (("--kind", "ratios"), "--over JOINT.COORDINATE"),
        (("--kind", "paths", "--over", "main.angle"), "not over time"),
    ],
)
def test_options_that_are_wrong_are_said(folder, options, said):
    done = mbproj("plot", "crank.h5", *options, "-o", "wrong", folder=folder)
    assert done.returncode == 2
    assert said in done.stderr, done.stderr
