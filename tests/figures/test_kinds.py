"""Each picture shows the numbers of the results, with units and names, and shades what may be wrong."""

from __future__ import annotations

import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.patches import Rectangle

from mbproj import Mechanism, read_scene, simulate_certified
from mbproj.results.analysis.trust import usual_limit
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from mbproj.scene.settings import settings_to_run
from mbproj.show.figures import studies
from mbproj.show.figures.fitted_text import MAX_LINES
from mbproj.show.figures.kinds import KINDS, draw, why_not
from mbproj.show.figures.panels import FLOOR
from mbproj.show.figures.rows import MAX_ROWS, derive_labels
from mbproj.show.figures.style import save
from tests.crossed import some
from tests.figures.drawn import legend, lines, steep, ylabels
from tests.results.pendulum_blocks import NAMES, NO_NAMES, block, record, times
from tests.support import ROOT

# Each picture shows the results' own numbers, with units on its axes and a name for every line.


def times_agree(figure, results) -> bool:
    return all(np.array_equal(line.get_xdata(), results.time) for axis in figure.axes for line in axis.lines)


def test_markers(tmp_path):
    results = open_results(record(tmp_path / "run.h5", steep(block(times()))))
    figure = draw("markers", [results], ["run"])
    assert ylabels(figure) == ["position of tip (m)", "velocity (m/s)", "position of Mitte (m)", "velocity (m/s)"]
    assert legend(figure) == ["y", "z"]
    assert "x is zero throughout" in figure.get_supxlabel()
    for axis, (name, member) in zip(
        figure.axes, [(name, member) for name in NAMES["markers"] for member in ("position", "velocity")], strict=True
    ):
        drawn, values = lines(axis), getattr(results.marker(name), member)
        for index, component in ((1, "y"), (2, "z")):
            assert np.array_equal(drawn[component], values[:, index])
    assert [axis.get_xlabel() for axis in figure.axes[-2:]] == ["time (s)", "time (s)"]
    assert times_agree(figure, results)


def test_markers_overlaid(two):
    shown = [one.select(markers=["tip"]) for one in two]
    figure = draw("markers", shown, derive_labels(two))
    assert legend(figure) == ["gpopm", "gopm"]
    assert ylabels(figure)[:2] == ["tip: y (m)", "velocity y (m/s)"]
    assert np.array_equal(lines(figure.axes[1])["gopm"], two[1].marker("tip").velocity[:, 1])


def test_round_off_is_not_blown_up(tmp_path):
    """x is 0.3 m but for round-off, y moves by 0.43 m: its panel keeps the scale of the others."""
    values = block(times())
    values["markers/position"][:, 0, 0] = 0.3 + 1e-15 * np.cos(np.arange(len(times())))
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("markers", [results.select(markers=["tip"])] * 2, ["a", "b"])
        span = np.ptp(results.marker("tip").position[:, 1])
    low, high = figure.axes[0].get_ylim()
    assert (low, high) == pytest.approx((0.3 - 0.05 * span, 0.3 + 0.05 * span))


@pytest.mark.parametrize(("kind", "name", "value"), [("forces", "spring", "coordinate"), ("motions", "drive", "value")])
def test_forces_and_motions(results, kind, name, value):
    figure = draw(kind, [results], ["run"])
    assert ylabels(figure) == [f"{name}: A.angle (°)", "torque (N m)"]
    for axis, member, factor in zip(figure.axes, (value, "force"), (180.0 / np.pi, 1.0), strict=True):
        np.testing.assert_array_equal(lines(axis)["run"], factor * results[f"{kind}/{member}"][:, 0])
    assert times_agree(figure, results)


def test_forces_share_a_panel_only_along_one_coordinate(tmp_path):
    """A slide that happens to move by as many m as a hinge by rad has a panel of its own."""
    names = {**NAMES, "forces": ["hinge", "brake", "slide"], "force_units": ["rad", "rad", "m"]}
    values = block(times(), names)
    values["forces/coordinate"][:] = values["forces/coordinate"][:, :1]
    with open_results(record(tmp_path / "run.h5", values, names=names)) as results:
        figure = draw("forces", [results], ["run"])
    assert [label.split("(")[-1] for label in ylabels(figure)] == ["°)", "N m)", "m)", "N)"]
    assert [len(axis.lines) for axis in figure.axes] == [1, 2, 1, 1]


def test_coordinates(results):
    figure = draw("coordinates", [results], ["run"])
    assert ylabels(figure) == ["A.angle (°)", "speed (°/s)"]
    for axis, path in zip(figure.axes, ("joints/coordinate", "joints/speed"), strict=True):
        np.testing.assert_allclose(axis.lines[0].get_ydata(), np.degrees(results[path][:, 0]), rtol=1e-15)
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
    assert figure.get_supxlabel().splitlines()[1] == "zero and what is below 10⁻¹⁷ is drawn at 10⁻¹⁷"


