"""The store: what goes in comes out, it is private and bounded, and nothing in its place stops a study."""

from __future__ import annotations

import os
import pickle
import sqlite3
import stat
import warnings
from contextlib import closing
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbproj
from mbproj.base.arrays import Array
from mbproj.base.errors import MbprojWarning, warn_once
from mbproj.base.mechanisms_folder import mechanism as mechanism_file
from mbproj.scene.scene import read_scene
from mbproj.studies import store as database
from mbproj.studies.measure.reference import Reference, reference
from mbproj.studies.measure.solve import Mechanism, sample_times
from mbproj.studies.parallel.hand_out import in_parallel
from mbproj.studies.store import decoded, encoded
from mbproj.studies.study import Study
from tests.studies.tasks import keep
from tests.support import ROOT

# A record that tests of the store keep.


@dataclass(frozen=True, eq=False)
class Drawn:
    """A record of the tests."""

    name: str
    values: tuple[int, float]
    inner: dict[str, Annotated[Array, "T 3"]] | None = None


# The store: it is private and bounded, and nothing that stands in its place stops a study.


def store(tmp_path: Path) -> Path:
    return tmp_path / "cache" / "studies" / "store.sqlite3"


def computed(value: Any, kind: Any = Any, **sizes: int) -> Any:
    """The value of ("a study", 1), and whether it had to be computed."""
    asked = []
    found = Study(("a study", 1), kind, **sizes).one("", lambda: asked.append(1) or value)
    return found, bool(asked)


def test_a_value_is_computed_once():
    assert computed(Drawn("x", (1, 2.0)), Drawn)[1]
    found, again = computed(None, Drawn)
    assert (found.name, found.values, again) == ("x", (1, 2.0), False)
    assert Study(("a study", 2), int).one("", lambda: 7) == 7


#: A record as it is expected.
WHOLE = Drawn("x", (1, 2.0), {"a": np.zeros((4, 3))})
#: Values that somebody stored in its place, with a checksum.
STRANGE = [
    None,
    [1, 2, 3],
    "text",
    {},
    Drawn("x", (1, 2.0, 3.0)),
    Drawn("x", (1, 2.0), {"a": np.zeros((3, 4))}),
    Drawn("x", (1, 2.0), {"a": np.zeros((5, 3))}),
    Drawn("x", (1, 2.0), {"a": np.zeros((4, 3), dtype=int)}),
    Drawn("x", (1, 2.0), {"a": 0.5}),
    Drawn(1, (1, 2.0)),  # type: ignore[arg-type]
    Drawn("x", ("1", 2.0)),  # type: ignore[arg-type]
]


@pytest.mark.parametrize("strange", STRANGE, ids=range(len(STRANGE)))
def test_a_value_of_another_type_or_shape_is_computed_anew(strange):
    computed(strange, Drawn)
    found, again = computed(WHOLE, Drawn, T=4)
    assert (found is WHOLE, again) == (True, True)
    assert not computed(None, Drawn, T=4)[1]
    Study("a study").add("a", strange)
    assert "a" not in Study("a study", Drawn, T=4).results


def test_a_stored_reference_of_another_shape_is_computed_anew():
    """The study that reads it would end with a TypeError or a ValueError, for ever."""
    mechanism, times = Mechanism.of(read_scene(mechanism_file("five_bar"))), sample_times(0.01, 2)
    whole = reference(mechanism, times)
    for strange in ([1, 2], replace(whole, position=whole.position[:, :, :2]), whole.at_every(2)):
        with closing(sqlite3.connect(database._private_folder() / "store.sqlite3")) as other, other:
            ((study,),) = other.execute("SELECT study FROM kept").fetchall()
            database.put(other, study, "", encoded(strange))
        assert same_reference(reference(mechanism, times), whole)
        assert same_reference(reference(mechanism, times), whole)


def same_reference(one: Reference, two: Reference) -> bool:
    return np.array_equal(one.position, two.position) and np.array_equal(one.times, two.times)


