"""Pictures show what an engineer looks for: no round-off, nothing hidden, nothing twice, names that choose."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

import mbproj
from mbproj.commands import plot
from mbproj.commands.main import mbproj as command
from mbproj.linear.modes import stored
from mbproj.results.reader import open_results
from mbproj.show.appearance.mechanism import look_of
from mbproj.show.appearance.motion import motion_at
from mbproj.show.figures.kinds import KINDS, draw, nothing_to_see
from mbproj.show.figures.linear import MODES_PICTURES
from mbproj.show.figures.over_time import legible
from mbproj.show.figures.panels import hold_still
from tests.figures.drawn import legend, lines, ylabels
from tests.results.pendulum_blocks import NAMES, block, record, times

# What would show nothing is not drawn, what hides something is drawn apart, and what is the same is drawn once.

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


# Pictures show what an engineer looks for: constants and round-off drawn as such, names that choose, labels apart.

#: A mass that hangs at rest on a spring, gripped by friction, beside a crank that is driven in the plane y = 0.
AT_REST = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.5, step: 5 ms}
bodies:
  mass: {mass: 0.5, inertia: [1e-3, 1e-3, 1e-3], position: [0, 0, -0.2]}
  crank: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [1, 0, 0]}
joints:
  guide: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [0, 0, 1]}
  pin: {type: revolute, bodies: [ground, crank], location: [1, 0, 0], axis: [0, 1, 0]}
forces:
  spring: {type: spring_damper, points: {ground: [0, 0, 0.3], mass: [0, 0, -0.2]}, stiffness: 49.05, free_length: 0.4}
  grip: {type: friction, joint: guide, coulomb: {force: 2, static: 3}}
motions: {turn: {joint: pin, angle: 3*t}}
markers: {tip: {body: crank, location: [1.1, 0, 0]}}
"""
MOUNT = "stiffness: {translation: [2e5, 2e5, 3e5]}, damping: {translation: [400, 400, 600]}"
#: A block on four mounts about its middle: six modes, each along or about an axis.
MOUNTED = f"""\
mbproj: 1
title: a block on four mounts
gravity: [0, 0, 0]
bodies: {{block: {{mass: 50, inertia: [3, 2, 4], position: [0, 0, 0]}}}}
forces:
  a: {{type: bushing, bodies: [ground, block], location: [0.3, 0.4, 0], {MOUNT}}}
  b: {{type: bushing, bodies: [ground, block], location: [-0.3, 0.4, 0], {MOUNT}}}
  c: {{type: bushing, bodies: [ground, block], location: [0.3, -0.4, 0], {MOUNT}}}
  d: {{type: bushing, bodies: [ground, block], location: [-0.3, -0.4, 0], {MOUNT}}}
"""
#: A disc by its inertia, whose mounts are elsewhere.
SOFT = "stiffness: {translation: [2e5, 2e5, 2e5]}"
CARRIER = f"""\
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {{carrier: {{mass: 20, inertia: [0.2, 0.4, 0.2], position: [0, 0.6, 0.3]}}}}
forces:
  upper: {{type: bushing, bodies: [ground, carrier], location: [0, 0.15, 0.55], {SOFT}}}
  front: {{type: bushing, bodies: [ground, carrier], location: [0.25, 0.1, 0.15], {SOFT}}}
  rear: {{type: bushing, bodies: [ground, carrier], location: [-0.25, 0.1, 0.15], {SOFT}}}
  coil: {{type: spring_damper, points: {{ground: [0, 0.45, 0.8], carrier: [0, 0.3, 0.4]}}, stiffness: 2e4}}
"""


@pytest.fixture(scope="module")
def at_rest(tmp_path_factory):
    with mbproj.run(AT_REST, output=tmp_path_factory.mktemp("rest") / "rest.h5") as results:
        yield results


def limits(figure, label: str) -> tuple[float, float]:
    """Of the axis that is named so."""
    return next(axis.get_ylim() for axis in figure.axes if axis.get_ylabel().startswith(label))


def test_a_constant_is_drawn_in_the_middle_of_its_size(at_rest):
    """The spring bears 4.905 N, to round-off; the axis shows 5 % of that to both sides, and needs no offset."""
    figure = at_rest.plot.forces("spring").figure
    low, high = limits(figure, "force (N)")
    assert (low, high) == (pytest.approx(-4.905 * 1.05), pytest.approx(-4.905 * 0.95))


def test_a_power_below_round_off_is_drawn_as_none(at_rest):
    """The friction sticks: its rate is round-off, and so is what it takes."""
    power = np.abs(at_rest.friction("grip").force * at_rest.friction("grip").rate).max()
    assert power < 1e-15
    low, high = limits(at_rest.plot.friction().figure, "power lost (W)")
    assert low < -1e9 * power and high > 1e9 * max(power, 1e-300)


