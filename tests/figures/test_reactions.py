"""Pictures of reactions: magnitudes or components, and what redundant joints share at will is grey."""

from __future__ import annotations

import numpy as np

from mbproj.results.reader import open_results
from mbproj.show.figures.kinds import draw
from tests.figures.drawn import legend, lines, ylabels
from tests.results.pendulum_blocks import record


def test_reactions_are_magnitudes_of_several_and_components_of_one(results):
    figure = draw("reactions", [results], ["run"])
    assert ylabels(figure) == ["|reaction force| (N)", "|reaction torque| (N m)"]
    size = np.linalg.norm(results.joint("Gelenk ä").reaction_torque, axis=1)
    assert np.array_equal(lines(figure.axes[1])["Gelenk ä"], size)
    single = draw("reactions", [results.select(joints=["A"])], ["run"])
    assert ylabels(single) == ["reaction force of A (N)", "reaction torque of A (N m)"]
    assert np.array_equal(lines(single.axes[0])["z"], results.joint("A").reaction_force[:, 2])


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
