"""The words of pictures: legends, units that a person reads, and all within the page."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from mbproj.base.settings import ProjectionSettings
from mbproj.results.reader import open_results
from mbproj.show.figures.fitted_text import CUT, width, wrapped
from mbproj.show.figures.kinds import KINDS, draw
from mbproj.show.figures.panels import MOST_LINES, finish, panels, plot
from mbproj.show.figures.rows import derive_labels
from mbproj.show.figures.style import DEGREES, METRES, TURNS, line, save, units_of
from tests.crossed import some
from tests.figures.drawn import lines, ylabels
from tests.results.pendulum_blocks import NAMES, SETTINGS, block, record, scene, times

# Where the texts of a figure are: what leaves the page, and what lies over something else.

#: A text with its place in pixels.
Placed = tuple[str, Bbox]
#: Pixels by which boxes of texts may overlap: letters do not fill them.
SLACK = 2.0


def texts(figure: Figure) -> list[Placed]:
    """Every text that is drawn. Drawing is what takes the time."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    drawn: list[Text] = []
    for axes in (axes for axes in figure.axes if axes.get_visible()):
        drawn += [axes.xaxis.label, axes.yaxis.label, axes.title, *axes.texts]
        drawn += [axes.xaxis.get_offset_text(), axes.yaxis.get_offset_text()]
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
            drawn += [tick.label1 for tick in ticks if low <= tick.get_loc() <= high and tick.label1.get_visible()]
    for legend in [*figure.legends, *(legend for part in figure.subfigs for legend in part.legends)]:
        drawn += legend.get_texts()
    if figure._supxlabel is not None:
        drawn.append(figure._supxlabel)
    return [(text.get_text(), text.get_window_extent(renderer)) for text in drawn if text.get_text().strip()]


def outside(figure: Figure, drawn: list[Placed]) -> list[str]:
    """The texts that are not wholly on the page."""
    page = figure.bbox.padded(1.0)
    return [
        text
        for text, box in drawn
        if not (page.x0 <= box.x0 and box.x1 <= page.x1 and page.y0 <= box.y0 and box.y1 <= page.y1)
    ]


def overlapping(drawn: list[Placed]) -> list[tuple[str, str]]:
    """Pairs of texts of which one lies over the other."""
    found = []
    for (one, first), (other, second) in combinations(drawn, 2):
        wide = min(first.x1, second.x1) - max(first.x0, second.x0)
        high = min(first.y1, second.y1) - max(first.y0, second.y0)
        if wide > SLACK and high > SLACK:
            found.append((one, other))
    return found


# Every picture fits a report's page, whatever names and titles it has: no text leaves it or lies over another.

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


# A legend says what the overlaid runs differ in.

GOPM = replace(SETTINGS, projection=ProjectionSettings("gopm", tolerance=1e-13))
BAUMGARTE = replace(SETTINGS, projection=ProjectionSettings("baumgarte", tolerance=1e-13, gains=(25.0, 25.0)))


@pytest.mark.parametrize(
    ("scenes", "labels"),
    [
        ([{}, {"settings": GOPM}, {"settings": BAUMGARTE}], ["gpopm", "gopm", "baumgarte"]),
        ([{}, {"settings": replace(SETTINGS, step=0.005)}], ["h = 0.01 s", "h = 0.005 s"]),
        ([{}, {"settings": replace(GOPM, step=0.005)}], ["gpopm, h = 0.01 s", "gopm, h = 0.005 s"]),
        (
            [{"settings": replace(SETTINGS, integrator="dop853", step=None, tolerance=1e-9)}, {}],
            ["tolerance 1e-09, dop853", "h = 0.01 s, rk4"],
        ),
        ([{}, {"settings": replace(SETTINGS, duration=5.0)}], ["duration 2", "duration 5"]),
        ([{"overrides": {"mass": "2"}}, {"overrides": {"mass": "3"}}], ["mass = 2", "mass = 3"]),
        ([{}, {}], ["run0", "run1"]),
        ([{}, {"settings": GOPM}, {}], ["run0: gpopm", "run1: gopm", "run2: gpopm"]),
        ([{}, {"title": "another", "settings": GOPM}], ["run0: gpopm", "run1: gopm"]),
        ([{}], ["run0"]),
    ],
)
def test_labels(tmp_path, scenes, labels):
    with ExitStack() as stack:
        opened = [
            stack.enter_context(open_results(record(tmp_path / f"run{i}.h5", block(times(3)), scene(**changes))))
            for i, changes in enumerate(scenes)
        ]
        assert derive_labels(opened) == labels


def test_the_same_run_in_two_directories(tmp_path):
    paths = [tmp_path / name / "results.h5" for name in "ab"]
    for path in paths:
        path.parent.mkdir()
        record(path, block(times(3)))
    with open_results(paths[0]) as first, open_results(paths[1]) as second:
        assert derive_labels([first, second]) == [str(path) for path in paths]


# Angles are read in degrees, or in turns where there are many; what is recorded stays in radians.


def turning(tmp_path, turns: float):
    """The pendulum whose coordinate goes round, with its results."""
    values = block(times())
    values["joints/coordinate"][:, 0] = np.linspace(0.0, 2.0 * np.pi * turns, 201)
    values["joints/speed"][:, 0] = np.pi * turns
    return open_results(record(tmp_path / "run.h5", values))


@pytest.mark.parametrize(
    ("turns", "labels", "end", "speed"),
    [
        (1.0, ["A.angle (°)", "speed (°/s)"], 360.0, 180.0),
        (10.0, ["A.angle (°)", "speed (°/s)"], 3600.0, 1800.0),
        (-300.0, ["A.angle (turns)", "speed (rpm)"], -300.0, -9000.0),
    ],
)
def test_degrees_or_turns(tmp_path, turns, labels, end, speed):
    with turning(tmp_path, turns) as results:
        figure = draw("coordinates", [results], ["run"])
        assert ylabels(figure) == labels
        assert lines(figure.axes[0])["run"][-1] == pytest.approx(end)
        assert lines(figure.axes[1])["run"][-1] == pytest.approx(speed)
        assert results["joints/coordinate"][-1, 0] == pytest.approx(2.0 * np.pi * turns)
        assert results.names("coordinate_units") == ("rad",)


@pytest.mark.parametrize(("turns", "step"), [(0.2, 15), (0.6, 45), (2.0, 180), (9.0, 720)])
def test_ticks_stand_at_parts_of_a_turn(tmp_path, turns, step):
    with turning(tmp_path, turns) as results:
        axis = draw("coordinates", [results], ["run"]).axes[0]
    assert set(np.diff(axis.get_yticks()).round(9)) == {step}


def test_lengths_stay_in_metres(tmp_path):
    names = dict(NAMES) | {"coordinate_units": ["m"], "coordinates": ["A.displacement"]}
    with open_results(record(tmp_path / "run.h5", block(times(), names), names=names)) as results:
        figure = draw("coordinates", [results], ["run"])
        assert ylabels(figure) == ["A.displacement (m)", "speed (m/s)"]
        np.testing.assert_array_equal(lines(figure.axes[0])["run"], results["joints/coordinate"][:, 0])


def test_units_are_chosen_by_what_is_finite():
    assert units_of("rad", [np.array([0.0, np.nan, np.inf])]) is DEGREES
    assert units_of("rad", [np.array([0.0]), np.array([100.0])]) is TURNS
    assert units_of("m", [np.array([1e9])]) is METRES