def test_a_component_that_is_zero_everywhere_is_told_not_drawn(at_rest):
    figure = at_rest.plot.markers().figure
    assert legend(figure) == ["x", "z"]
    assert "y is zero throughout" in figure.get_supxlabel()


def test_names_choose_forces(at_rest, tmp_path):
    """From the command line, and from Python."""
    where = ["plot", str(at_rest.path), "-o", str(tmp_path)]
    done = CliRunner().invoke(command, [*where, "--kind", "friction", "--of", "grip"], catch_exceptions=False)
    assert (done.exit_code, done.stdout.endswith("rest-friction.png\n")) == (0, True)
    other = CliRunner().invoke(command, [*where, "--kind", "friction", "--of", "spring"], catch_exceptions=True)
    assert "the results have no dry friction" in str(other.exception)
    wrong = CliRunner().invoke(command, [*where, "--of", "sprung"], catch_exceptions=True)
    assert "no force, motion, stop or friction 'sprung' in the results; did you mean 'spring'?" in str(wrong.exception)
    assert at_rest.select(acting=["spring"]).names("forces") == ("spring",)
    assert at_rest.select(acting=["grip"]).names("motions") == ()


def test_a_force_of_several_coordinates_is_chosen_by_its_name():
    with mbproj.run(MOUNTED, duration=0.01, step=0.001) as results:
        chosen = results.select(acting=["b"])
        assert chosen.names("forces") == tuple(f"b.{part}" for part in ("x", "y", "z", "rx", "ry", "rz"))
        np.testing.assert_array_equal(chosen["forces/force"], results["forces/force"][:, 6:12])


@pytest.fixture(scope="module")
def mounted():
    return mbproj.modes(MOUNTED)


def test_modes_of_a_body_without_joints_name_its_axes(mounted):
    """By hand: k = 4 × 2e5 N/m along x and y, 4 × 3e5 along z; about x 4 × 3e5 × 0.4² N m on 3 kg m²."""
    found = {mounted.name(mode).split(" 1")[0]: mounted.frequencies[mode] for mode in range(6)}
    assert set(found) == {f"block {word} {axis}" for word in ("along", "about") for axis in "xyz"}
    undamped = np.abs(mounted.eigenvalues) / (2 * np.pi)
    names = [mounted.name(mode).split(" 1")[0] for mode in range(6)]
    assert undamped[names.index("block along z")] == pytest.approx(np.sqrt(1.2e6 / 50) / (2 * np.pi))
    assert undamped[names.index("block about x")] == pytest.approx(np.sqrt(1.2e6 * 0.4**2 / 3) / (2 * np.pi))


def test_eigenvalues_have_no_empty_half_and_their_numbers_are_apart(mounted):
    """Two modes along x and y are one dot with both numbers."""
    (axis,) = MODES_PICTURES["eigenvalues"](stored(mounted, "block")).axes
    left, right = axis.get_xlim()
    assert left < 1.02 * mounted.eigenvalues.real.min()
    assert 0 < right < -0.25 * left
    told = [text.get_text() for text in axis.texts]
    assert "1, 2" in told
    assert sum(len(text.split(",")) for text in told) == 6


def test_shapes_show_how_bodies_shift_and_turn(mounted):
    figure = MODES_PICTURES["shapes"](stored(mounted, "block"))
    left = figure.axes[0]
    assert [text.get_text() for text in left.get_yticklabels()] in (["block along x"], ["block along y"])
    assert figure.axes[-2].get_xlabel() == "shifts and turns of bodies, relative"


def test_a_body_is_drawn_by_the_bushings_and_springs_that_hold_it():
    """A bar from the centre of mass, or from another, to each."""
    scene = mbproj.read_scene_text(CARRIER)
    system = mbproj.compile_system(scene)
    motion = motion_at(system, mbproj.assemble(system, mbproj.initial_guess(scene, system)).q)
    parts = [drawn.part for drawn in look_of(scene, motion, {}).drawn if drawn.layer == "bodies"]
    outline = np.concatenate([part.outline() for part in parts])
    for point in ([0, -0.45, 0.25], [0.25, -0.5, -0.15], [-0.25, -0.5, -0.15], [0, -0.3, 0.1]):
        assert np.linalg.norm(outline - point, axis=1).min() < 0.03


def test_a_solid_that_reaches_its_bushings_stays():
    scene = mbproj.read_scene_text(MOUNTED)
    system = mbproj.compile_system(scene)
    motion = motion_at(system, mbproj.assemble(system, mbproj.initial_guess(scene, system)).q)
    (part,) = [drawn.part for drawn in look_of(scene, motion, {}).drawn if drawn.layer == "bodies"]
    assert part.kind == "box"
