"""Each picture shows the results' own numbers, with units on its axes and a name for every line."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.results.reader import open_results
from mbproj.show.figures.kinds import draw
from mbproj.show.figures.panels import FLOOR
from mbproj.show.figures.rows import derive_labels
from tests.figures.drawn import legend, lines, steep, ylabels
from tests.results.pendulum_blocks import NAMES, block, record, times


def times_agree(figure, results) -> bool:
    return all(np.array_equal(line.get_xdata(), results.time) for axis in figure.axes for line in axis.lines)


def test_markers(tmp_path):
    results = open_results(record(tmp_path / "run.h5", steep(block(times()))))
    figure = draw("markers", [results], ["run"])
    assert ylabels(figure) == ["position of tip (m)", "velocity (m/s)", "position of Mitte (m)", "velocity (m/s)"]
    assert legend(figure) == ["y", "z"]
    assert "x is zero throughout" in figure.get_supxlabel()
    for axis, (name, member) in zip(
        figure.axes, [(name, member) for name in NAMES["markers"] for member in ("position", "velocity")], strict=True
    ):
        drawn, values = lines(axis), getattr(results.marker(name), member)
        for index, component in ((1, "y"), (2, "z")):
            assert np.array_equal(drawn[component], values[:, index])
    assert [axis.get_xlabel() for axis in figure.axes[-2:]] == ["time (s)", "time (s)"]
    assert times_agree(figure, results)


def test_markers_overlaid(two):
    shown = [one.select(markers=["tip"]) for one in two]
    figure = draw("markers", shown, derive_labels(two))
    assert legend(figure) == ["gpopm", "gopm"]
    assert ylabels(figure)[:2] == ["tip: y (m)", "velocity y (m/s)"]
    assert np.array_equal(lines(figure.axes[1])["gopm"], two[1].marker("tip").velocity[:, 1])


def test_round_off_is_not_blown_up(tmp_path):
    """x is 0.3 m but for round-off, y moves by 0.43 m: its panel keeps the scale of the others."""
    values = block(times())
    values["markers/position"][:, 0, 0] = 0.3 + 1e-15 * np.cos(np.arange(len(times())))
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("markers", [results.select(markers=["tip"])] * 2, ["a", "b"])
        span = np.ptp(results.marker("tip").position[:, 1])
    low, high = figure.axes[0].get_ylim()
    assert (low, high) == pytest.approx((0.3 - 0.05 * span, 0.3 + 0.05 * span))


@pytest.mark.parametrize(("kind", "name", "value"), [("forces", "spring", "coordinate"), ("motions", "drive", "value")])
def test_forces_and_motions(results, kind, name, value):
    figure = draw(kind, [results], ["run"])
    assert ylabels(figure) == [f"{name}: A.angle (°)", "torque (N m)"]
    for axis, member, factor in zip(figure.axes, (value, "force"), (180.0 / np.pi, 1.0), strict=True):
        np.testing.assert_array_equal(lines(axis)["run"], factor * results[f"{kind}/{member}"][:, 0])
    assert times_agree(figure, results)


def test_forces_share_a_panel_only_along_one_coordinate(tmp_path):
    """A slide that happens to move by as many m as a hinge by rad has a panel of its own."""
    names = {**NAMES, "forces": ["hinge", "brake", "slide"], "force_units": ["rad", "rad", "m"]}
    values = block(times(), names)
    values["forces/coordinate"][:] = values["forces/coordinate"][:, :1]
    with open_results(record(tmp_path / "run.h5", values, names=names)) as results:
        figure = draw("forces", [results], ["run"])
    assert [label.split("(")[-1] for label in ylabels(figure)] == ["°)", "N m)", "m)", "N)"]
    assert [len(axis.lines) for axis in figure.axes] == [1, 2, 1, 1]


def test_coordinates(results):
    figure = draw("coordinates", [results], ["run"])
    assert ylabels(figure) == ["A.angle (°)", "speed (°/s)"]
    for axis, path in zip(figure.axes, ("joints/coordinate", "joints/speed"), strict=True):
        np.testing.assert_allclose(axis.lines[0].get_ydata(), np.degrees(results[path][:, 0]), rtol=1e-15)
    assert legend(figure) == []


def test_violation(two):
    figure = draw("violation", two, ["one", "two"])
    assert [axis.get_yscale() for axis in figure.axes] == ["log", "log"]
    assert ylabels(figure) == [r"$|C|_\infty$ (m or rad)", r"$|\dot{C}|_\infty$ (m/s or rad/s)"]
    assert legend(figure) == ["one", "two"]
    assert np.array_equal(lines(figure.axes[0])["two"], two[1]["diagnostics/position_violation"])
    assert np.array_equal(lines(figure.axes[1])["one"], two[0]["diagnostics/velocity_violation"])
    assert len(figure.get_supxlabel().splitlines()) == 1  # what it is of, and nothing of a floor


def test_zeros_are_drawn_on_a_floor_that_is_named(tmp_path):
    values = block(times())
    values["diagnostics/position_violation"][[0, 7]] = [0.0, 1e-30]
    values["diagnostics/position_violation"][9] = np.inf
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("violation", [results], ["run"])
        drawn = figure.axes[0].lines[0].get_ydata()
    assert drawn[0] == drawn[7] == FLOOR == 1e-17
    assert np.isnan(drawn[9])
    assert figure.get_supxlabel().splitlines()[1] == "zero and what is below 10⁻¹⁷ is drawn at 10⁻¹⁷"


def test_joints(results):
    figure = draw("joints", [results], ["run"])
    assert ylabels(figure) == ["violation (m)", "violation (rad)"]
    assert legend(figure) == ["A", "Gelenk ä"]
    assert np.array_equal(lines(figure.axes[0])["A"], results.joint("A").violation_length)
    assert np.array_equal(lines(figure.axes[1])["Gelenk ä"], results.joint("Gelenk ä").violation_angle)
    assert {axis.get_yscale() for axis in figure.axes} == {"log"}


def test_a_row_for_each_joint_where_lines_are_results(two):
    figure = draw("joints", two, ["one", "two"])
    assert ylabels(figure) == [
        "A: violation (m)",
        "A: violation (rad)",
        "Gelenk ä: violation (m)",
        "Gelenk ä: violation (rad)",
    ]
    assert legend(figure) == ["one", "two"]
    assert figure.axes[0].get_ylim() == figure.axes[2].get_ylim()
    assert np.array_equal(lines(figure.axes[3])["two"], two[1].joint("Gelenk ä").violation_angle)


def test_energy(two):
    figure = draw("energy", two[:1], ["one"])
    assert ylabels(figure) == ["energy (J)", "energy balance (J)"]
    assert legend(figure) == ["kinetic", "potential", "total"]
    assert np.array_equal(lines(figure.axes[0])["total"], two[0]["diagnostics/total_energy"])
    assert np.array_equal(figure.axes[1].lines[0].get_ydata(), 1e-6 * times())
    figure = draw("energy", two, ["one", "two"])
    assert ylabels(figure)[:4] == [
        "kinetic energy (J)",
        "potential energy (J)",
        "total energy (J)",
        "energy balance (J)",
    ]
    assert np.array_equal(lines(figure.axes[3])["two"], -3e-6 * times())
    assert np.array_equal(lines(figure.axes[1])["one"], two[0]["diagnostics/potential_energy"])


def test_steps(results):
    figure = draw("steps", [results], ["run"])
    assert ylabels(figure) == ["step size (s)", "position iterations a step", "velocity iterations a step"]
    size, position, velocity = (axis.lines[0].get_ydata() for axis in figure.axes)
    assert np.array_equal(size, np.full(201, 0.01))
    assert np.isnan(position[0])
    assert np.isnan(velocity[0])
    assert np.array_equal(position[1:], np.full(200, 2.0))
    assert np.array_equal(velocity[1:], np.full(200, 1.0))
    assert figure.axes[0].get_yscale() == "linear"


def test_rejected_steps_are_marked(tmp_path):
    values = block(times())
    values["diagnostics/rejected_steps"] = np.cumsum(np.isin(np.arange(201), (0, 50, 51, 120)))
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("steps", [results], ["run"])
    _, crosses = figure.axes[0].lines
    np.testing.assert_array_equal(crosses.get_xdata(), times()[[50, 51, 120]])
    np.testing.assert_array_equal(crosses.get_ydata(), 0.01)
    assert "steps were rejected" in figure.get_supxlabel()


def test_steps_of_very_different_size_have_a_logarithmic_axis(tmp_path):
    values = block(times())
    values["diagnostics/step_size"] = np.geomspace(1e-6, 1e-2, 201)
    values["diagnostics/steps"][100:] = 100
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("steps", [results], ["run"])
    assert figure.axes[0].get_yscale() == "log"
    # No step ended between the later samples: they lie in the one before.
    np.testing.assert_array_equal(figure.axes[1].lines[0].get_ydata()[1:], 2.0)


def test_paths_are_drawn_in_the_plane_of_the_motion_with_equal_scales(tmp_path):
    results = open_results(record(tmp_path / "run.h5", block(times())))
    figure = draw("paths", [results], ["run"])
    (axis,) = figure.axes
    path = results.marker(results.names("markers")[0]).position
    extent = np.ptp(path, axis=0)
    first, second = (int(index) for index in np.sort(np.argsort(-extent, kind="stable")[:2]))
    assert (axis.get_xlabel(), axis.get_ylabel()) == (f"{'xyz'[first]} (m)", f"{'xyz'[second]} (m)")
    np.testing.assert_array_equal(axis.lines[0].get_xdata(), path[:, first])
    np.testing.assert_array_equal(axis.lines[0].get_ydata(), path[:, second])
    assert axis.get_aspect() == 1.0
