"""What the error of a certified run may have made wrong is marked from the time on that the certificate says."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from mbproj import Mechanism, read_scene, simulate_certified
from mbproj.results.analysis.trust import usual_limit
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from mbproj.scene.settings import settings_to_run
from mbproj.show.figures.kinds import draw, why_not
from tests.support import ROOT


@pytest.fixture(scope="module")
def certified(tmp_path_factory):
    path = tmp_path_factory.mktemp("trust") / "run.h5"
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml", {}, {"duration": 5})
    ready = Mechanism.of(scene)
    with ResultsWriter(path, scene, ready.system.names.as_mapping(), certified=[1e-3]) as recorder:
        simulate_certified(ready, settings_to_run(scene), recorder, limits=[1e-3])
    with open_results(path) as opened:
        yield opened


def shaded_from(axis) -> float:
    (span,) = [patch for patch in axis.patches if isinstance(patch, Rectangle)]
    return span.get_x()


@pytest.mark.parametrize("kind", ["markers", "coordinates", "reactions"])
def test_panels_are_shaded_from_the_horizon_on(certified, kind):
    figure = draw(kind, [certified], ["run"], 1e-3)
    since = certified.trust.horizon[0, 0]
    assert {shaded_from(axis) for axis in figure.axes} == {since}
    assert "shaded: the error may exceed 0.001 m" in figure.get_supxlabel()


def test_paths_are_pale_after_it(certified):
    figure = draw("paths", [certified], ["run"], 1e-3)
    clear, pale = figure.axes[0].lines
    late = certified.time >= certified.trust.horizon[0, 0]
    np.testing.assert_array_equal(np.isnan(clear.get_xdata()), late)
    assert len(pale.get_xdata()) == np.count_nonzero(late)
    assert "pale: the error may exceed 0.001 m" in figure.get_supxlabel()


def test_nothing_is_marked_where_all_is_well_or_where_the_motion_is_not_shown(certified):
    for kind, limit in (("markers", 1.0), ("violation", 1e-9), ("energy", 1e-9)):
        figure = draw(kind, [certified], ["run"], limit)
        assert not any(axis.patches for axis in figure.axes)
        assert "shaded" not in figure.get_supxlabel()


def test_the_usual_limit_is_a_power_of_ten_below_a_thousandth_of_the_travel(certified):
    assert usual_limit([certified]) == pytest.approx(1e-3)  # the tip travels over some 9 m


def test_the_error_over_time(certified):
    assert why_not("trust", [certified]) is None
    figure = draw("trust", [certified], ["run"])
    (line,) = figure.axes[0].lines
    np.testing.assert_array_equal(line.get_ydata()[1:], certified.trust.error[1:, 0])
    assert figure.axes[0].get_ylabel() == "error of tip (m)"
    window = draw("trust", [certified.select(start=2.0, stop=3.0)], ["run"])
    assert window.axes[0].lines[0].get_xdata()[[0, -1]] == pytest.approx([2.0, 3.0])
