"""`mbproj curve`, and what `check` says of points of a cam that were rounded."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mbproj import curve, read_scene, read_scene_text
from mbproj.base.mechanisms_folder import mechanism
from mbproj.functions.plane_curve import ellipse
from mbproj.functions.space_curve import Track
from mbproj.scene.blocks.curve_sheet import sheet
from mbproj.scene.blocks.oversights import grain, notes_on
from mbproj.show.figures.designs import draw_profile
from tests.cli.commands import mbproj
from tests.mechanisms.curves.scenes import CAM, scene

# `mbproj curve`: the table of a profile against closed forms, and what the command refuses.

SCENE = str(mechanism("cam"))


@pytest.fixture(scope="module")
def lift():
    (track,) = read_scene(SCENE).curves
    return sheet(track, 361)


def test_the_pressure_angle_of_a_lift_law(lift):
    """tan α = r' / r, with r = 50 mm + 20 mm (x - sin(2πx)/2π) over 120 deg; clockwise, the law runs from the end."""
    x = (360.0 - np.degrees(lift.angle[300])) / 120.0
    radius = 50e-3 + 20e-3 * (x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi))
    slope = 20e-3 * (1.0 - np.cos(2.0 * np.pi * x)) / (2.0 * np.pi / 3.0)
    np.testing.assert_allclose(lift.radius[300], radius, rtol=1e-14)
    np.testing.assert_allclose(np.tan(lift.pressure[300]), slope / radius, rtol=1e-12)
    apart = np.hypot(lift.x - lift.line_x, lift.y - lift.line_y)
    np.testing.assert_allclose(apart, 12e-3, rtol=1e-13)


def test_the_curvature_and_the_largest_roller_of_an_ellipse():
    """κ = a b / (a² sin² + b² cos²)^1.5; inside the largest roller has the least radius of curvature b²/a."""
    a, b = 0.7, 0.4
    found = sheet(Track("oval", ellipse((a, b))), 73)
    s = np.linspace(0.0, 2.0 * np.pi, 73)
    expected = a * b / (a**2 * np.sin(s) ** 2 + b**2 * np.cos(s) ** 2) ** 1.5
    np.testing.assert_allclose(found.curvature, expected, rtol=1e-13)
    assert found.rollers["outside"] == np.inf
    assert found.rollers["inside"] == pytest.approx(b**2 / a, abs=2e-6)
    assert found.bends == pytest.approx((b / a**2, a / b**2), rel=1e-12)


CYCLOIDAL = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, tolerance: 1e-8}
curves:
  cam:
    lift:
      base: 25 mm
      rises: [[130 deg, 0 mm, dwell], [50 deg, 18 mm, cycloidal], [130 deg, 18 mm, dwell], [50 deg, 0 mm, cycloidal]]
bodies: {shaft: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: y}}
"""


def test_the_largest_roller_of_a_cam_is_that_of_its_hollow():
    """With r = base + s(θ), κ = (r² + 2 r'² - r r'') / (r² + r'²)^1.5: the roller outside has the radius of the hollow,
    whatever the rows."""
    lift, turn = 18.0, np.radians(50)
    u = np.linspace(0, 1, 200001)
    r = 25 + lift * (u - np.sin(2 * np.pi * u) / (2 * np.pi))
    r1, r2 = lift * (1 - np.cos(2 * np.pi * u)) / turn, lift * 2 * np.pi * np.sin(2 * np.pi * u) / turn**2
    bend = (r**2 + 2 * r1**2 - r * r2) / (r**2 + r1**2) ** 1.5
    found = curve(read_scene_text(CYCLOIDAL), rows=7)
    assert [1e-3 * each for each in found.bends] == pytest.approx([bend.min(), bend.max()], rel=1e-9)
    assert 1e3 * found.rollers["outside"] == pytest.approx(-1 / bend.min(), abs=2e-4)
    assert 1e3 * found.rollers["inside"] == pytest.approx(1 / bend.max(), abs=2e-4)


def test_the_table_the_object_and_the_picture(tmp_path, lift):
    done = mbproj("curve", SCENE, "--rows", "5", "--json", "-o", "lift.csv", folder=tmp_path)
    found = json.loads(done.stdout)
    assert (found["curve"], found["closed"], found["largest_roller"]["outside"]) == ("lift", True, None)
    table = np.loadtxt(tmp_path / "lift.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table, np.column_stack(list(found["table"].values())))
    figure = draw_profile(lift)
    assert [axis.get_ylabel().split("\n")[0] for axis in figure.axes[1:]] == [
        "radius (mm)",
        "pressure angle",
        "curvature (1/mm)",
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((SCENE, "lfit"), "NAME: error: unknown curve 'lfit'; did you mean 'lift'?"),
        ((str(mechanism("five_bar")),), "has no block 'curves'"),
        ((SCENE, "--plot", "lift.txt"), "'lift.txt' has no ending of a picture"),
    ],
)
def test_what_is_refused(tmp_path, arguments, message):
    done = mbproj("curve", *arguments, folder=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr


# Points of a cam that were rounded: `check` says by how much accelerations are uncertain, and is silent of others.


def notes(count, digits, key="table"):
    """Those on a cycloidal cam of 20 mm lift, by points of so many digits in m."""
    angle = 2.0 * np.pi * np.arange(count) / count
    x = np.minimum(angle, 2.0 * np.pi - angle) / np.pi
    radius = 0.05 + 0.02 * (x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi))
    rows = [(each, round(r, digits)) for each, r in zip(angle.tolist(), radius.tolist(), strict=True)]
    rows = [*rows, (2.0 * np.pi, rows[0][1])]
    if key == "points":
        rows = [(round(r * np.cos(a), digits), round(r * np.sin(a), digits)) for a, r in rows[:-1]]
    curve = f"  drawn: {{{key}: {[[float(a), float(b)] for a, b in rows]}{', closed: true' * (key == 'points')}}}\n"
    text = scene(CAM.replace("LAW", "cycloidal")).replace("curves:\n", f"curves:\n{curve}")
    return [note.message for note in notes_on(read_scene_text(text)) if "rounded" in note.message]


@pytest.mark.parametrize("key", ["table", "points"])
def test_a_table_rounded_to_a_micrometre(key):
    """12 r (N/2π)² with r = 0.5 µm and N = 720: 70.9 m/s² at 30 rad/s."""
    (message,) = notes(720, 6, key)
    assert "curve 'drawn' are rounded to 1 µm: accelerations are uncertain by 0.079 m times the square" in message
    assert 12.0 * 0.5e-6 * (720 / (2.0 * np.pi)) ** 2 * 30.0**2 == pytest.approx(70.9, rel=1e-3)


@pytest.mark.parametrize(("count", "digits"), [(36, 6), (720, 10), (12, 3)])
def test_points_that_do_no_harm_have_no_note(count, digits):
    """Few points, points with all their digits, and those that a designer has drawn."""
    assert notes(count, digits) == []


def test_half_of_the_last_digit():
    assert grain([0.25, 0.1]) == pytest.approx(0.005)
    assert grain([1.0 / 3.0]) == 0.0
    assert grain([0.05, 0.012345]) == pytest.approx(0.5e-6)
