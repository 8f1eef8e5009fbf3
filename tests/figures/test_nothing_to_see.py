"""What would show nothing is not drawn, what hides something is drawn apart, and what is the same is drawn once."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

from mbproj.commands import plot
from mbproj.results.reader import open_results
from mbproj.show.figures.kinds import KINDS, draw, nothing_to_see
from mbproj.show.figures.over_time import legible
from mbproj.show.figures.panels import hold_still
from tests.figures.drawn import legend, lines, ylabels
from tests.results.pendulum_blocks import NAMES, block, record, times

WAVE = np.sin(times())


def vectors(x, y, z):
    return np.stack([x + 0 * WAVE, y + 0 * WAVE, z + 0 * WAVE], axis=1)


@pytest.mark.parametrize(
    ("history", "groups"),
    [
        (vectors(WAVE, 0.5 * WAVE, 0.0), [(0, 1, 2)]),
        (vectors(WAVE, 1e-3 * WAVE, 0.0), [(0, 2), (1,)]),  # millimetres beside metres
        (vectors(WAVE, 1e-3 * WAVE, 1e-3 * WAVE**2), [(0,), (1, 2)]),
        (vectors(1e-3 * WAVE, 2e-3 * WAVE, 5.0), [(0, 1), (2,)]),  # small ones far from a third
        (vectors(WAVE, 1e-14 * WAVE, 0.0), [(0, 1, 2)]),  # round-off is nothing to be seen
        (vectors(0.0, 0.0, 0.0), [(0, 1, 2)]),
        (vectors(np.nan, 1.0, 2.0), [(0, 1, 2)]),
        (1e-9 * vectors(WAVE, 1e-3 * WAVE, 0.0), [(0, 2), (1,)]),
    ],
)
def test_components_that_hide_each_other_have_panels_of_their_own(history, groups):
    assert legible(history) == groups


def test_a_line_of_what_is_nothing_lies_in_the_middle():
    """Without a word from Matplotlib, which knows no axis of no length."""
    axis = Figure().add_subplot()
    axis.plot([0.0, 1.0], [0.0, 0.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hold_still([axis], size=0.0)
    assert axis.get_ylim() == pytest.approx((-0.05, 0.05))


def test_a_marker_with_millimetres_beside_metres(tmp_path):
    values = block(times())
    values["markers/position"][:, 0] = vectors(WAVE, 1e-3 * WAVE, 0.0)
    values["markers/velocity"][:, 0] = vectors(WAVE, 1e-3 * WAVE, 0.0)
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("markers", [results.select(markers=["tip"])], ["run"])
    assert ylabels(figure) == ["tip: x (m)", "velocity x (m/s)", "tip: y (m)", "velocity y (m/s)"]
    np.testing.assert_array_equal(lines(figure.axes[2])["y"], 1e-3 * WAVE)
    low, high = figure.axes[2].get_ylim()
    assert high - low < 3e-3
    assert legend(figure) == ["x", "y"]


def test_torques_of_round_off_are_said_and_not_drawn(tmp_path):
    values = block(times())
    values["joints/reaction_torque"] = 1e-13 * values["joints/reaction_torque"]
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("reactions", [results], ["run"])
        assert ylabels(figure) == ["|reaction force| (N)"]
        assert "reaction torques are zero (at most 2e-13 N m)" in figure.get_supxlabel()
        assert ylabels(draw("reactions", [results, results], ["a", "b"])) == [
            "A: |force| (N)",
            "|Δ| (N)",
            "Gelenk ä: |force| (N)",
            "|Δ| (N)",
        ]


def test_torques_that_loads_make_are_drawn(tmp_path):
    values = block(times())
    values["joints/reaction_torque"] = 1e-7 * values["joints/reaction_torque"]
    with open_results(record(tmp_path / "run.h5", values)) as results:
        assert len(draw("reactions", [results], ["run"]).axes) == 2


def test_angles_without_a_violation_are_said_and_not_drawn(tmp_path):
    values = block(times())
    values["joints/violation_angle"] = np.zeros((201, 2))
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("joints", [results], ["run"])
    assert ylabels(figure) == ["violation (m)"]
    assert "angles: no violation above 10⁻¹⁷" in figure.get_supxlabel()


def test_coordinates_that_coincide_are_drawn_once(tmp_path):
    names = dict(NAMES) | {"coordinates": ["A.angle", "B.angle", "C.angle"], "coordinate_units": ["rad"] * 3}
    values = block(times(), names)
    values["joints/coordinate"][:, 2] = values["joints/coordinate"][:, 0] + 1e-14
    values["joints/speed"][:, 2] = values["joints/speed"][:, 0]
    with open_results(record(tmp_path / "run.h5", values, names=names)) as results:
        figure = draw("coordinates", [results], ["run"])
    assert ylabels(figure) == ["A.angle (°)", "speed (°/s)", "B.angle (°)", "speed (°/s)"]
    assert "A.angle and C.angle coincide" in figure.get_supxlabel()


def test_what_three_forces_act_along_is_drawn_once(tmp_path):
    names = dict(NAMES) | {"forces": ["spring", "damper", "push", "motor"], "force_units": ["rad"] * 4}
    values = block(times(), names)
    for column in (1, 3):
        values["forces/coordinate"][:, column] = values["forces/coordinate"][:, 0]
    with open_results(record(tmp_path / "run.h5", values, names=names)) as results:
        figure = draw("forces", [results], ["run"])
        assert ylabels(figure) == ["A.angle (°)", "torque (N m)", "push (°)", "torque (N m)"]
        assert legend(figure)[-3:] == ["spring", "damper", "motor"]
        np.testing.assert_array_equal(lines(figure.axes[1])["motor"], results["forces/force"][:, 3])
        both = draw("forces", [results, results], ["a", "b"])
    assert ylabels(both) == [
        "A.angle (°)",
        "torque of spring (N m)",
        "torque of damper (N m)",
        "torque of motor (N m)",
        "|Δ| (°)",
        "|Δ| (N m)",
        "push (°)",
        "torque (N m)",
        "|Δ| (°)",
        "|Δ| (N m)",
    ]


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        (vectors(3.0, 0.0, 1.0), "no marker moves"),
        pytest.param(vectors(3.0 + 1e-16 * WAVE, 0.0, 1.0), "no marker moves", marks=pytest.mark.full),
        (vectors(3.0, WAVE, 1.0), "the markers move along an axis, to and fro: see 'markers'"),
        (vectors(0.0, WAVE, 0.1 * WAVE), None),
    ],
)
def test_paths_without_anything_to_see_are_left_out_with_a_note(tmp_path, path, reason, undrawn):
    values = block(times())
    values["markers/position"][:] = path[:, None]
    file = record(tmp_path / "run.h5", values)
    with open_results(file) as results:
        assert nothing_to_see("paths", [results]) == reason
    kinds = [word for kind in ("paths", "violation") for word in ("--kind", kind)]
    asked = CliRunner().invoke(plot.command, [str(file), *kinds, "-o", str(tmp_path)], catch_exceptions=False)
    assert asked.stdout.split() == [f"{tmp_path}/run-{kind}.png" for kind in ("paths", "violation")]


def test_a_note_says_that_no_marker_moves(tmp_path, monkeypatch):
    monkeypatch.setattr(plot, "KINDS", {kind: KINDS[kind] for kind in ("paths", "violation")})
    values = block(times())
    values["markers/position"][:] = 1.0
    done = CliRunner().invoke(plot.command, [str(record(tmp_path / "run.h5", values)), "-o", str(tmp_path)])
    assert done.stdout == f"{tmp_path}/run-violation.png\n"
    assert done.stderr == "note: no picture 'paths': no marker moves\n"


def test_a_path_in_space_is_seen_from_three_sides_of_one_scale(tmp_path):
    values = block(times())
    values["markers/position"][:] = vectors(np.cos(times()), np.sin(times()), 0.5 * WAVE)[:, None]
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("paths", [results], ["run"])
        path = results.marker("tip").position
    assert [(axis.get_xlabel(), axis.get_ylabel()) for axis in figure.axes] == [
        ("x (m)", "y (m)"),
        ("x (m)", "z (m)"),
        ("y (m)", "z (m)"),
    ]
    spans = {round(float(np.ptp(limits)), 12) for axis in figure.axes for limits in (axis.get_xlim(), axis.get_ylim())}
    assert len(spans) == 1
    np.testing.assert_array_equal(figure.axes[2].lines[0].get_xdata(), path[:, 1])
    np.testing.assert_array_equal(figure.axes[2].lines[0].get_ydata(), path[:, 2])


def test_a_mechanism_at_rest_has_panels_of_its_own_size(tmp_path):
    values = block(times())
    for path in ("joints/coordinate", "joints/speed"):
        values[path] = 1e-16 * values[path]
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("coordinates", [results], ["run"])
    low, high = figure.axes[0].get_ylim()
    assert (low, high) == pytest.approx((-0.05 * 180.0 / np.pi, 0.05 * 180.0 / np.pi), rel=1e-6)
