"""What holds of every kind of picture: it can be saved, of one sample too, with any names, and says what it is of."""

from __future__ import annotations

import subprocess
import sys

import matplotlib as mpl
import pytest

from mbproj.results.reader import open_results
from mbproj.show.figures.fitted_text import MAX_LINES
from mbproj.show.figures.kinds import KINDS, draw, why_not
from mbproj.show.figures.rows import MAX_ROWS
from mbproj.show.figures.style import save
from tests.crossed import some
from tests.figures.drawn import legend, steep, ylabels
from tests.results.pendulum_blocks import NAMES, NO_NAMES, block, record, times

#: What can be drawn of a run that is not certified, has no stops or frictions, and whose scene is not in its
#: file; what takes an input or markers is in test_over.py.
OTHERS = ("trust", "mechanism", "stops", "ropes", "contacts", "friction", "ratios", "transmission")
UNCERTIFIED = [kind for kind in KINDS if kind not in OTHERS]


@pytest.mark.parametrize(
    ("kind", "suffix"), [*some([(kind, "png") for kind in UNCERTIFIED], 12, 2), ("steps", "svg"), ("energy", "pdf")]
)
def test_every_kind_can_be_saved_and_leaves_no_trace(two, tmp_path, kind, suffix):
    settings = mpl.rcParams.copy()
    path = save(draw(kind, two, ["one", "two"]), tmp_path / f"picture.{suffix}")
    first = path.read_bytes()
    assert first[:5] in (b"\x89PNG\r", b"<?xml", b"%PDF-")
    assert mpl.rcParams.copy() == settings


@pytest.mark.parametrize("kind", some(UNCERTIFIED, 2))
def test_one_sample_is_a_dot(tmp_path, kind):
    with open_results(record(tmp_path / "run.h5", block(times(1)))) as results:
        figure = draw(kind, [results], ["run"])
        assert {line.get_marker() for axis in figure.axes for line in axis.lines} == {"o"}
        figure.draw_without_rendering()


def test_names_with_signs_of_mathematics(tmp_path):
    names = dict(NAMES) | {"joints": ["_hidden", "$x"], "markers": ["a_$", "_b"]}
    with open_results(record(tmp_path / "run.h5", names=names)) as results:
        assert legend(draw("joints", [results], ["run"])) == [" _hidden", r"\$x"]
        assert ylabels(draw("markers", [results], ["run"]))[0] == r"a_\$: y (m)"


def test_what_does_not_apply(tmp_path):
    with open_results(record(tmp_path / "run.h5", block(times(), NO_NAMES), names=NO_NAMES)) as results:
        reasons = {kind: why_not(kind, [results]) for kind in KINDS}
    assert {kind for kind, reason in reasons.items() if reason is None} == {"violation", "energy", "steps"}
    assert reasons["motions"] == "the results have no motions"
    assert reasons["coordinates"] == "the results have no joint coordinates"


def test_kinds_are_listed_without_matplotlib_and_drawn_without_pyplot():
    code = (
        "import sys, mbproj.show.figures.kinds as k\n"
        "light = {'matplotlib', 'numpy', 'h5py'} & set(sys.modules)\n"
        "from importlib import import_module\n"
        "[import_module('mbproj.show.figures.kinds.' + kind.module) for kind in k.KINDS.values()]\n"
        "import mbproj.show.figures.style\n"
        "print(light, 'matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set() False\n"


def test_a_picture_says_what_it_is_of(tmp_path):
    results = open_results(record(tmp_path / "run.h5", block(times())))
    settings = results.settings
    caption = draw("energy", [results], ["run"]).get_supxlabel().splitlines()[0]
    assert caption.startswith(f"{results.title}; {settings.projection.method}, {settings.integrator}, ")


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
    with open_results(record(tmp_path / "run.h5", steep(block(times(), many)), names=many)) as results:
        figure = draw("markers", [results], ["run"])
        assert len(figure.axes) == 2 * MAX_ROWS
        assert figure.get_supxlabel().splitlines()[1] == (
            "the first 8 of 11 markers: choose others with --marker; x is zero throughout"
        )
        figure = draw("joints", [results], ["run"])
        # Column i of the block is the first divided by i + 1: the first are the largest.
        assert legend(figure) == [f"j{i}" for i in range(MAX_LINES)]
        remark = figure.get_supxlabel().splitlines()[1]
        assert remark.startswith("the 7 largest of 20 joints: choose others with --joint")
