"""Each picture shows the results' own numbers, with units on its axes and a name for every line."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

from mbproj.plot.kinds import KINDS, draw, why_not
from mbproj.plot.labels import derive_labels
from mbproj.plot.panels import FLOOR
from mbproj.plot.save import save
from mbproj.plot.shown import MAX_LINES, MAX_ROWS
from mbproj.results import open_results
from mbproj.scene.records import ProjectionSettings
from tests.results.pendulum_blocks import NAMES, NO_NAMES, SETTINGS, block, record, scene, times

#: What can be drawn of a run that is not certified.
UNCERTIFIED = [kind for kind in KINDS if kind != "trust"]


@pytest.fixture
def results(tmp_path):
    with open_results(record(tmp_path / "run.h5")) as opened:
        yield opened


@pytest.fixture
def two(tmp_path, results):
    how = replace(SETTINGS, projection=ProjectionSettings("gopm", tolerance=1e-13))
    path = record(tmp_path / "other.h5", block(times(), drift=-3e-6), scene(settings=how))
    with open_results(path) as opened:
        yield [results, opened]


def lines(axis) -> dict[str, np.ndarray]:
    return {line.get_label(): line.get_ydata() for line in axis.lines}


def legend(figure) -> list[str]:
    return [text.get_text() for shown in figure.legends for text in shown.get_texts()]


def ylabels(figure) -> list[str]:
    return [axis.get_ylabel() for axis in figure.axes]


def times_agree(figure, results) -> bool:
    return all(np.array_equal(line.get_xdata(), results.time) for axis in figure.axes for line in axis.lines)


def test_markers(results):
    figure = draw("markers", [results], ["run"])
    assert ylabels(figure) == [
        "position of tip (m)", "velocity of tip (m/s)", "position of Mitte (m)", "velocity of Mitte (m/s)",
    ]  # fmt: skip
    assert legend(figure) == ["x", "y", "z"]
    for axis, (name, member) in zip(
        figure.axes, [(name, member) for name in NAMES["markers"] for member in ("position", "velocity")], strict=True
    ):
        drawn, values = lines(axis), getattr(results.marker(name), member)
        for index, component in enumerate("xyz"):
            assert np.array_equal(drawn[component], values[:, index])
    assert [axis.get_xlabel() for axis in figure.axes[-2:]] == ["time (s)", "time (s)"]
    assert times_agree(figure, results)


def test_markers_overlaid(two):
    shown = [one.select(markers=["tip"]) for one in two]
    figure = draw("markers", shown, derive_labels(two))
    assert legend(figure) == ["gpopm", "gopm"]
    assert ylabels(figure)[:2] == ["tip: $x$ (m)", "tip: $v_x$ (m/s)"]
    assert np.array_equal(lines(figure.axes[3])["gopm"], two[1].marker("tip").velocity[:, 1])


def test_round_off_is_not_blown_up(two):
    """x of this pendulum is zero: its panel keeps the scale of the others."""
    figure = draw("markers", [one.select(markers=["tip"]) for one in two], ["a", "b"])
    low, high = figure.axes[0].get_ylim()
    span = np.ptp(two[0].marker("tip").position[:, 1])
    assert (low, high) == pytest.approx((-0.05 * span, 0.05 * span))


@pytest.mark.parametrize(("kind", "name", "value"), [("forces", "spring", "coordinate"), ("motions", "drive", "value")])
def test_forces_and_motions(results, kind, name, value):
    figure = draw(kind, [results], ["run"])
    assert ylabels(figure) == [f"{name} (rad)", "torque (N m)"]
    for axis, member in zip(figure.axes, (value, "force"), strict=True):
        np.testing.assert_array_equal(lines(axis)["run"], results[f"{kind}/{member}"][:, 0])
    assert times_agree(figure, results)


def test_coordinates(results):
    figure = draw("coordinates", [results], ["run"])
    assert ylabels(figure) == ["A.angle (rad)", "speed (rad/s)"]
    assert np.array_equal(figure.axes[0].lines[0].get_ydata(), results["joints/coordinate"][:, 0])
    assert np.array_equal(figure.axes[1].lines[0].get_ydata(), results["joints/speed"][:, 0])
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
    assert figure.get_supxlabel().splitlines()[1] == "zero and what is below $10^{-17}$ is drawn at $10^{-17}$"


def test_joints(results):
    figure = draw("joints", [results], ["run"])
    assert ylabels(figure) == ["violation (m)", "violation (rad)"]
    assert legend(figure) == ["A", "Gelenk ä"]
    assert np.array_equal(lines(figure.axes[0])["A"], results.joint("A").violation_length)
    assert np.array_equal(lines(figure.axes[1])["Gelenk ä"], results.joint("Gelenk ä").violation_angle)
    assert {axis.get_yscale() for axis in figure.axes} == {"log"}


def test_reactions_are_magnitudes_of_several_and_components_of_one(results):
    figure = draw("reactions", [results], ["run"])
    assert ylabels(figure) == ["|reaction force| (N)", "|reaction torque| (N m)"]
    size = np.linalg.norm(results.joint("Gelenk ä").reaction_torque, axis=1)
    assert np.array_equal(lines(figure.axes[1])["Gelenk ä"], size)
    single = draw("reactions", [results.select(joints=["A"])], ["run"])
    assert ylabels(single) == ["reaction force of A (N)", "reaction torque of A (N m)"]
    assert np.array_equal(lines(single.axes[0])["z"], results.joint("A").reaction_force[:, 2])


def test_a_column_for_each_result_where_lines_are_joints(two):
    for kind in ("joints", "reactions"):
        figure = draw(kind, two, ["one", "two"])
        assert [axis.get_title() for axis in figure.axes[:2]] == ["one", "two"]
        assert figure.axes[0].get_ylim() == figure.axes[1].get_ylim()


def test_energy(two):
    figure = draw("energy", two[:1], ["one"])
    assert ylabels(figure) == ["energy (J)", "energy balance (J)"]
    assert legend(figure) == ["kinetic", "potential", "total"]
    assert np.array_equal(lines(figure.axes[0])["total"], two[0]["diagnostics/total_energy"])
    assert np.array_equal(figure.axes[1].lines[0].get_ydata(), 1e-6 * times())
    figure = draw("energy", two, ["one", "two"])
    assert ylabels(figure) == ["kinetic energy (J)", "potential energy (J)", "total energy (J)", "energy balance (J)"]
    assert np.array_equal(lines(figure.axes[3])["two"], -3e-6 * times())
    assert np.array_equal(lines(figure.axes[1])["one"], two[0]["diagnostics/potential_energy"])


def test_steps(results):
    figure = draw("steps", [results], ["run"])
    assert ylabels(figure) == ["step size (s)", "position iterations\nper step", "velocity iterations\nper step"]
    size, position, velocity = (axis.lines[0].get_ydata() for axis in figure.axes)
    assert np.array_equal(size, np.full(201, 0.01))
    assert np.isnan(position[0])
    assert np.isnan(velocity[0])
    assert np.array_equal(position[1:], np.full(200, 2.0))
    assert np.array_equal(velocity[1:], np.full(200, 1.0))
    assert figure.axes[0].get_yscale() == "linear"


def test_steps_of_very_different_size_have_a_logarithmic_axis(tmp_path):
    values = block(times())
    values["diagnostics/step_size"] = np.geomspace(1e-6, 1e-2, 201)
    values["diagnostics/steps"][100:] = 100
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("steps", [results], ["run"])
    assert figure.axes[0].get_yscale() == "log"
    assert np.all(np.isnan(figure.axes[1].lines[0].get_ydata()[101:]))


def test_too_many_names_are_cut_with_a_remark(tmp_path):
    many = {
        "bodies": ["b"],
        "markers": [f"m{i}" for i in range(MAX_ROWS + 3)],
        "joints": [f"j{i}" for i in range(20)],
        "coordinates": [],
        "coordinate_units": [],
        "forces": [],
        "force_units": [],
        "motions": [],
        "motion_units": [],
    }
    with open_results(record(tmp_path / "run.h5", block(times(), many), names=many)) as results:
        figure = draw("markers", [results], ["run"])
        assert len(figure.axes) == 2 * MAX_ROWS
        assert figure.get_supxlabel().splitlines()[1] == "the first 8 of 11 markers: choose others with --marker"
        figure = draw("joints", [results], ["run"])
        # Column i of the block is the first divided by i + 1: the first are the largest.
        assert legend(figure) == [f"j{i}" for i in range(MAX_LINES)]
        remark = figure.get_supxlabel().splitlines()[1]
        assert remark.startswith("the 7 largest of 20 joints: choose others with --joint")


@pytest.mark.parametrize("kind", UNCERTIFIED)
@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_every_kind_can_be_saved_and_leaves_no_trace(two, tmp_path, kind, suffix):
    settings = mpl.rcParams.copy()
    path = save(draw(kind, two, ["one", "two"]), tmp_path / f"picture.{suffix}")
    first = path.read_bytes()
    assert first[:5] in (b"\x89PNG\r", b"<?xml", b"%PDF-")
    assert mpl.rcParams.copy() == settings


@pytest.mark.parametrize("kind", UNCERTIFIED)
def test_one_sample_is_a_dot(tmp_path, kind):
    with open_results(record(tmp_path / "run.h5", block(times(1)))) as results:
        figure = draw(kind, [results], ["run"])
        assert {line.get_marker() for axis in figure.axes for line in axis.lines} == {"o"}
        save(figure, tmp_path / "picture.png")


def test_names_with_signs_of_mathematics(tmp_path):
    names = dict(NAMES) | {"joints": ["_hidden", "$x"], "markers": ["a_$", "_b"]}
    with open_results(record(tmp_path / "run.h5", names=names)) as results:
        assert legend(draw("joints", [results], ["run"])) == [" _hidden", r"\$x"]
        assert ylabels(draw("markers", [results], ["run"]))[0] == r"position of a_\$ (m)"


def test_what_does_not_apply(tmp_path):
    with open_results(record(tmp_path / "run.h5", block(times(), NO_NAMES), names=NO_NAMES)) as results:
        reasons = {kind: why_not(kind, [results]) for kind in KINDS}
    assert {kind for kind, reason in reasons.items() if reason is None} == {"violation", "energy", "steps"}
    assert reasons["motions"] == "the results have no motions"
    assert reasons["coordinates"] == "the results have no joint coordinates"


def test_kinds_are_listed_without_matplotlib_and_drawn_without_pyplot():
    code = (
        "import sys, mbproj.plot.kinds as k\n"
        "light = {'matplotlib', 'numpy', 'h5py'} & set(sys.modules)\n"
        "import importlib; [importlib.import_module('mbproj.plot.' + kind.module) for kind in k.KINDS.values()]\n"
        "import mbproj.plot.save\n"
        "print(light, 'matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set() False\n"


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


def test_a_picture_says_what_it_is_of(tmp_path):
    results = open_results(record(tmp_path / "run.h5", block(times())))
    settings = results.settings
    caption = draw("energy", [results], ["run"]).get_supxlabel().splitlines()[0]
    assert caption.startswith(f"{results.title}; {settings.projection.method}, {settings.integrator}, ")


def marked(tmp_path, force, torque):
    """The pendulum's results with these components of its two joints not unique."""
    unique = [np.ones((2, 3), dtype=bool) for _ in range(2)]
    for marks, found in zip(unique, (force, torque), strict=True):
        for joint, axis in found:
            marks[joint, axis] = False
    constants = dict(zip(("joints/reaction_force_unique", "joints/reaction_torque_unique"), unique, strict=True))
    return open_results(record(tmp_path / "marked.h5", constants=constants))


