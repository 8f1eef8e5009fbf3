"""Sweeps and their store: the numbers of single runs to the last bit, and nothing computed twice."""

from __future__ import annotations

import sqlite3
import warnings
from contextlib import closing

import numpy as np
import pytest

from mbproj.base.errors import InputError, MbprojWarning
from mbproj.results.analysis.expectations import measured
from mbproj.results.reader import open_results
from mbproj.studies.store import encoded, opened_alone, put
from mbproj.studies.sweep.run import CaseTask, CaseWork, run_case
from mbproj.studies.sweep.spec import read_spec
from mbproj.studies.sweep.store import CaseRow, Status, Store
from tests.cli.commands import succeeds
from tests.crossed import once, some
from tests.studies.sweep.specs import MEASURE, swept, write

pytestmark = pytest.mark.usefixtures("sweeps_here")


# Sweeps: the numbers of single runs, to the last bit; nothing is computed twice; what fails is a row.

#: Measures at the end, over all samples, of several kinds.
MEASURES = """\
  drop: {marker: end, quantity: position, component: z, at: end}
  load: {joint: pin, quantity: reaction_force, component: norm, at: maximum}
  angle: {joint: pin, quantity: angle, at: 0.1}
  speed: {body: bar, quantity: angular_velocity, component: y, at: largest}
  drift: {diagnostic: energy_drift_relative, at: end}
  cost: {diagnostic: evaluations, at: end}
"""


def work_of(spec, **changes):
    given = {"timeout": None, "keep": "none", "folder": None, **changes}
    return CaseWork(spec.scene, spec.design.paths, spec.measures, **given)


@pytest.mark.parametrize(
    ("measures", "more"),
    once(
        [MEASURES, MEASURE],
        ["", "  simulation.tolerance: 1e-9\n  simulation.integrator: dop853\n", "  simulation.formulation: full\n"],
    ),
)
def test_a_case_has_the_numbers_of_a_run_with_set(tmp_path, measures, more):
    """Read again from YAML, with all samples recorded in a file."""
    vary = f"  length: 0.8:1.2:3\n  bodies.bar.mass: [1, 2.5 kg]\n  bodies.bar.inertia: [[0.1, 0.2, 0.15]]\n{more}"
    spec = read_spec(write(tmp_path, vary, measures))
    changes = [f"{path}={value}" for path, value in zip(spec.design.paths, spec.design.case(3), strict=True)]
    sets = [word for change in changes for word in ("--set", change)]
    succeeds("run", "pendulum.yaml", *sets, "-q", folder=tmp_path)
    with open_results(tmp_path / "results.h5") as results:
        found = [measured(each, results, 0.2) for each in spec.measures]
    row = run_case(work_of(spec), CaseTask("key", spec.design.case(3)))
    assert row.status == Status.DONE
    assert row.values == tuple(float(each.values[0]) for each in found)


def test_started_again_it_computes_what_is_missing(tmp_path):
    path, output = write(tmp_path, "  length: 0.8:1.2:5\n", MEASURES), tmp_path / "out"
    first, entries = swept(path, output)
    again, same = swept(path, output)
    assert (first.computed, first.reused, again.computed, again.reused) == (5, 0, 0, 5)
    assert entries == same
    more, _ = swept(write(tmp_path, "  length: 0.8:1.2:9\n", MEASURES), output)
    assert (more.computed, more.reused) == (4, 5)
    fewer, _ = swept(write(tmp_path, "  length: [1.0, 0.9, 7]\n"), output)  # another order, fewer measures
    assert (fewer.computed, fewer.reused) == (1, 2)
    other, _ = swept(write(tmp_path, "  length: [7]\n", MEASURES), output)  # a measure that was not taken
    assert (other.computed, other.reused) == (1, 0)
    anew, _ = swept(write(tmp_path, "  length: 0.8:1.2:5\n", MEASURES), output, fresh=True)
    assert (anew.computed, anew.reused) == (5, 0)