def test_joints(results):
    figure = draw("joints", [results], ["run"])
    assert ylabels(figure) == ["violation (m)", "violation (rad)"]
    assert legend(figure) == ["A", "Gelenk ä"]
    assert np.array_equal(lines(figure.axes[0])["A"], results.joint("A").violation_length)
    assert np.array_equal(lines(figure.axes[1])["Gelenk ä"], results.joint("Gelenk ä").violation_angle)
    assert {axis.get_yscale() for axis in figure.axes} == {"log"}


def test_a_row_for_each_joint_where_lines_are_results(two):
    figure = draw("joints", two, ["one", "two"])
    assert ylabels(figure) == [
        "A: violation (m)",
        "A: violation (rad)",
        "Gelenk ä: violation (m)",
        "Gelenk ä: violation (rad)",
    ]
    assert legend(figure) == ["one", "two"]
    assert figure.axes[0].get_ylim() == figure.axes[2].get_ylim()
    assert np.array_equal(lines(figure.axes[3])["two"], two[1].joint("Gelenk ä").violation_angle)


def test_energy(two):
    figure = draw("energy", two[:1], ["one"])
    assert ylabels(figure) == ["energy (J)", "energy balance (J)"]
    assert legend(figure) == ["kinetic", "potential", "total"]
    assert np.array_equal(lines(figure.axes[0])["total"], two[0]["diagnostics/total_energy"])
    assert np.array_equal(figure.axes[1].lines[0].get_ydata(), 1e-6 * times())
    figure = draw("energy", two, ["one", "two"])
    assert ylabels(figure)[:4] == [
        "kinetic energy (J)",
        "potential energy (J)",
        "total energy (J)",
        "energy balance (J)",
    ]
    assert np.array_equal(lines(figure.axes[3])["two"], -3e-6 * times())
    assert np.array_equal(lines(figure.axes[1])["one"], two[0]["diagnostics/potential_energy"])


def test_steps(results):
    figure = draw("steps", [results], ["run"])
    assert ylabels(figure) == ["step size (s)", "position iterations a step", "velocity iterations a step"]
    size, position, velocity = (axis.lines[0].get_ydata() for axis in figure.axes)
    assert np.array_equal(size, np.full(201, 0.01))
    assert np.isnan(position[0])
    assert np.isnan(velocity[0])
    assert np.array_equal(position[1:], np.full(200, 2.0))
    assert np.array_equal(velocity[1:], np.full(200, 1.0))
    assert figure.axes[0].get_yscale() == "linear"


def test_rejected_steps_are_marked(tmp_path):
    values = block(times())
    values["diagnostics/rejected_steps"] = np.cumsum(np.isin(np.arange(201), (0, 50, 51, 120)))
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("steps", [results], ["run"])
    _, crosses = figure.axes[0].lines
    np.testing.assert_array_equal(crosses.get_xdata(), times()[[50, 51, 120]])
    np.testing.assert_array_equal(crosses.get_ydata(), 0.01)
    assert "steps were rejected" in figure.get_supxlabel()


def test_steps_of_very_different_size_have_a_logarithmic_axis(tmp_path):
    values = block(times())
    values["diagnostics/step_size"] = np.geomspace(1e-6, 1e-2, 201)
    values["diagnostics/steps"][100:] = 100
    with open_results(record(tmp_path / "run.h5", values)) as results:
        figure = draw("steps", [results], ["run"])
    assert figure.axes[0].get_yscale() == "log"
    # No step ended between the later samples: they lie in the one before.
    np.testing.assert_array_equal(figure.axes[1].lines[0].get_ydata()[1:], 2.0)


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


# What holds of every kind of picture: it can be saved, of one sample too, with any names, and says what it is of.

#: What can be drawn of a run that is not certified, has no stops or frictions, and whose scene is not in its
#: file; what takes an input or markers is in tests/analysis/test_over_coordinates.py.
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
        "from mbproj.base.registry import load\n"
        "[load(kind.draws) for kind in k.KINDS.values()]\n"
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


# Pictures of reactions: magnitudes or components, and what redundant joints share at will is grey.


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


# The paper's figures: arrays in, lines out, and what the step does not resolve shaded.

TIME = times(1001)
TIP = block(TIME)["markers/position"][:, 0]


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


# What the error of a certified run may have made wrong is marked from the time on that the certificate says.


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


def test_times_below_a_millisecond_have_one_prefix():
    """Of a page that compares methods: "0.4" under the axis in ms, where "400m" stood."""
    from mbproj.show.figures.studies import Compared, comparison_page

    time, low = np.linspace(0.0, 1.0, 5), np.full(5, 1e-9)
    methods = [Compared("gpopm", time, low, low, low, low, low, low, (5e-4, 4e-4, 6e-4), 12_000, 30_000)]
    figure = comparison_page(methods, low, "")
    figure.canvas.draw()
    costs, counts = figure.axes[6:8]
    labels = [label.get_text().removeprefix("$\\mathdefault{").removesuffix("}$") for label in costs.get_xticklabels()]
    assert "0.4" in labels and not any("m" in label for label in labels)
    assert any(label.get_text().endswith("k") for label in counts.get_xticklabels())
