"""Overlaid results: below what is shown stands how far they are from the first, where they share sample times."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.results.reader import open_results
from mbproj.show.figures.kinds import draw
from tests.figures.drawn import legend, lines, ylabels
from tests.results.pendulum_blocks import NAMES, block, record, times


@pytest.fixture
def apart(tmp_path):
    """A run, one whose marker is off by 3 mm and 4 mm and its angle by 1e-3 t, and one of half the samples."""
    other = block(times())
    other["markers/position"][:, 0, 0] += 3e-3
    other["markers/position"][:, 0, 2] += 4e-3
    other["joints/coordinate"][:, 0] += 1e-3 * times()
    other["joints/reaction_force"][:, 0, 1] += 5.0
    other["diagnostics/kinetic_energy"] += 1e-6
    half = block(times(101, 0.02))
    half["markers/position"][:, 0, 1] -= 1e-5
    written = [
        record(tmp_path / f"{name}.h5", values) for name, values in (("first", None), ("other", other), ("half", half))
    ]
    opened = [open_results(path) for path in written]
    yield opened
    for results in opened:
        results.close()


def below(figure, word: str):
    """The axes whose names begin with it."""
    return [axis for axis in figure.axes if axis.get_ylabel().startswith(word)]


def test_markers_are_apart_by_a_distance(apart):
    figure = draw("markers", [one.select(markers=["tip"]) for one in apart], ["first", "other", "half"])
    position, velocity = below(figure, "|Δ|")
    assert (position.get_ylabel(), velocity.get_ylabel()) == ("|Δ| (m)", "|Δ| (m/s)")
    assert position.get_yscale() == "log"
    np.testing.assert_allclose(lines(position)["other"], 5e-3, rtol=1e-12)
    np.testing.assert_allclose(lines(position)["half"], 1e-5, rtol=1e-9)
    half = next(line for line in position.lines if line.get_label() == "half")
    np.testing.assert_allclose(half.get_xdata(), times(101, 0.02), atol=1e-12)
    assert "first" not in lines(position)
    assert legend(figure) == ["first", "other", "half"]
    assert "|Δ|: difference from first, at the times of both" in figure.get_supxlabel()


def test_no_difference_at_all_is_zero_and_not_a_logarithm(apart):
    figure = draw("markers", [one.select(markers=["tip"]) for one in apart[:2]], ["first", "other"])
    velocity = below(figure, "|Δ|")[1]
    assert velocity.get_yscale() == "linear"
    np.testing.assert_array_equal(lines(velocity)["other"], 0.0)


def test_coordinates_are_apart_in_degrees(apart):
    figure = draw("coordinates", apart[:2], ["first", "other"])
    assert ylabels(figure) == ["A.angle (°)", "speed (°/s)", "|Δ| (°)", "|Δ| (°/s)"]
    drawn = lines(figure.axes[2])["other"]
    assert np.isnan(drawn[0])  # a logarithm has no zero
    np.testing.assert_allclose(drawn[1:], np.degrees(1e-3 * times()[1:]), rtol=1e-9)


def test_reactions_are_apart_by_the_length_of_the_difference(apart):
    figure = draw("reactions", apart[:2], ["first", "other"])
    assert ylabels(figure)[:4] == ["A: |force| (N)", "A: |torque| (N m)", "|Δ| (N)", "|Δ| (N m)"]
    np.testing.assert_allclose(lines(figure.axes[2])["other"], 5.0, rtol=1e-12)
    size = np.linalg.norm(apart[1].joint("A").reaction_force, axis=1)
    np.testing.assert_array_equal(lines(figure.axes[0])["other"], size)


def test_energies_are_apart(apart):
    figure = draw("energy", apart[:2], ["first", "other"])
    kinetic, _ = below(figure, "|Δ| of")
    np.testing.assert_allclose(lines(kinetic)["other"], 1e-6, rtol=1e-9)


@pytest.mark.parametrize(("kind", "dataset"), [("forces", "forces/coordinate"), ("motions", "motions/value")])
def test_what_forces_act_along_is_apart_in_degrees(tmp_path, results, kind, dataset):
    values = block(times())
    values[dataset] = values[dataset] + 1e-4
    with open_results(record(tmp_path / "other.h5", values)) as other:
        figure = draw(kind, [results, other], ["one", "two"])
    assert ylabels(figure)[2:] == ["|Δ| (°)", "|Δ| (N m)"]
    np.testing.assert_allclose(lines(figure.axes[2])["two"], np.degrees(1e-4), rtol=1e-9)


def test_without_a_common_time_there_is_no_difference_and_a_remark(tmp_path, results):
    shifted = block(times())
    shifted["time"] = times() + 0.003
    with open_results(record(tmp_path / "other.h5", shifted)) as other:
        figure = draw("markers", [results.select(markers=["tip"]), other.select(markers=["tip"])], ["one", "two"])
    assert len(figure.axes) == 4
    assert below(figure, "|Δ|") == []
    assert "no differences: the results share no sample time" in figure.get_supxlabel()


def test_a_name_that_only_one_result_has_is_drawn_without_a_difference(tmp_path, results):
    names = dict(NAMES) | {"markers": ["tip", "other"]}
    with open_results(record(tmp_path / "other.h5", block(times(), names), names=names)) as other:
        figure = draw("markers", [results.select(markers=["Mitte"]), other.select(markers=["other"])], ["one", "two"])
    assert [list(lines(axis)) for axis in below(figure, "Mitte: y")] == [["one"]]
    assert [list(lines(axis)) for axis in below(figure, "|Δ|")] == [[], [], [], []]