def test_components_that_are_not_unique_are_grey_and_the_legend_says_so(tmp_path):
    with marked(tmp_path, [(0, 1)], [(0, 0), (0, 1), (0, 2)]) as results:
        figure = draw("reactions", [results.select(joints=["A"])], ["run"])
        assert legend(figure) == ["x", "y", "z", "not unique"]
        force, torque = figure.axes
        (grey,) = [line for line in force.lines if line.get_label() == "not unique"]
        assert np.array_equal(grey.get_ydata(), results.joint("A").reaction_force[:, 1])
        assert grey.get_color() != "#D55E00"
        assert len(lines(force)["y"]) == 0
        assert [line.get_color() for line in torque.lines if len(line.get_ydata())] == [grey.get_color()] * 3


def test_magnitudes_leave_out_what_is_not_unique(tmp_path):
    with marked(tmp_path, [(0, 2), (1, 0), (1, 1), (1, 2)], []) as results:
        figure = draw("reactions", [results], ["run"])
        force = figure.axes[0]
        value = results.joint("A").reaction_force
        assert np.allclose(lines(force)["A"], np.hypot(value[:, 0], value[:, 1]), rtol=1e-14)
        whole = np.linalg.norm(results.joint("Gelenk ä").reaction_force, axis=1)
        assert np.array_equal(lines(force)["not unique"], whole)
        assert "not unique, and left out of magnitudes" in figure.get_supxlabel()
        assert "Fz of A; Fx Fy Fz of Gelenk ä" in figure.get_supxlabel()