def test_numbers_in_a_file_of_the_scene_are_part_of_a_case(tmp_path):
    """Of a gain in a file: another gain is another mechanism, though the scene's text is the same."""
    path = write(tmp_path, "  length: [1]\n")
    scene = tmp_path / "pendulum.yaml"
    drive = "forces:\n  drive: {type: torsion_spring_damper, joint: pin, torque: -u}\n"
    signals = "signals:\n  u: {gain: {of: [pin.angle_dot], file: gain.csv}, unit: N*m}\n"
    scene.write_text(scene.read_text().replace("forces:\n", drive) + signals)
    (tmp_path / "gain.csv").write_text("0.5\n")
    _, (soft,) = swept(path, tmp_path / "out")
    assert swept(path, tmp_path / "out")[0].reused == 1
    (tmp_path / "gain.csv").write_text("5\n")
    again, (stiff,) = swept(path, tmp_path / "out")
    assert (again.computed, again.reused) == (1, 0)
    assert soft.row.values != stiff.row.values


def test_a_case_that_fails_is_a_row_with_its_time_and_keeps_its_results(tmp_path):
    path = write(tmp_path, "  fails: [0, 1]\n  length: [1, -1]\n  bodies.bar.mass: [1]\n", more="keep: failed\n")
    reached, entries = swept(path, tmp_path / "out")
    assert [entry.status for entry in entries] == ["done", "done", "failed", "failed"]
    assert (reached.computed, reached.failed) == (4, 2)
    row = entries[2].row
    assert "square root" in row.message or "sqrt" in row.message
    assert row.time == pytest.approx(0.1, abs=0.02)
    with open_results(tmp_path / "out" / entries[2].file) as results:
        assert results.status.startswith("failed")
        assert results.overrides == {"fails": "1.0", "length": "1.0", "bodies.bar.mass": "1.0"}
    again, _ = swept(path, tmp_path / "out")
    assert (again.computed, again.reused, again.failed) == (0, 4, 2)
    (tmp_path / "out" / entries[3].file).unlink()
    assert swept(path, tmp_path / "out")[0].computed == 1


def test_too_many_failures_end_it(tmp_path):
    path = write(tmp_path, "  fails: [1]\n  length: 1:2:40\n")
    reached, entries = swept(path, tmp_path / "out", most_failures=0)
    assert 1 <= reached.failed < 40
    assert sum(entry.status == "not run" for entry in entries) == reached.left


def test_as_many_failures_as_are_allowed_do_not_end_it(tmp_path):
    path = write(tmp_path, "  fails: [1, 0]\n  length: 1:2:20\n")
    reached, _ = swept(path, tmp_path / "out", most_failures=20)
    assert (reached.computed, reached.failed, reached.left) == (40, 20, 0)


@pytest.mark.parametrize("formulation", ["auto", "full"])
def test_a_case_stops_when_its_time_is_up(tmp_path, formulation):
    """Between two steps, though it records no sample for hours."""
    slow = "  fails: -1e8\n  simulation.duration: 1e7\n  simulation.step: 1e-5\n  simulation.output_step: 1e6\n"
    spec = read_spec(write(tmp_path, f"{slow}  simulation.formulation: {formulation}\n"))
    row = run_case(work_of(spec, timeout=0.3), CaseTask("key", spec.design.case(0)))
    assert (row.status, row.message) == (Status.TIMEOUT, "stopped: it took longer than 0.3 s")
    assert row.seconds < 3.0


def test_all_results_may_be_kept_and_repeated_and_gone_on_with(tmp_path):
    path = write(tmp_path, "  bodies.bar.mass: [2]\n", more="keep: all\n")
    _, (entry,) = swept(path, tmp_path / "out")
    succeeds("rerun", f"out/{entry.file}", "-o", "again.h5", "-q", folder=tmp_path)
    with open_results(tmp_path / "again.h5") as results:
        assert results.marker("end").position[-1, 2] == entry.row.values[0]
    succeeds("continue", f"out/{entry.file}", "--until", "0.3", "-o", "on.h5", "-q", folder=tmp_path)
    with open_results(tmp_path / "on.h5") as results:
        assert results.time[-1] == pytest.approx(0.3)


