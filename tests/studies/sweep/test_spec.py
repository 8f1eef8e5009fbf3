"""A sweep's file and its table: what is read, and what is said of wrong ones."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.results.sweep_table import read_table
from mbproj.studies.sweep.folder import Folder
from mbproj.studies.sweep.run import run_sweep
from mbproj.studies.sweep.spec import read_spec
from mbproj.studies.sweep.summary import write_summary
from tests.crossed import some
from tests.studies.sweep.specs import MEASURE, complaints, write

pytestmark = pytest.mark.usefixtures("sweeps_here")


# A sweep's file: what it makes, and what is said of a wrong one, at its place.


def test_units_come_from_the_scene_and_else_from_the_sweep(tmp_path):
    vary = (
        "  length: 0.8 m:1.2 m:3\n  bodies.bar.mass: [1, 2]\n  simulation.projection: [gopm, gpopm]\n  fails: [0 s]\n"
    )
    spec = read_spec(write(tmp_path, vary))
    assert dict(spec.units) == {"length": "m", "bodies.bar.mass": "kg", "simulation.projection": "", "fails": "s"}
    assert spec.design.count == 12
    assert spec.measures[0].unit == "m"


@pytest.mark.parametrize(
    ("vary", "measure", "more", "lines"),
    [
        ("  lenght: [1]\n", MEASURE, "", ["4:3: error: unknown parameter 'lenght'; did you mean 'length'?"]),
        (
            "  bodies.baar.mass: [1]\n",
            MEASURE,
            "",
            ["4:3: error: the scene has no 'bodies.baar'; did you mean 'bar'?"],
        ),
        ("  bodies.bar.mas: [1]\n", MEASURE, "", ["4:3: error: unknown key 'mas'; did you mean 'mass'?"]),
        (
            "  bodies.bar.mass: [1, 2 m, 3, -1]\n  length: -1:1:3\n",
            MEASURE,
            "",
            [
                "4:24: error: 'mass' is in kg, this is a length, in m",
                "4:32: error: 'mass' must be at least 0, found -1",
            ],
        ),
        (
            "  simulation.projection: [gopm, gpomp]\n",
            MEASURE,
            "",
            ["4:33: error: unknown projection method 'gpomp'; did you mean 'gpopm'?"],
        ),
        (
            "  length: [1, 2]\n  fails: [0, 1, 0]\n",
            MEASURE,
            "combine: zip\n",
            ["4:3: error: 'length' has 2 values, and 'fails' has 3; zip takes ranges of one length"],
        ),
        (
            "  length: {uniform: [1, 2]}\n",
            MEASURE,
            "",
            [
                "4:3: error: 'grid' cannot take a distribution; combine: lhs, sobol, saltelli, montecarlo, or list its "
                "values"
            ],
        ),
        (
            "  length: {uniform: [1, 2]}\n",
            MEASURE,
            "combine: sobol\nsamples: 20\n",
            ["8:10: error: 'sobol' needs a power of 2 of samples, found 20; take 16 or 32"],
        ),
        (
            "  length: {uniform: [1, 2]}\n",
            MEASURE,
            "combine: lhs\n",
            ["7:10: error: 'lhs' needs 'samples'; add it: how many, a whole number"],
        ),
        (
            "  length: [1]\n",
            MEASURE,
            "seed: 1\n",
            ["7:7: error: 'grid' takes no 'seed'; leave it out, or combine: lhs, sobol, saltelli, montecarlo"],
        ),
        (
            "  length: [1]\n",
            "",
            "",
            ["5:9: error: 'measure' is empty; say what to measure, as in  tip: {marker: tip, quantity: position, ..}"],
        ),
        (
            "  length: [1]\n",
            "  x: {marker: ned, quantity: position, at: end, component: z}\n",
            "",
            ["6:15: error: unknown marker 'ned'; choose from: end"],
        ),
        (
            "  length: [1]\n",
            "  x: {marker: end, quantity: position, at: end}\n",
            "",
            ["6:30: error: 'position' has 3 components, and this is about one number; add component: x, y, z or norm"],
        ),
        (
            "  length: [1]\n",
            "  x: {marker: end, quantity: position, at: 0.105, component: z}\n",
            "",
            [
                "6:44: error: there is no sample at 0.105 s; the nearest are at 0.1 s and 0.11 s; choose one of "
                "them, or another 'output_step'"
            ],
        ),
        (
            "  length: [1]\n",
            "  length: {joint: pin, quantity: angle, at: end}\n",
            "",
            ["6:3: error: 'length' is another column of the summary; give the measure another name"],
        ),
        ("  length: [1]\n", MEASURE, "keeep: all\n", ["7:1: error: unknown key 'keeep'; did you mean 'keep'?"]),
    ],
)
def test_what_is_wrong_is_said_at_its_place(tmp_path, vary, measure, more, lines):
    assert complaints(write(tmp_path, vary, measure, more)) == lines


def test_a_scene_that_is_not_there_is_said_at_the_key_that_names_it(tmp_path):
    path = write(tmp_path, "  length: [1]\n")
    path.write_text(path.read_text().replace("pendulum.yaml", "pendulun.yaml"))
    (line,) = complaints(path)
    scene = tmp_path / "pendulun.yaml"
    assert line == f"2:8: error: scene '{scene}': there is no such file; did you mean 'pendulum.yaml'?"


def test_nothing_to_measure_is_a_missing_key(tmp_path):
    path = write(tmp_path, "  length: [1]\n", "")
    path.write_text(path.read_text().replace("measure:\n", ""))
    with pytest.raises(InputError, match=r"error: missing key 'measure'"):
        read_spec(path)


# The summary of a sweep is read as it was written; what is not one is said.


def summarised(tmp_path, vary, more=""):
    spec = read_spec(write(tmp_path, vary, more=more))
    folder = Folder(tmp_path / "made-sweep", spec, fresh=False)
    with folder.store:
        run_sweep(spec, folder, 1)
        write_summary(spec, folder)
    return tmp_path / "made-sweep"


def test_a_grid_comes_back_as_rows(tmp_path):
    found = read_table(
        summarised(tmp_path, "  length: [1, 2]\n  fails: [0, 1]\n  simulation.projection: [gopm, mmopm]\n")
    )
    assert (found.name, found.combine, found.shape) == ("made-sweep", "grid", (2, 2, 2))
    length, fails, method = found.varied
    assert (length.name, length.unit, length.values.tolist()) == ("length", "m", [1.0] * 4 + [2.0] * 4)
    assert fails.values.tolist() == [0.0, 0.0, 1.0, 1.0] * 2
    assert (method.is_number, method.values.tolist()) == (False, ["gopm", "mmopm"] * 4)
    assert found.failed.tolist() == [False, False, True, True] * 2
    (drop,) = found.measured
    assert np.isnan(drop.values).tolist() == found.failed.tolist()
    assert (drop.name, drop.unit) == ("drop", "m")


def test_samples_come_back_with_what_the_design_was_asked_for(tmp_path):
    more = "combine: saltelli\nsamples: 2\n"
    found = read_table(
        summarised(tmp_path, "  length: {uniform: [1, 2]}\n  bodies.bar.mass: {uniform: [1, 2]}\n", more)
    )
    assert (found.combine, found.samples, found.shape) == ("saltelli", 2, (8,))
    assert found.varied[0].values[:2].tolist() == found.varied[0].values[6:].tolist()


def test_what_is_no_summary(tmp_path):
    with pytest.raises(InputError, match=r"is not the folder of a sweep: it has no 'summary.h5'"):
        read_table(tmp_path)
    made = summarised(tmp_path / "there", "  length: [1, 2]\n")
    with h5py.File(made / "summary.h5", "r+") as file:
        del file["drop"]
        file["drop"] = np.zeros(3)
    with pytest.raises(InputError, match=r"'drop' has no checksum; write it again with: mbproj sweep"):
        read_table(made)
    with h5py.File(made / "summary.h5", "r+") as file:
        file.attrs["format"] = "another"
        del file.attrs["crc32_of_attributes"]
    with pytest.raises(InputError, match=r"is not the summary of a sweep"):
        read_table(made / "summary.h5")


def same_table(one, other):
    columns = [(each.name, each.unit, each.values.tolist()) for each in (*one.varied, *one.measured)]
    others = [(each.name, each.unit, each.values.tolist()) for each in (*other.varied, *other.measured)]
    facts = [(each.name, each.combine, each.samples, each.shape, each.status.tolist()) for each in (one, other)]
    return facts[0] == facts[1] and repr(columns) == repr(others)


@pytest.mark.parametrize("seed", some(range(4), 4))
def test_no_flipped_bit_changes_a_number_or_a_unit(tmp_path, seed):
    """20 summaries with one bit flipped each, half of them in the numbers."""
    file = summarised(tmp_path, "  length: [1, 2, 3]\n  simulation.projection: [gopm, mmopm]\n") / "summary.h5"
    whole, data, random = read_table(file), file.read_bytes(), np.random.default_rng(seed)
    with h5py.File(file) as opened:
        numbers = opened["drop"].id.get_offset()
    used = np.flatnonzero(np.frombuffer(data, np.uint8))
    places = [*(8 * numbers + random.integers(0, 8 * 6 * 8, 10)), *(8 * random.choice(used, 10) + 3)]
    refused = 0
    for place in places:
        changed = bytearray(data)
        changed[place // 8] ^= 1 << place % 8
        file.write_bytes(changed)
        try:
            assert same_table(read_table(file), whole)
        except InputError:
            refused += 1
    assert refused >= 13


def test_a_summary_without_checksums_is_read(tmp_path):
    made = summarised(tmp_path, "  length: [1, 2, 3]\n  simulation.projection: [gopm, mmopm]\n")
    whole = read_table(made)
    with h5py.File(made / "summary.h5", "r+") as file:
        for place in (file, *file.values()):
            for name in [name for name in place.attrs if name.startswith("crc32")]:
                del place.attrs[name]
    with pytest.raises(InputError, match="has no checksum"):
        read_table(made)
    with h5py.File(made / "summary.h5", "r+") as file:
        file.attrs["schema_version"] = 1
    assert same_table(read_table(made), whole)


def test_texts_with_ends_of_lines_come_back_as_the_table_has_them(tmp_path):
    found = read_table(summarised(tmp_path, '  title: ["two\\nlines", "one\\u2028more", plain]\n'))
    (title,) = found.varied
    assert title.values.tolist() == ["two\\u000alines", "one\\u2028more", "plain"]