def test_a_flipped_bit_of_the_file_stops_no_study(tmp_path):
    """In the header, in the text of the schema, in a page: what is not whole is set aside, once."""
    computed("whole")
    path = store(tmp_path)
    data = path.read_bytes()
    random = np.random.default_rng(5)
    at = data.index(b"CREATE TABLE kept")
    places = [*range(8 * 16, 8 * 20), *range(8 * 44, 8 * 48)]  # the versions of the file's format
    places += [*random.integers(0, 8 * 100, 40), *random.integers(8 * at, 8 * (at + 180), 60)]
    places += [8 * (at + 13) + 7, *random.integers(0, 8 * len(data), 60)]
    for place in places:
        changed = bytearray(data)
        changed[place // 8] ^= 1 << place % 8
        path.write_bytes(changed)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert computed("whole")[0] == "whole", place
        assert computed("other") == ("whole", False), place


def test_a_study_resumes_and_begins_fresh_where_that_is_asked_for():
    Study({"span": 1}).add("a", float("inf"))
    again = Study({"span": 1})
    again.add("b", [1, None, {"c": "text"}])
    whole = Study({"span": 1})
    assert (whole.results["a"], whole.results["b"]) == (float("inf"), [1, None, {"c": "text"}])
    assert "a" not in Study({"span": 2}).results
    assert "a" not in Study({"span": 1}, fresh=True).results
    assert "b" not in Study({"span": 1}).results


def test_what_other_code_has_kept_is_not_taken(tmp_path, monkeypatch):
    database._code.cache_clear()
    Study({"span": 1}).add("a", 1)
    package = tmp_path / "mbproj"
    package.mkdir()
    (package / "__init__.py").write_text("changed = True\n")
    with monkeypatch.context() as patched:
        patched.setattr(mbproj, "__file__", str(package / "__init__.py"))
        assert "a" in Study({"span": 1}).results  # the code is read once in a process
        database._code.cache_clear()
        assert "a" not in Study({"span": 1}).results
    database._code.cache_clear()
    assert "a" in Study({"span": 1}).results


def test_a_study_without_a_name_is_in_memory_alone(tmp_path):
    alone = Study()
    alone.add("a", 1)
    assert (alone.results["a"], "a" in Study().results, store(tmp_path).exists()) == (1, False, False)


@pytest.mark.skipif(os.name != "posix", reason="modes of files")
def test_the_folder_is_private(tmp_path):
    store(tmp_path).parent.mkdir(parents=True, mode=0o777)
    store(tmp_path).parent.chmod(0o777)
    computed(1)
    assert stat.S_IMODE(store(tmp_path).parent.stat().st_mode) == 0o700
    assert not computed(1)[1]


def said(work: Any) -> list[str]:
    """What mbproj warns of meanwhile."""
    warn_once.cache_clear()
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        work()
    assert {each.category for each in found} <= {MbprojWarning}
    return [str(each.message) for each in found]


def database_of_others(path: Path) -> None:
    with closing(sqlite3.connect(path)) as other:
        other.execute("CREATE TABLE kept (study, item, used, value)")
        other.commit()


def cut(path: Path) -> None:
    computed(np.arange(10_000.0))
    path.write_bytes(path.read_bytes()[:40_000])


def torn(path: Path) -> None:
    computed(np.arange(10_000.0))
    whole = bytearray(path.read_bytes())
    whole[8192:] = bytes(len(whole) - 8192)
    path.write_bytes(whole)


def older(path: Path) -> None:
    computed(1)
    with closing(sqlite3.connect(path)) as other:
        other.execute("PRAGMA user_version = 0")


@pytest.mark.parametrize(
    "spoil",
    [
        lambda path: path.write_text('{"key": 1}\ngarbage'), lambda path: path.write_bytes(os.urandom(5000)),
        lambda path: path.mkdir(), lambda path: os.mkfifo(path), database_of_others, cut, torn, older,
    ],
    ids=["text", "noise", "folder", "fifo", "foreign", "cut", "torn", "older"],
)  # fmt: skip
def test_what_is_no_store_is_set_aside_with_one_line(tmp_path, spoil):
    path = store(tmp_path)
    path.parent.mkdir(parents=True)
    spoil(path)
    results: list[Any] = []
    (line,) = said(lambda: results.append(computed("new")))
    assert line.startswith(f"'{path}' is not as mbproj has written it (")
    assert line.endswith("): it is now 'store.aside'")
    assert "\n" not in line
    assert results == [("new", True)]
    assert path.with_name("store.aside").exists()
    assert computed(None) == ("new", False)


def test_a_cache_folder_that_is_a_file_is_said_and_nothing_is_kept(tmp_path):
    (tmp_path / "cache").write_text("a file")
    (line,) = said(lambda: [computed(1), computed(1), Study("x").add("a", 1)])
    assert line.startswith("results of studies are not stored: [Errno 17] File exists: ")
    assert line.endswith("; MBPROJ_CACHE chooses another folder")
    assert (tmp_path / "cache").read_text() == "a file"


@pytest.mark.parametrize(
    ("system", "variables", "folder"),
    [
        ("linux", {}, "~/.cache/mbproj"),
        ("linux", {"XDG_CACHE_HOME": "/caches"}, "/caches/mbproj"),
        ("linux", {"XDG_CACHE_HOME": "caches"}, "~/.cache/mbproj"),
        ("linux", {"XDG_CACHE_HOME": "/caches", "MBPROJ_CACHE": "here"}, "here"),
        ("darwin", {}, "~/Library/Caches/mbproj"),
        ("win32", {"LOCALAPPDATA": "/local"}, "/local/mbproj/Cache"),
    ],
)
def test_the_store_is_where_the_system_keeps_caches(monkeypatch, system, variables, folder):
    for name in ("XDG_CACHE_HOME", "MBPROJ_CACHE", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(database.sys, "platform", system)
    assert database._folder() == Path(folder)


def test_a_user_without_a_home_keeps_nothing(monkeypatch):
    monkeypatch.setenv("MBPROJ_CACHE", "~no such user/cache")
    (line,) = said(lambda: computed(1))
    assert "'~no such user/cache': the user has no home" in line


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners of files")
def test_a_folder_of_another_user_is_not_trusted(tmp_path, monkeypatch):
    computed(1)
    monkeypatch.setattr(os, "getuid", lambda: 12345)
    results: list[Any] = []
    (line,) = said(lambda: results.append(computed(2)))
    assert "studies' belongs to another user" in line
    assert results == [(2, True)]


class Planted:
    """Would make a file when it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return Path.touch, (self.path,)


def test_a_planted_pickle_is_not_run(tmp_path):
    mark = tmp_path / "it was run"
    code = pickle.dumps(Planted(mark))
    computed(1)
    with closing(sqlite3.connect(store(tmp_path))) as other:
        other.execute("UPDATE kept SET value = ?", [code])
        other.commit()
    for name in ("0" * 64, *(path.stem for path in store(tmp_path).parent.iterdir())):
        (tmp_path / "cache" / f"{name}.pickle").write_bytes(code)
    assert computed(2) == (2, True)
    assert not mark.exists()
    pickle.loads(code)
    assert mark.exists()


def test_only_workers_pickle():
    found = [path for path in (ROOT / "mbproj").rglob("*.py") if "import pickle" in path.read_text(encoding="utf-8")]
    assert {path.name for path in found} == {"worker.py", "workers.py", "cluster.py"}


def test_many_processes_write_at_once():
    for _ in in_parallel(keep, "shared", list(range(8)), where=4):
        pass
    found = {name: decoded(data, list[int]) for name, data in database.read("shared").items()}
    assert found == {f"{item}-{part}": [item, part] for item in range(8) for part in range(20)}


def test_what_was_used_longest_ago_makes_room(tmp_path, monkeypatch):
    monkeypatch.setattr(database, "BOUND", 2_000_000)
    monkeypatch.setattr(database, "LARGEST", 500_000)
    clock = iter(range(10_000))
    monkeypatch.setattr(database, "time", lambda: float(next(clock)))
    sizes = np.random.default_rng(1).integers(1, 400_000, 60)
    for number, size in enumerate(sizes):
        database.write(f"study {number}", "", bytes(int(size)))
        assert database.read("study 0") == {"": bytes(int(sizes[0]))}  # is used again and again
        assert database.read(f"study {number}") == {"": bytes(int(size))}
    assert store(tmp_path).stat().st_size <= 2_000_000
    there = [number for number in range(60) if database.read(f"study {number}")]
    assert there == [0, *range(there[1], 60)]  # the latest ones, without a gap
    assert 1_000_000 < sizes[there].sum() < 2_000_000
    database.write("too large", "", bytes(500_001))
    assert database.read("too large") == {}


# What the store writes: what goes in comes out, and it holds data only.


class Colour(Enum):
    """A word of a few."""

    RED = "red"


#: Types of plain values with a strategy for each.
PLAIN: dict[Any, st.SearchStrategy[Any]] = {
    type(None): st.none(),
    bool: st.booleans(),
    int: st.integers(),
    float: st.floats(),
    str: st.text(),
    Colour: st.just(Colour.RED),
    Array: st.lists(st.integers(0, 3), max_size=3).map(lambda shape: np.random.default_rng(1).normal(size=shape)),
    npt.NDArray[np.bool_]: st.lists(st.booleans(), max_size=3).map(np.array).map(lambda each: each.astype(bool)),
    npt.NDArray[np.int64]: st.lists(st.integers(-3, 3), max_size=3).map(lambda each: np.array(each, dtype=np.int64)),
}


def values() -> st.SearchStrategy[tuple[Any, Any]]:
    """Types with a value of each."""
    plain = st.sampled_from([*PLAIN]).flatmap(lambda kind: PLAIN[kind].map(lambda value: (kind, value)))
    return st.recursive(
        plain,
        lambda inner: (
            inner.map(lambda of: (list[of[0]], [of[1], of[1]]))
            | inner.map(lambda of: (tuple[of[0], ...], (of[1], of[1])))
            | st.tuples(inner, inner).map(lambda of: (tuple[of[0][0], of[1][0]], (of[0][1], of[1][1])))
            | st.tuples(st.text(), inner).map(lambda of: (dict[str, of[1][0]], {of[0]: of[1][1]}))
            | inner.map(lambda of: (of[0] | None, of[1]))
            | inner.map(lambda of: (of[0] | None, None))
        ),
        max_leaves=8,
    )


def same(one: Any, two: Any) -> bool:
    """Equal in type and value, NaN equal to NaN, arrays bit by bit."""
    if type(one) is not type(two):
        return False
    if isinstance(one, np.ndarray):
        return (one.dtype, one.shape, one.tobytes()) == (two.dtype, two.shape, two.tobytes())
    if isinstance(one, dict):
        return one.keys() == two.keys() and all(same(one[key], two[key]) for key in one)
    if isinstance(one, list | tuple):
        return len(one) == len(two) and all(map(same, one, two))
    return repr(one) == repr(two)


@given(values())
def test_what_goes_in_comes_out(of):
    kind, value = of
    assert same(decoded(encoded(value), kind), value)


def test_a_record_comes_out_whole():
    found = decoded(encoded(WHOLE), Drawn, T=4)
    assert (found.name, found.values, [*found.inner]) == ("x", (1, 2.0), ["a"])
    assert same(found.inner["a"], WHOLE.inner["a"])


@given(values(), st.data())
def test_a_flipped_bit_is_seen(of, data):
    """In the value or in its names."""
    row = ["a study", "an item", database._sealed("a study", "an item", encoded(of[1]))]
    part = data.draw(st.integers(0, 2))
    whole = bytearray(row[part] if part == 2 else row[part].encode())
    at = data.draw(st.integers(0, 8 * len(whole) - 1))
    whole[at // 8] ^= 1 << at % 8
    row[part] = bytes(whole) if part == 2 else whole.decode(errors="replace")
    assert database._whole(*row) is None


def planted(text: str, arrays: bytes = b"") -> bytes:
    """What somebody writes who knows the format."""
    return len(text).to_bytes(8, "little") + text.encode() + arrays


@pytest.mark.parametrize(
    "data",
    [
        b"",
        pickle.dumps({"a": 1}),
        planted("no JSON"),
        planted('["<f8", [1000000000000], 0]'),
        planted('["|O", [1], 0]', bytes(8)),
        planted('["<f8", [-1], 0]', bytes(8)),
        planted('["<f8", [1], 8]', bytes(8)),
        planted('{"args": "true"}'),
        planted('["x", [1, 2.0]]'),
        planted('["x", [1, 2.0], null, 1]'),
        planted("[" * 100_000),
        planted("3"),
    ],
    ids=range(12),
)
@pytest.mark.parametrize("kind", [Array, Drawn, dict[str, Array], list[Drawn] | tuple[Drawn, Array]])
def test_what_is_not_data_of_ours_is_refused(data, kind):
    with pytest.raises(ValueError, match=r".+"):
        decoded(data, kind)


@pytest.mark.parametrize("value", [object(), {1: 2}, np.array([None]), np.zeros(2, dtype=np.float32), b"bytes"])
def test_what_is_no_data_is_not_kept(value):
    with pytest.raises(TypeError, match="not kept"):
        encoded(value)
