"""The paper's figures: arrays in, lines out, and what the step does not resolve shaded."""

from __future__ import annotations

import numpy as np

from mbproj.show.figures import studies
from mbproj.show.figures.style import save
from tests.results.pendulum_blocks import block, times

TIME = times(1001)
TIP = block(TIME)["markers/position"][:, 0]


def legend(figure) -> list[str]:
    return [text.get_text() for shown in figure.legends for text in shown.get_texts()]


def test_histories(tmp_path):
    figure = studies.position_history(TIME, TIP, components="yz")
    axis = figure.axes[0]
    assert (axis.get_xlabel(), axis.get_ylabel(), legend(figure)) == ("time (s)", "position (m)", ["y", "z"])
    for line, column in zip(axis.lines, (1, 2), strict=True):
        assert np.array_equal(line.get_ydata(), TIP[:, column])
    figure = studies.velocity_history(TIME, TIP)
    assert figure.axes[0].get_ylabel() == "velocity (m/s)"
    assert legend(figure) == ["$v_x$", "$v_y$", "$v_z$"]
    assert save(figure, tmp_path / "a.pdf").exists()


def test_errors():
    series = {"GPOPM": (TIME, np.full(1001, 1e-15)), "direct integration": (TIME[:400], 1e-9 * TIME[:400])}
    for function, symbol in (
        (studies.position_errors, r"position error $|C|_\infty$ (m or rad)"),
        (studies.velocity_errors, r"velocity error $|\dot{C}|_\infty$ (m/s or rad/s)"),
    ):
        figure = function(series)
        axis = figure.axes[0]
        assert (axis.get_yscale(), axis.get_ylabel(), legend(figure)) == ("log", symbol, list(series))
        assert np.array_equal(axis.lines[1].get_ydata()[1:], series["direct integration"][1][1:])
        assert axis.lines[1].get_ydata()[0] == 1e-17


def test_what_is_not_converged_is_shaded():
    figure = studies.position_history(TIME, TIP, unconverged_from=4.1)
    axis = figure.axes[0]
    assert axis.get_title(loc="right") == "step not converged from t = 4.1 s on (error > 1 mm)"
    (shade,) = axis.patches
    assert (shade.get_extents().transformed(axis.transData.inverted()).x0) == 4.1
    assert axis.get_xlim() == (0.0, 10.0)
    series = {"GPOPM": (TIME, np.full(1001, 1e-15))}
    figure = studies.velocity_errors(series, unconverged_from=5.0, unconverged_error="1 cm")
    assert figure.axes[0].get_title(loc="right") == "step not converged from t = 5 s on (error > 1 cm)"


def test_what_converges_is_not_shaded():
    for since in (None, 11.0):
        figure = studies.position_history(TIME, TIP, unconverged_from=since)
        assert len(figure.axes[0].patches) == 0
        assert figure.axes[0].get_title(loc="right") == ""