def test_the_folder_of_another_sweep_is_left_alone(tmp_path):
    path = write(tmp_path, "  length: [1]\n")
    swept(path, tmp_path / "out")
    other = tmp_path / "other.yaml"
    (tmp_path / "pendulum.yaml").rename(tmp_path / "swing.yaml")
    other.write_text(path.read_text().replace("pendulum.yaml", "swing.yaml"))
    with pytest.raises(
        InputError, match=r"holds a sweep of 'pendulum.yaml', not of 'swing.yaml'; choose another folder"
    ):
        swept(other, tmp_path / "out")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("")
    with pytest.raises(InputError, match=r"is not the folder of a sweep: it holds 'thesis.tex'"):
        swept(other, tmp_path / "mine")
    (tmp_path / "foreign").mkdir()
    with sqlite3.connect(tmp_path / "foreign" / "store.sqlite") as database:
        database.execute("CREATE TABLE mine (x)")
    with pytest.raises(InputError, match=r"is not the store of a sweep: it is that of another program"):
        swept(other, tmp_path / "foreign")


def test_two_sweeps_never_share_a_folder(tmp_path):
    from mbproj.studies.sweep.folder import Folder

    spec = read_spec(write(tmp_path, "  length: [1]\n"))
    with Folder(tmp_path / "out", spec, False).store, pytest.raises(InputError, match="another sweep is at work in"):
        Folder(tmp_path / "out", spec, False)


# The store of a sweep: whatever happens to its file, a row is as it was written, or it is missing and that is said.

ROWS = {
    f"{number:032x}": CaseRow(Status.DONE, (0.4936 + number, -0.0, float("nan")), seconds=-0.0)
    if number % 3
    else CaseRow(Status.FAILED, message="sqrt of a number below 0 \udcff", time=0.1 * number, joint="pin")
    for number in range(60)
}


def stored(path):
    with Store(path, ["a", "b", "c"]) as store:
        store.describe({"scene": "five_bar.yaml"})
        for key, row in ROWS.items():
            store.add(key, row)
        return dict(store.rows())


def read(path):
    """All rows, and what was said meanwhile."""
    with warnings.catch_warnings(record=True) as said, Store(path, ["a", "b", "c"]) as store:
        warnings.simplefilter("always")
        return dict(store.rows()), [str(each.message) for each in said if each.category is MbprojWarning]


def same(found, row):
    return repr(found) == repr(row)  # NaN is NaN


def test_rows_come_back(tmp_path):
    stored(tmp_path / "store.sqlite")
    found, said = read(tmp_path / "store.sqlite")
    assert (len(found), said) == (60, [])
    done = found[f"{1:032x}"]
    assert done.values[0] == 1.4936
    assert np.isnan(done.values[2])
    assert found[f"{3:032x}"].message == "sqrt of a number below 0 \\udcff"


@pytest.mark.parametrize("part", some(range(4), 4))
def test_no_flipped_bit_changes_a_row(tmp_path, part):
    """240 stores with one bit flipped each, anywhere, in four parts."""
    whole = stored(tmp_path / "store.sqlite")
    data = (tmp_path / "store.sqlite").read_bytes()
    random, lost = np.random.default_rng(35), 0
    for number, place in enumerate(random.integers(0, 8 * len(data), 240)[part::4]):
        changed = bytearray(data)
        changed[place // 8] ^= 1 << place % 8
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "store.sqlite").write_bytes(changed)
        try:
            found, said = read(folder / "store.sqlite")
        except InputError as error:
            assert place < 800, error  # SQLite's header, which says whose the file is
            continue
        assert all(same(row, whole[key]) for key, row in found.items())
        assert said or len(found) == 60
        lost += len(found) < 60
    assert lost > 10


