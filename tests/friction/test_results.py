"""What results say of dry friction, of a block that sticks and slips on a belt: held against the closed form."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from mbproj import InputError
from mbproj.analysis import friction_records, sticking
from mbproj.figures import draw
from mbproj.results import open_results
from tests.cli.commands import mbproj
from tests.friction.scenes import AGAIN, BELT, HOLDS, SLID, SLIDES, SLIPS, STICKS

#: Two slides and a bit of the third sticking.
END = 3.5
HELD = SLIPS - STICKS + END - AGAIN
LOST = SLIDES * sum(SLID)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("belt")
    (path / "belt.yaml").write_text(BELT)
    done = mbproj("run", "belt.yaml", "--json", folder=path)
    assert done.returncode == 0, done.stderr
    (path / "said.json").write_text(done.stdout)
    return path


@pytest.fixture
def results(folder):
    with open_results(folder / "results.h5") as opened:
        yield opened


def test_a_friction_by_name(results):
    assert results.names("frictions") == ("grip",) and results.names("friction_units") == ("m",)
    grip = results.friction("grip")
    slides = results.time < STICKS
    np.testing.assert_allclose(grip.force[slides], SLIDES, rtol=1e-15)
    assert set(grip.state[slides]) == {-1.0} and grip.rate[0] == pytest.approx(-0.2)
    assert grip.dissipation[-1] == pytest.approx(LOST, rel=1e-9)
    with pytest.raises(InputError, match=r"no dry friction 'grib'.*did you mean 'grip'"):
        results.friction("grib")


def test_when_it_sticks(results):
    """Between samples as the events say, and no longer than what is selected."""
    np.testing.assert_allclose(sticking(results, "grip"), [(STICKS, SLIPS), (AGAIN, END)], rtol=1e-9)
    part = results.select(start=1.0, stop=3.0)
    np.testing.assert_allclose(sticking(part, "grip"), [(1.0, SLIPS), (AGAIN, 3.0)], rtol=1e-9)
    (seen,) = friction_records(part).values()
    assert (seen["sticks"], seen["slips"]) == (1, 1)
    assert seen["energy"] == pytest.approx(SLIDES * SLID[1], rel=1e-9)


def test_summaries_count(folder):
    counted = [json.loads((folder / "said.json").read_text())["frictions"]]
    counted += [json.loads(mbproj("info", "results.h5", "--json", folder=folder).stdout)["frictions"]]
    for found in counted:
        grip = found["grip"]
        assert [grip[name] for name in ("unit", "sticks", "slips", "turns")] == ["m", 2, 1, 0]
        assert grip["sticking_seconds"] == pytest.approx(HELD, rel=1e-9)
        assert grip["sticking_part"] == pytest.approx(HELD / END, rel=1e-9)
        assert grip["energy"] == pytest.approx(LOST, rel=1e-9)
        assert HOLDS - 0.2 * 10 * 0.02 < grip["largest_force"] < HOLDS  # the spring's in the last sample before
    said = mbproj("info", "results.h5", folder=folder).stdout
    assert f"grip  began to stick 2 times, slipped once, stuck for {HELD:.4g} s ({100 * HELD / END:.3g} %)" in said
    assert f"t = {SLIPS:.9g} s: friction 'grip', slip, falling" in said


def test_expectations_of_friction(folder):
    found = json.loads((folder / "said.json").read_text())["expectations"]
    assert [(each["name"], each["holds"]) for each in found] == [("slides", True), ("rests", True), ("rubs", True)]


def test_a_table_of_friction(folder):
    done = mbproj("export", "results.h5", "--table", "friction-grip", folder=folder)
    assert done.stdout.split() == ["results-friction-grip.csv"]
    with (folder / "results-friction-grip.csv").open() as file:
        heading, *rows = csv.reader(file)
    assert heading == ["time (s)", "rate (m/s)", "force (N)", "state (1)", "dissipation (J)"]
    t, rate, force, state, lost = np.array(rows, dtype=float).T
    held = ((t > STICKS) & (t < SLIPS)) | (t > AGAIN)
    assert set(state[held]) == {0.0} and set(state[~held]) == {-1.0}
    np.testing.assert_allclose(rate[held], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.diff(force[held & (t < SLIPS)]), 10.0 * 0.2 * 0.02, rtol=1e-6)
    assert (np.diff(lost) >= 0.0).all()


def test_the_picture_shades_what_sticks(results):
    figure = draw("friction", [results], ["belt"])
    rate, force, energy, power = (axis for axis in figure.axes if axis.get_visible())
    labels = [axis.get_ylabel() for axis in (rate, force, energy, power)]
    said = "grip: rate (m/s), force (N), energy lost (J), power lost (W)"
    assert ", ".join(label.replace("\n", " ") for label in labels) == said
    for axis in (rate, force, energy, power):
        (shade,) = axis.collections
        spans = [(path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in shade.get_paths()]
        np.testing.assert_allclose(spans, [(STICKS, SLIPS), (AGAIN, END)], rtol=1e-9)
    sliding = results["friction/rate"][:, 0] * -results["friction/force"][:, 0]
    np.testing.assert_allclose(power.lines[0].get_ydata(), sliding, atol=1e-12)
    assert any("shaded: it sticks" in text.get_text() for text in figure.texts)
