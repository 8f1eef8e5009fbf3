"""Every picture fits a report's page, whatever names and titles it has: no text leaves it or lies over another."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.results.reader import open_results
from mbproj.show.figures.fitted_text import CUT, width, wrapped
from mbproj.show.figures.kinds import KINDS, draw
from mbproj.show.figures.panels import MOST_LINES, finish, panels, plot
from mbproj.show.figures.style import line, save
from tests.crossed import some
from tests.figures.geometry import outside, overlapping, texts
from tests.results.pendulum_blocks import NAMES, block, record, scene, times

LONG = "a_very_long_name_of_a_part_of_a_machine_" * 3
MANY = {
    "bodies": ["b"],
    "markers": [f"{LONG}{i}" for i in range(5)],
    "joints": [f"{LONG}J{i}" for i in range(41)],
    "coordinates": [*(f"{LONG}J{i}.angle" for i in range(41)), *(f"{LONG}R{i}.length" for i in range(3))],
    "coordinate_units": ["rad"] * 41 + ["m"] * 3,
    "tensions": [f"{LONG}R{i}.tension_{portion}" for i in range(3) for portion in (1, 2)],
    "touching": [f"{LONG}C{i}" for i in range(4)],
    "forces": [f"{LONG}F{i}" for i in range(9)],
    "force_units": ["rad"] * 9,
    "motions": [f"{LONG}M{i}" for i in range(3)],
    "motion_units": ["m"] * 3,
    "stops": [f"{LONG}S{i}" for i in range(9)],
    "stop_units": ["rad"] * 9,
    "frictions": [f"{LONG}R{i}" for i in range(9)],
    "friction_units": ["rad"] * 9,
}
TITLE = "A title that " + "goes on and on, " * 40 + "and costs 5 $ and $x^2$\nwith a new line"
#: A4 with margins, and the room that long legends and small print take of it at most, inches.
PAGE = 8.4 + 3.0


@pytest.fixture(scope="module")
def crowded(tmp_path_factory):
    """Two runs of the same with the longest names and titles."""
    folder = tmp_path_factory.mktemp("crowded")
    paths = [
        record(folder / f"{name}.h5", block(times(21), MANY, drift), scene(title=TITLE, **changes), names=MANY)
        for name, drift, changes in (("one", 1e-6, {}), ("two", 3e-6, {"overrides": {"p" * 300: "1e-3"}}))
    ]
    with open_results(paths[0]) as first, open_results(paths[1]) as second:
        yield [first, second]


#: What needs more than a run.
OTHERS = ("trust", "mechanism", "ratios", "transmission")


@pytest.mark.parametrize(
    ("kind", "results"), some([(kind, results) for kind in KINDS if kind not in OTHERS for results in (2, 1)], 11, 1)
)
def test_all_texts_are_on_the_page_and_beside_each_other(crowded, kind, results):
    figure = draw(kind, crowded[:results], ["first", "p" * 300 + " = 1e-3"][:results])
    drawn = texts(figure)
    assert outside(figure, drawn) == []
    assert overlapping(drawn) == []
    assert figure.get_figwidth() == 6.3
    assert figure.get_figheight() < PAGE


def test_long_small_print_is_cut_in_its_middle(crowded):
    lines = draw("energy", crowded[:1], ["run"]).get_supxlabel().splitlines()
    assert len(lines) == MOST_LINES
    assert CUT in "".join(lines)
    assert lines[0].startswith("A title that goes on and on, ")
    assert lines[-1].endswith("gpopm, rk4, step 0.01 s")


@pytest.mark.parametrize("text", ["position of tip (m)", LONG, "x" * 3000, "", "$ _ \\ ^", "機構 🙂 " * 30, "a " * 400])
@pytest.mark.parametrize(("room", "most"), [(1.0, 1), (2.0, 2), (6.0, 4)])
def test_lines_are_no_longer_than_the_room(text, room, most):
    lines = wrapped(text, room, 8.0, most)
    assert 1 <= len(lines) <= most
    assert all(width(line, 8.0) <= room for line in lines)
    whole = "".join(text.split())
    shown = "".join("".join(lines).split())
    head, cut, tail = shown.partition(CUT)
    assert (whole == shown) if not cut else (whole.startswith(head) and whole.endswith(tail) and len(tail) >= len(head))


def test_width_is_that_of_the_drawn_text():
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    for text in ("position of tip (m)", "WWWW", "iiiiiii", "|Ċ| α°"):
        drawn = text_to_path.get_text_width_height_descent(text, FontProperties(family="DejaVu Sans", size=9), False)[0]
        assert width(text, 9.0) == pytest.approx(drawn / 72.0, rel=0.03)


def test_panels_get_lower_where_a_page_is_full():
    heights = {rows: panels(rows)[0].get_figheight() for rows in (1, 2, 8)}
    assert heights[2] - heights[1] == pytest.approx(1.75)
    assert heights[8] == pytest.approx(8.4)


def test_the_figure_grows_with_its_legend_and_small_print():
    """So that panels keep their height."""

    def height(names: int, remark: str) -> float:
        figure, axes = panels(1)
        for index in range(names):
            plot(axes[0, 0], np.arange(3.0), np.arange(3.0), f"a name that takes some room, number {index}", index)
        return finish(figure, remark=remark).get_figheight()

    assert height(9, "") > height(3, "") + 0.2
    assert height(3, "a remark " * 40) > height(3, "a remark") + 0.2


def test_no_two_lines_look_alike():
    looks = [(look["color"], look["linestyle"]) for look in map(line, range(49))]
    assert len(set(looks)) == 49


def test_letters_without_a_picture_are_no_warning(tmp_path, recwarn):
    names = dict(NAMES) | {"joints": ["機構", "Ж"], "markers": ["先端", "🙂"]}
    with open_results(record(tmp_path / "run.h5", names=names, the_scene=scene(title="四節 \x07"))) as results:
        save(draw("joints", [results], ["run"]), tmp_path / "picture.png")
    assert [str(warning.message) for warning in recwarn] == []