@pytest.mark.parametrize("place", [b"CREATE TABLE kept", b"item TEXT"])
def test_a_message_of_sqlite_that_is_no_text_is_damage(tmp_path, place):
    """SQLite quotes the words of a table that it cannot read, whatever their bytes."""
    stored(tmp_path / "store.sqlite")
    data = bytearray((tmp_path / "store.sqlite").read_bytes())
    data[data.index(place) + 8] = 0xE3
    (tmp_path / "store.sqlite").write_bytes(data)
    found, said = read(tmp_path / "store.sqlite")
    assert said
    assert len(found) <= 60


@pytest.mark.parametrize("size", [3000, 8192, 20000])
def test_of_a_store_that_was_cut_short_the_rest_is_kept(tmp_path, size):
    stored(tmp_path / "store.sqlite")
    data = (tmp_path / "store.sqlite").read_bytes()
    (tmp_path / "store.sqlite").write_bytes(data[:size])
    found, said = read(tmp_path / "store.sqlite")
    assert len(found) < 60
    assert "is not as mbproj has written it (" in said[0]
    assert (tmp_path / "store.aside").read_bytes()[:100] == data[:100]


def test_a_damaged_row_is_computed_again_and_said(tmp_path):
    path, store = write(tmp_path, "  length: 0.8:1.2:5\n"), tmp_path / "out" / "store.sqlite"
    _, whole = swept(path, tmp_path / "out")
    with closing(sqlite3.connect(store)) as database, database:
        (value,) = database.execute("SELECT value FROM kept WHERE study = 'cases' LIMIT 1").fetchone()
        changed = value.replace(b": -0.", b": -9.")
        assert changed != value
        database.execute("UPDATE kept SET value = ? WHERE value = ?", [changed, value])
    with pytest.warns(MbprojWarning, match=r"\(1 of 6 rows are damaged\): 5 of its values are whole, and all"):
        reached, entries = swept(path, tmp_path / "out")
    assert (reached.computed, reached.reused) == (1, 4)
    assert [entry.row.values for entry in entries] == [entry.row.values for entry in whole]
    assert (tmp_path / "out" / "store.aside").exists()


def test_a_row_of_another_type_is_computed_anew(tmp_path):
    path = write(tmp_path, "  length: 0.8:1.2:5\n")
    _, whole = swept(path, tmp_path / "out")
    with closing(opened_alone(tmp_path / "out" / "store.sqlite")) as database:
        keys = [key for (key,) in database.execute("SELECT item FROM kept WHERE study = 'cases'")]
        for key, strange in zip(keys, ([1, 2], {"status": "done"}, [None, {}], "text"), strict=False):
            put(database, "cases", key, encoded(strange))
        put(database, "about", "", encoded([3]))
    reached, entries = swept(path, tmp_path / "out")
    assert (reached.computed, reached.reused) == (4, 1)
    assert [entry.row.values for entry in entries] == [entry.row.values for entry in whole]


def test_the_store_of_another_version_is_left_alone(tmp_path):
    stored(tmp_path / "store.sqlite")
    with closing(sqlite3.connect(tmp_path / "store.sqlite")) as database, database:
        database.execute("PRAGMA user_version = 1")
    before = (tmp_path / "store.sqlite").read_bytes()
    with pytest.raises(InputError, match=r"it is that of another program, or version; choose another folder with -o"):
        read(tmp_path / "store.sqlite")
    assert (tmp_path / "store.sqlite").read_bytes() == before


@pytest.mark.parametrize("name", ["store.sqlite", "store.sqlite-wal", "store.sqlite-journal"])
def test_nothing_is_written_through_a_link(tmp_path, name):
    (tmp_path / "mine").write_bytes(b"")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).symlink_to(tmp_path / "mine")
    with pytest.raises(InputError, match=f"'.*{name}' is a link, and a sweep keeps its rows in its own folder"):
        Store(tmp_path / "out" / "store.sqlite", ["a"])
    assert (tmp_path / "mine").read_bytes() == b""


def test_a_store_reaches_the_disk_when_it_is_closed(tmp_path):
    """A crash of the machine loses the last rows at most: SQLite, of which 0 would be OFF, waits for the disk."""
    with closing(opened_alone(tmp_path / "store.sqlite")) as database:
        assert database.execute("PRAGMA synchronous").fetchone()[0] >= 1
