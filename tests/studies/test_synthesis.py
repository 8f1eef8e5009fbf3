"""Mechanisms for a path, a function, positions: the topology that drew a path is found again and named."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import mbproj
from mbproj.base.errors import InputError
from mbproj.studies.design.folder import best_scene
from mbproj.studies.synthesis.candidates import brought_down, candidates, names_for
from mbproj.studies.synthesis.linkage import FUNCTION, PATH, POSITIONS, TOPOLOGIES, SpatialFourBar, meeting_point
from mbproj.studies.synthesis.spec import read_wanted
from mbproj.studies.synthesis.synthesise import FRAMES, Synthesis, Synthesised, doubt, in_order, page_data, synthesise
from tests.cli.commands import mbproj as command

TRUE = {
    "ax": 0.1,
    "az": -0.2,
    "dx": 0.8,
    "dz": 0.1,
    "crank_length": 0.25,
    "coupler_length": 0.7,
    "rocker_length": 0.6,
    "px": 0.3,
    "pz": 0.2,
    "side": 1.0,
}
FOUR_BAR = TOPOLOGIES["four_bar"][PATH]


def arrays(numbers):
    return {name: np.array([[value]]) for name, value in numbers.items()}


def written(folder, wanted, headings, columns, more="starts: 40\n"):
    rows = "\n".join(",".join(map(repr, row)) for row in np.stack(columns, axis=1).tolist())
    (folder / "wanted.csv").write_text(f"{headings}\n{rows}\n", encoding="utf-8")
    path = folder / "wish.yaml"
    path.write_text(f"design: 1\nsynthesis: {{{wanted}: wanted.csv}}\n{more}", encoding="utf-8")
    return path


def coupler_curve(count):
    times = np.arange(count) / count
    return times, FOUR_BAR.solved(arrays(TRUE), 0.4 + 2.0 * np.pi * times)["P"][0]


def test_the_four_bar_that_drew_a_path_is_found_and_named(tmp_path):
    """A slider-crank comes near to the path at best. The winner runs alone, too."""
    times, points = coupler_curve(16)
    path = written(tmp_path, "path", "time (s),x (m),z (m)", [times, points.real, points.imag])
    wanted = read_wanted(path)
    assert candidates(wanted, "slider_crank")[0]["rms"] > 1e-4
    best = synthesise(wanted, ["four_bar"], tmp_path / "out", 1).topologies[0]
    assert (best.topology, best.bodies) == ("four_bar", 3)
    assert best.rms < 1e-9
    with mbproj.run(mbproj.read_scene(tmp_path / "out" / "four_bar.yaml")) as results:
        tip = results.marker("P").position
    np.testing.assert_allclose(tip[:16, 0] + 1j * tip[:16, 2], points, rtol=0.0, atol=1e-9)


def test_a_function_is_generated(tmp_path):
    """The rocker of a four-bar over its crank; the command names the topology and writes a page."""
    crank = np.linspace(0.0, 1.0, 11)
    numbers = arrays({**TRUE, "ax": 0.0, "az": 0.0, "dx": 1.0, "dz": 0.0})
    known = FOUR_BAR.solved(numbers, 0.4 + crank)
    rocker = np.degrees(np.angle(known["C"] - known["D"])[0])
    path = written(tmp_path, "function", "input (rad),output (deg)", [crank, rocker], "starts: 8\n")
    done = command("optimise", path.name, "--topologies", "four_bar", "--json", "--jobs", "1", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    said = json.loads(done.stdout)
    assert said["best"] == "four_bar"
    assert said["topologies"][0]["rms"] < 1e-9
    page = (tmp_path / "wish-topologies" / "designs.html").read_text(encoding="utf-8")
    assert "four_bar: off by" in page
    with (tmp_path / "wish-topologies" / "topologies.csv").open(encoding="utf-8") as table:
        assert [row["topology"] for row in csv.DictReader(table)] == ["four_bar"]


def test_three_positions_put_the_pivots_of_the_body_on_circles(tmp_path):
    """Burmester: each pivot of the coupler is at one distance from its pivot in the ground at all three positions."""
    positions = np.array([[0.0, 0.0, 0.0], [0.5, 0.2, 0.3], [1.0, 0.1, 0.8]])
    path = written(tmp_path, "positions", "x (m),z (m),angle (rad)", positions.T, "starts: 8\n")
    found = synthesise(read_wanted(path), ["four_bar"], tmp_path / "out", 1).topologies[0]
    assert found.rms < 1e-12
    own, body = found.numbers, np.exp(1j * positions[:, 2])
    # In the body's axes the coupler leans back; P is where its positions are measured.
    along = np.exp(-1j * own["lean"])
    first = -along * (own["px"] + 1j * own["pz"])
    moving = {"A": first, "D": first + along * own["coupler_length"]}
    ground = {"A": own["ax"] + 1j * own["az"], "D": own["dx"] + 1j * own["dz"]}
    for pivot, length in (("A", "crank_length"), ("D", "rocker_length")):
        places = positions[:, 0] + 1j * positions[:, 1] + body * moving[pivot]
        np.testing.assert_allclose(np.abs(places - ground[pivot]), own[length], rtol=1e-11)


@pytest.mark.full
def test_a_body_is_carried_by_a_slider_crank(tmp_path):
    positions = np.array([[0.0, 0.0, 0.0], [0.3, 0.2, 0.3], [0.6, 0.25, 0.7]])
    path = written(tmp_path, "positions", "x (m),z (m),angle (rad)", positions.T, "starts: 4\n")
    (best,) = synthesise(read_wanted(path), ["slider_crank"], tmp_path / "out", 1).topologies
    assert best.rms < 1e-12
    with mbproj.run(mbproj.read_scene_text(best_scene(best.design), "best")) as results:
        place = results.marker("P").position
    np.testing.assert_allclose(place[:, [0, 2]], positions[:, :2], rtol=0.0, atol=1e-10)


@pytest.mark.full
@pytest.mark.parametrize("timing", ["given", "free"])
def test_a_look_finds_a_path_again_whatever_its_timing(timing, tmp_path):
    times, points = coupler_curve(12)
    more = f"starts: {20 if timing == 'free' else 40}\n"
    path = written(tmp_path, "path", "time (s),x (m),z (m)", [times, points.real, points.imag], more)
    path.write_text(path.read_text().replace("wanted.csv}", f"wanted.csv, timing: {timing}}}"), encoding="utf-8")
    best = candidates(read_wanted(path), "four_bar")[0]
    assert best["rms"] < (1e-9 if timing == "given" else 1e-12)


def test_six_bars_come_nearer_to_a_function_than_a_four_bar(tmp_path):
    x = np.linspace(0.0, 1.0, 12)
    path = written(tmp_path, "function", "input (rad),output (rad)", [x, x**1.5], "starts: 6\n")
    wanted = read_wanted(path)
    off = {name: candidates(wanted, name)[0]["rms"] for name in names_for(FUNCTION)}
    assert 0.0 < max(off["watt"], off["stephenson"]) < off["four_bar"] < 1e-2
    assert off["spatial_four_bar"] < 1e-2


def test_dyads_and_the_spatial_rod_keep_their_lengths():
    rng = np.random.default_rng(2)
    one = rng.normal(size=5) + 1j * rng.normal(size=5)
    two = one + 1.0 + 0.3j
    end = meeting_point(one, two, np.array(0.9), np.array(0.8), np.array(1.0))
    np.testing.assert_allclose([np.abs(end - one), np.abs(end - two)], [[0.9] * 5, [0.8] * 5], rtol=1e-13)
    lengths = {"crank_length": 0.3, "rod_length": 1.3, "lever_length": 0.9}
    p = arrays({**lengths, "dy": 0.4, "dz": 0.1, "twist": 0.7, "side": 1.0})
    θ = np.linspace(0.0, 1.0, 7)
    ψ = SpatialFourBar().angle(p, θ)[0]
    crank = 0.3 * np.stack([np.cos(θ), 0.0 * θ, np.sin(θ)])
    lever = np.array([[1.0], [0.4], [0.1]]) + 0.9 * np.stack(
        [np.cos(ψ), np.sin(ψ) * np.sin(0.7), np.sin(ψ) * np.cos(0.7)]
    )
    np.testing.assert_allclose(np.linalg.norm(lever - crank, axis=0), 1.3, rtol=1e-13)


@pytest.mark.parametrize(
    ("wanted", "headings", "rows", "said"),
    [
        ("path", "x (m),y (m)", [[0, 0], [1, 0], [2, 1]], "there is no column 'z'"),
        ("path", "x (kg),z (m)", [[0, 0], [1, 0], [2, 1]], "column 'x' is in m, and 'kg' is not"),
        ("function", "input (deg),output (deg)", [[0, 0], [2, 1], [1, 3]], "its inputs do not grow from row to row"),
        ("positions", "x,z,angle", [[k, 0, k] for k in range(6)], "mechanisms are sought for 5 at most"),
        ("path", "x,z", [[0, 0], [1, 1]], "it has 2 rows, and a path needs 3"),
    ],
)
def test_what_is_wrong_is_told_before_anything_is_sought(wanted, headings, rows, said, tmp_path):
    path = written(tmp_path, wanted, headings, np.array(rows, dtype=float).T)
    with pytest.raises(InputError, match=said):
        read_wanted(path)


def test_a_synthesis_without_topologies_names_the_option(tmp_path):
    path = written(tmp_path, "path", "x,z", np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]).T)
    done = command("fit", path.name, folder=tmp_path)
    assert done.returncode == 2
    assert "mbproj optimise wish.yaml --topologies all" in done.stderr


def test_a_topology_that_cannot_do_it_is_an_error(tmp_path):
    path = written(tmp_path, "path", "x,z", np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]).T)
    with pytest.raises(InputError, match="no topology for path is called 'spatial_four_bar'"):
        synthesise(read_wanted(path), ["spatial_four_bar"], tmp_path / "out", 1)


def test_the_simplest_of_those_that_are_as_good_is_chosen(tmp_path):
    """A six-bar draws what a four-bar draws; one that is better by more than a half comes first."""
    off = {"watt": (5, 1e-13), "four_bar": (3, 1e-12), "slider_crank": (3, 1e-3)}
    found = [Synthesised(name, bodies, object(), rms, {}) for name, (bodies, rms) in off.items()]
    assert [each.topology for each in in_order(found, 1.0)] == ["four_bar", "watt", "slider_crank"]
    better = [Synthesised("watt", 5, object(), 1e-4, {}), Synthesised("four_bar", 3, object(), 1e-3, {})]
    assert [each.topology for each in in_order(better, 1.0)] == ["watt", "four_bar"]


@pytest.mark.full
def test_a_six_bar_closes_all_the_way_from_one_position_to_the_next(tmp_path):
    """The first exact design for these five places locks between two of them."""
    x, z, angle = [0.0, 0.5, 1.0, 1.3, 1.5], [0.0, 0.2, 0.1, -0.2, -0.5], [0.0, 17.0, 46.0, 60.0, 80.0]
    path = written(tmp_path, "positions", "x (m),z (m),angle (deg)", np.array([x, z, angle]))
    best = candidates(read_wanted(path), "stephenson")[0]
    assert best["rms"] < 1e-12
    swings = [0.0, *(best[f"swing_{k}"] for k in range(2, 6))]
    crank = best["start"] + np.polyval(np.polyfit(range(5), swings, 4), np.linspace(0.0, 4.0, 500))
    way = TOPOLOGIES["stephenson"][POSITIONS].solved(arrays(best), crank)["P"][0]
    assert np.isfinite(way).all()
    np.testing.assert_allclose(way[[0, -1]], [0.0, 1.5 - 0.5j], atol=1e-9)


def test_the_page_shows_the_body_at_its_positions(tmp_path):
    """A crank that goes by a polynomial in time passes them at equal distances of frames."""
    columns = np.array([[0.0, 0.5, 1.0, 1.3], [0.0, 0.2, 0.1, -0.2], [0.0, 17.0, 46.0, 60.0]])
    wanted = read_wanted(written(tmp_path, "positions", "x (m),z (m),angle (deg)", columns))
    best = candidates(wanted, "four_bar")[0]
    page = page_data(Synthesis(wanted, (Synthesised("four_bar", 3, object(), 0.0, best),)))
    np.testing.assert_allclose(page["marks"], page["designs"][0]["carried"][:: (FRAMES - 1) // 3], atol=3e-6)
    turned = np.diff(page["marks"], axis=1)[:, 0]
    np.testing.assert_allclose(np.degrees(np.arctan2(turned[:, 1], turned[:, 0])), columns[2], atol=1e-3)


def test_six_bars_that_carry_a_body_are_in_doubt(tmp_path):
    """Unless they are exact: the table and its JSON say so."""
    columns = [np.array([0.0, 0.3, 0.5]), np.array([0.0, 0.1, 0.4]), np.array([0.0, 0.2, 0.6])]
    wanted = read_wanted(written(tmp_path, "positions", "x (m),z (m),angle (rad)", columns))
    assert "not reliable" in doubt(wanted, "watt", 1e-4)
    assert doubt(wanted, "watt", 1e-14) == doubt(wanted, "four_bar", 1e-4) == ""


def test_slopes_that_depend_on_each_other_end_no_search():
    """(x + y)⁴ has a line of minima: JᵀJ is singular everywhere, and each step is a success that lowers the damping."""

    def residuals(x):
        return np.sum(x, axis=1, keepdims=True) ** 4

    x, cost = brought_down(residuals, np.array([[0.5, 0.25], [0.75, 0.5]]), -np.ones(2), np.ones(2))
    assert np.all(np.abs(np.sum(x, axis=1)) < 1e-6) and np.all(cost < 1e-40)
