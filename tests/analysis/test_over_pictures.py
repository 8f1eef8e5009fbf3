"""Pictures and tables over a joint coordinate in place of time, ratios, and transmission angles."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from mbproj.results.reader import open_results
from mbproj.show.figures.kinds import KINDS, draw, why_not
from tests.analysis.turning_crank import SCENE, SPEED, L, R, place
from tests.cli.commands import mbproj
from tests.crossed import full

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
