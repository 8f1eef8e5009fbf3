"""What pictures of sweeps show of a table: values on axes that a person reads, failed cases, quantiles, shares."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.collections import QuadMesh

from mbproj.base.errors import InputError
from mbproj.results.sweep_table import Column, SweepCases
from mbproj.show.figures.kinds import SWEEP_PICTURES, draw_sweep, why_no_sweep
from mbproj.show.figures.style import save
from mbproj.show.figures.sweep_axes import choose
from mbproj.studies.sweep.spec import saltelli
from tests.figures.drawn import legend, lines, ylabels

#: Of the cases: a grid's one that fails.
BAD = 3


def table(combine, varied, measured, shape=None, samples=0):
    count = len(measured["y"][1])
    status = np.array(["done"] * count, dtype=object)
    status[np.isnan(measured["y"][1])] = "failed"
    of = [tuple(Column(name, unit, values) for name, (unit, values) in each.items()) for each in (varied, measured)]
    return SweepCases("some-sweep", "Sweep of some.yaml", combine, samples or count, shape or (count,), *of, status)


def grid():
    """y = x + k, 10 n k: x in m, n logarithmic, k a word; the case number 5 fails."""
    x, n, k = (each.reshape(-1) for each in np.meshgrid([0.1, 0.2, 0.3], [1.0, 10.0, 100.0], [0, 1], indexing="ij"))
    y = x + k
    y[BAD] = np.nan
    words = np.array([("slow", "fast")[int(each)] for each in k], dtype=object)
    varied = {"x": ("m", x), "n": ("1", n), "k": ("1", words)}
    return table("grid", varied, {"y": ("m", y), "z": ("N*m", 1e4 * n * (k + 1.0)), "same": ("", x * 0.0)}, (3, 3, 2))


def sampled(combine="saltelli", samples=256):
    """y = 2 a + b + 0.1 c of uniform shares."""
    a, b, c = saltelli(3, samples, 0).T if combine == "saltelli" else np.random.default_rng(0).random((3, samples))
    y = 2.0 * a + b + 0.1 * c
    varied = {"a": ("rad", a), "b": ("m", 1.0 + b), "c": ("kg", 1.0 + c), "fixed": ("", 0.0 * a)}
    return table(combine, varied, {"y": ("N", y)}, samples=samples)


@pytest.mark.parametrize("kind", SWEEP_PICTURES)
def test_every_picture_can_be_saved_and_leaves_no_trace(kind, tmp_path):
    settings = mpl.rcParams.copy()
    chosen = choose(grid() if SWEEP_PICTURES[kind].designs & {"grid"} else sampled(), [], [])
    assert save(draw_sweep(kind, chosen), tmp_path / "picture.png").read_bytes()[:4] == b"\x89PNG"
    assert mpl.rcParams.copy() == settings


def test_lines_are_over_the_first_number_with_one_for_each_value_of_the_next():
    figure = draw_sweep("lines", choose(grid(), [], ["x", "k"]))
    assert legend(figure) == ["k = slow", "k = fast", "failed"]
    assert ylabels(figure) == ["y (m)", "z (kN m)"]
    shown = figure.axes[0].lines
    assert shown[0].get_xdata() == pytest.approx([100.0, 200.0, 300.0])
    assert shown[0].get_ydata() == pytest.approx([0.1, 0.2, 0.3])
    assert shown[1].get_ydata() == pytest.approx([np.nan, 1.2, 1.3], nan_ok=True)
    remark = figure.get_supxlabel()
    assert "at n = 10: choose others with --over" in remark
    assert "not drawn: same; choose with --of" in remark
    assert "grid, 18 cases, 1 failed" in remark


def test_a_failed_case_is_a_cross_at_its_place():
    """The case number 3 has x = 0.1 m, n = 10 and k = fast: it is not drawn where x has its middle value."""
    over_n = draw_sweep("lines", choose(grid(), ["y"], ["n", "k"]))
    assert legend(over_n) == ["k = slow", "k = fast"]
    at_first = draw_sweep("lines", choose(grid(), ["y"], ["x", "n"]))
    assert list(at_first.axes[0].lines[-1].get_xdata()) == [100.0]
    cross = draw_sweep("map", choose(grid(), ["y"], ["x", "n"])).axes[0].lines[-1]
    assert (cross.get_label(), list(cross.get_xdata()), list(cross.get_ydata())) == ("failed", [100.0], [10.0])


def test_a_map_has_each_value_at_its_place_and_logarithmic_axes_where_values_are():
    figure = draw_sweep("map", choose(grid(), ["y", "z"], []))
    first, second = figure.axes[:2]
    assert (first.get_xscale(), first.get_yscale()) == ("linear", "log")
    mesh = next(each for each in second.collections if isinstance(each, QuadMesh))
    assert np.asarray(mesh.get_array()) == pytest.approx(20.0 * np.array([[1.0] * 3, [10.0] * 3, [100.0] * 3]))
    hole = next(each for each in first.collections if isinstance(each, QuadMesh)).get_array()
    assert np.argwhere(np.ma.getmaskarray(hole)).tolist() == [[1, 0]]


def test_a_distribution_is_of_independent_samples_and_marks_its_quantiles():
    figure = draw_sweep("distribution", choose(sampled(), [], []))
    (axis,) = figure.axes
    values = sampled().measured[0].values[:512]
    assert sum(bar.get_height() for bar in axis.patches) == 512
    at = [line.get_xdata()[0] for line in axis.lines]
    assert at == pytest.approx(np.quantile(values, [0.05, 0.5, 0.95]).tolist())
    assert f"deviation {values.std(ddof=1):.3g}" in axis.get_title(loc="left")


def test_the_tornado_begins_with_the_strongest():
    (axis,) = draw_sweep("ranks", choose(sampled("lhs"), [], [])).axes
    assert [label.get_text() for label in axis.get_yticklabels()] == ["a", "b", "c"]
    widths = [bar.get_width() for bar in axis.patches]
    assert widths == sorted(widths, reverse=True)
    assert widths[0] > 0.8


def test_shares_of_a_sum_are_those_of_its_terms():
    (axis,) = draw_sweep("sobol", choose(sampled(), [], [])).axes
    shares = np.array([4.0, 1.0, 0.01]) / 5.01
    widths = np.array([bar.get_width() for bar in axis.patches]).reshape(2, 3)
    assert widths == pytest.approx(np.stack([shares, shares]), abs=0.03)


def test_the_matrix_holds_each_pair_once_and_crosses_where_both_are_known():
    some = sampled("montecarlo", 64)
    some.measured[0].values[:3] = np.nan
    some.status[:3] = "failed"
    figure = draw_sweep("scatter", choose(some, [], []))
    pairs = [axis for axis in figure.axes if axis.get_visible() and axis.lines]
    assert len(pairs) == 6
    assert sum("failed" in lines(axis) for axis in pairs) == 3
    assert legend(figure) == ["failed"]


def test_what_does_not_apply_says_why():
    reasons = {kind: why_no_sweep(kind, choose(sampled(), [], [])) for kind in ("lines", "map")}
    assert reasons["lines"] == "'saltelli' varies 3 quantities at once, and no line joins its cases"
    assert reasons["map"] == "it is of a grid, and the sweep combines by 'saltelli'"
    assert "take 'combine: saltelli'" in why_no_sweep("sobol", choose(grid(), [], []))


def test_names_that_the_sweep_does_not_have():
    with pytest.raises(InputError, match=r"--of: the sweep has no measure 'tip'"):
        choose(grid(), ["tip"], [])
    with pytest.raises(InputError, match=r"--over fixed: it has one value in this sweep"):
        choose(sampled(), [], ["fixed"])
