"""The store of a sweep: whatever happens to its file, a row is as it was written, or it is missing and that is said."""

from __future__ import annotations

import shutil
import sqlite3
import warnings
from contextlib import closing

import numpy as np
import pytest

from mbproj.base.errors import InputError, MbprojWarning
from mbproj.studies.sweep.folder import Store
from mbproj.studies.sweep.store import CaseRow, Status, open_whole
from tests.crossed import some
from tests.studies.sweep.specs import swept, write

ROWS = {
    f"{number:032x}": CaseRow(Status.DONE, (0.4936 + number, -0.0, float("nan")), seconds=-0.0)
    if number % 3
    else CaseRow(Status.FAILED, message="sqrt of a number below 0 \udcff", time=0.1 * number, joint="pin")
    for number in range(60)
}
#: As the first format has it.
FORMAT_1 = """\
CREATE TABLE about (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE cases (key TEXT PRIMARY KEY, parameters TEXT NOT NULL, status TEXT NOT NULL, measures TEXT NOT NULL, \
message TEXT NOT NULL, time REAL, joint TEXT NOT NULL, formulation TEXT NOT NULL, seconds REAL NOT NULL, \
kept INTEGER NOT NULL) WITHOUT ROWID;
PRAGMA application_id = 1835168631;
PRAGMA user_version = 1;
"""


def stored(path):
    with Store(path, ["a", "b", "c"]) as store:
        store.describe({"scene": "five_bar.yaml"})
        for key, row in ROWS.items():
            store.add(key, {"length": 1.0}, row)
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


@pytest.mark.parametrize("place", [b"CREATE TABLE cases", b"formulation TEXT"])
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
    assert "is damaged: " in said[0]
    assert (tmp_path / "store.damaged").read_bytes()[:100] == data[:100]


def test_a_damaged_row_is_computed_again_and_said(tmp_path):
    path, store = write(tmp_path, "  length: 0.8:1.2:5\n"), tmp_path / "out" / "store.sqlite"
    _, whole = swept(path, tmp_path / "out")
    with closing(sqlite3.connect(store)) as database, database:
        (measures,) = database.execute("SELECT measures FROM cases LIMIT 1").fetchone()
        changed = measures.replace("-0.", "-9.")
        assert changed != measures
        database.execute("UPDATE cases SET measures = ? WHERE measures = ?", [changed, measures])
    with pytest.warns(MbprojWarning, match=r"is damaged: 4 of its cases are whole, and all others are computed again"):
        reached, entries = swept(path, tmp_path / "out")
    assert (reached.computed, reached.reused) == (1, 4)
    assert [entry.row.values for entry in entries] == [entry.row.values for entry in whole]
    assert (tmp_path / "out" / "store.damaged").exists()


def test_a_store_without_checksums_is_read_and_gets_them(tmp_path):
    stored(tmp_path / "store.sqlite")
    (tmp_path / "old").mkdir()
    old = tmp_path / "old" / "store.sqlite"
    with closing(sqlite3.connect(old)) as database, database:
        database.executescript(FORMAT_1)
        database.execute("ATTACH ? AS new", [str(tmp_path / "store.sqlite")])
        names = [column[1] for column in database.execute("PRAGMA table_info(cases)")]
        database.execute(f"INSERT INTO cases SELECT {', '.join(names)} FROM new.cases")
    shutil.copytree(tmp_path / "old", tmp_path / "damaged")
    found, said = read(old)
    assert len(found) == 60
    assert "is of format 1, without checksums: its 60 cases are taken as they are" in said[0]
    assert not (tmp_path / "old" / "store.damaged").exists()
    assert read(old)[1] == []
    with closing(sqlite3.connect(tmp_path / "damaged" / "store.sqlite")) as database, database:
        database.execute("UPDATE cases SET measures = '[' WHERE key LIKE '%3'")
    found, said = read(tmp_path / "damaged" / "store.sqlite")
    assert (len(found), "is damaged: 56 of its cases are whole" in said[0]) == (56, True)


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
    with closing(open_whole(tmp_path / "store.sqlite")) as database:
        assert database.execute("PRAGMA synchronous").fetchone()[0] >= 1
