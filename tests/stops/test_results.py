"""What results of stops show: expectations, tables, pictures and the summary, of a hammer that falls on an anvil."""

from __future__ import annotations

import csv
import json
import math

import numpy as np
import pytest

from mbproj.results.reader import open_results
from mbproj.show.figures.kinds import draw
from tests.cli.commands import mbproj

#: A hammer of 2 kg falls by 0.2 m on an anvil, and rests there after two bounces that count for nothing.
SCENE = """\
mbproj: 1
title: Hammer and anvil
gravity: [0, 0, -9.81]
parameters: {speed: sqrt(2 * 9.81 * 0.2)}
simulation: {duration: 0.3 s, tolerance: 1.0e-9, integrator: dop853, output_step: 10 ms, formulation: full}
bodies:
  hammer: {mass: 2 kg, inertia: [1, 1, 1], position: [0, 0, 0.25]}
joints:
  rail: {type: prismatic, bodies: [ground, hammer], location: [0, 0, 0.25], axis: [0, 0, 1]}
forces:
  anvil:
    type: stop
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: hammer, location: {hammer: [0, 0, -0.05]}}
    rigid: true
    restitution: 0
expect:
  falls: {stop: anvil, quantity: gap, at: 0.1 s, value: 0.2 - 9.81 / 2 * 0.01, absolute: 1.0e-12, source: free fall}
  arrives: {stop: anvil, quantity: rate, at: 0.2 s, value: -9.81 * 0.2, absolute: 1.0e-12, source: free fall}
  weighs: {stop: anvil, quantity: force, at: end, value: 2 * 9.81, absolute: 1.0e-9, source: statics}
"""
SPEED = math.sqrt(2 * 9.81 * 0.2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("hammer")
    (path / "hammer.yaml").write_text(SCENE)
    done = mbproj("run", "hammer.yaml", "--quiet", "--json", folder=path)
    assert done.returncode == 0, done.stderr
    return path


def test_expectations_hold(folder):
    found = json.loads(mbproj("batch", "hammer.yaml", "--json", folder=folder).stdout)
    assert "falls short" not in json.dumps(found)
    worse = SCENE.replace("value: 2 * 9.81", "value: 3 * 9.81")
    (folder / "worse.yaml").write_text(worse)
    assert mbproj("batch", "worse.yaml", folder=folder).returncode == 4


def test_info_counts_impacts(folder):
    said = mbproj("info", "results.h5", folder=folder).stdout
    assert f"1 impact of up to {2 * SPEED:.4g} N s, which took {SPEED**2:.4g} J" in said
    assert f"stop 'anvil', impact of {2 * SPEED:.6g} N s, which took {SPEED**2:.3g} J" in said
    seen = json.loads(mbproj("info", "results.h5", "--json", folder=folder).stdout)["stops"]["anvil"]
    assert (seen["impacts"], seen["unit"]) == (1, "m")
    assert (seen["largest_impulse"], seen["energy"]) == (pytest.approx(2 * SPEED), pytest.approx(SPEED**2))
    assert seen["largest_force"] == pytest.approx(2 * 9.81, rel=1e-9)
    assert seen["least_gap"] == pytest.approx(0.0, abs=1e-10)


def test_tables_of_stops_and_of_impacts(folder):
    done = mbproj("export", "results.h5", "--table", "stop-anvil", "--table", "events", folder=folder)
    assert done.stdout.split() == ["results-stop-anvil.csv", "results-events.csv"]
    with (folder / "results-stop-anvil.csv").open() as file:
        heading, *rows = csv.reader(file)
    assert heading == ["time (s)", "gap (m)", "rate (m/s)", "force (N)"]
    t, gap, rate, force = np.array(rows, dtype=float).T
    flying = t < SPEED / 9.81
    np.testing.assert_allclose(gap, np.where(flying, 0.2 - 9.81 / 2 * t**2, 0.0), atol=1e-10)
    np.testing.assert_allclose(rate, np.where(flying, -9.81 * t, 0.0), atol=1e-10)
    np.testing.assert_allclose(force, np.where(flying, 0.0, 2 * 9.81), atol=1e-9)
    with (folder / "results-events.csv").open() as file:
        heading, *rows = csv.reader(file)
    assert heading == ["time (s)", "direction", "impulse (N s or N m s)", "energy (J)"]
    time, _, impulse, energy = np.array(rows, dtype=float).T
    struck = impulse > 0.0
    np.testing.assert_allclose(time[struck], [SPEED / 9.81], rtol=1e-9)
    np.testing.assert_allclose([*impulse[struck], *energy[struck]], [2 * SPEED, SPEED**2], rtol=1e-9)


def test_the_picture_has_gap_and_force_and_a_line_at_the_impact(folder):
    with open_results(folder / "results.h5") as results:
        figure = draw("stops", [results], ["hammer"])
        gap, force = (axis for axis in figure.axes if axis.get_visible())
        assert (gap.get_ylabel(), force.get_ylabel()) == ("anvil: gap (m)", "force (N)")
        drawn = gap.lines[0].get_ydata()
        np.testing.assert_allclose(drawn, results["stops/gap"][:, 0], atol=1e-9)
        lines = [line.get_xdata()[0] for line in force.lines if len(set(line.get_xdata())) == 1]
        assert min(abs(np.array(lines) - SPEED / 9.81)) < 1e-9
