"""The store: what goes in comes out, it is private and bounded, and nothing in its place stops a study."""

from __future__ import annotations

import os
import pickle
import sqlite3
import stat
import warnings
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbproj
from mbproj.base.errors import MbprojWarning, warn_once
from mbproj.studies import store as database
from mbproj.studies import store as value_cache
from mbproj.studies.parallel.hand_out import in_parallel
from mbproj.studies.store import ValueCache, cached, decoded, encoded
from tests.studies.tasks import keep
from tests.support import ROOT

# A record that tests of the store keep.


@dataclass(frozen=True, eq=False)
class Drawn:
    """A record of the tests."""

    name: str
    values: Any
    inner: Any = None


# The store: it is private and bounded, and nothing that stands in its place stops a study.


def store(tmp_path: Path) -> Path:
    return tmp_path / "cache" / "studies" / "store.sqlite3"


def computed(value: Any) -> Any:
    """The value of ("a study", 1), and whether it had to be computed."""
    asked = []
    found = cached(("a study", 1), lambda: asked.append(1) or value, (Drawn,))
    return found, bool(asked)


def test_a_value_is_computed_once():
    assert computed(Drawn("x", (1, 2.0)))[1]
    found, again = computed(None)
    assert (found.name, found.values, again) == ("x", (1, 2.0), False)
    assert cached(("a study", 2), lambda: 7, ()) == 7


def test_a_study_resumes_and_begins_fresh_where_that_is_asked_for():
    ValueCache({"span": 1}).add("a", float("inf"))
    again = ValueCache({"span": 1})
    again.add("b", [1, None, {"c": "text"}])
    whole = ValueCache({"span": 1})
    assert (whole["a"], whole["b"]) == (float("inf"), [1, None, {"c": "text"}])
    assert "a" not in ValueCache({"span": 2})
    assert "a" not in ValueCache({"span": 1}, fresh=True)
    assert "b" not in ValueCache({"span": 1})


def test_what_other_code_has_kept_is_not_taken(tmp_path, monkeypatch):
    value_cache._code.cache_clear()
    ValueCache({"span": 1}).add("a", 1)
    package = tmp_path / "mbproj"
    package.mkdir()
    (package / "__init__.py").write_text("changed = True\n")
    with monkeypatch.context() as patched:
        patched.setattr(mbproj, "__file__", str(package / "__init__.py"))
        assert "a" in ValueCache({"span": 1})  # the code is read once in a process
        value_cache._code.cache_clear()
        assert "a" not in ValueCache({"span": 1})
    value_cache._code.cache_clear()
    assert "a" in ValueCache({"span": 1})


def test_a_study_without_a_name_is_in_memory_alone(tmp_path):
    alone = ValueCache()
    alone.add("a", 1)
    assert (alone["a"], "a" in ValueCache(), store(tmp_path).exists()) == (1, False, False)


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
    assert line.startswith(f"'{path}' is not what mbproj has kept there (")
    assert "\n" not in line
    assert results == [("new", True)]
    assert path.with_name("store.aside").exists()
    assert computed(None) == ("new", False)


def test_a_cache_folder_that_is_a_file_is_said_and_nothing_is_kept(tmp_path):
    (tmp_path / "cache").write_text("a file")
    (line,) = said(lambda: [computed(1), computed(1), ValueCache("x").add("a", 1)])
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
    found = {name: decoded(data) for name, data in database.read("shared").items()}
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


@dataclass(frozen=True)
class Other:
    """A record that nobody has named to the reader."""

    name: str


def arrays() -> st.SearchStrategy[np.ndarray]:
    shape = st.lists(st.integers(0, 3), max_size=3)
    numbers = st.sampled_from([np.float64, np.int64, np.bool_])
    filled = st.tuples(shape, numbers, st.integers(0, 2**32 - 1))
    return filled.map(lambda of: np.random.default_rng(of[2]).integers(-3, 3, of[0]).astype(of[1]))


def values() -> st.SearchStrategy[Any]:
    plain = st.none() | st.booleans() | st.integers() | st.floats() | st.text() | arrays()
    return st.recursive(
        plain,
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.lists(inner, max_size=3).map(tuple)
            | st.dictionaries(st.text(), inner, max_size=3)
            | st.builds(Drawn, st.text(), inner, inner)
        ),
        max_leaves=12,
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
    if isinstance(one, Drawn):
        return all(same(getattr(one, name), getattr(two, name)) for name in ("name", "values", "inner"))
    return repr(one) == repr(two)


@given(values())
def test_what_goes_in_comes_out(value):
    assert same(decoded(encoded(value), (Drawn,)), value)


@given(values(), st.data())
def test_a_flipped_bit_is_seen(value, data):
    whole = bytearray(encoded(value))
    at = data.draw(st.integers(0, 8 * len(whole) - 1))
    whole[at // 8] ^= 1 << at % 8
    with pytest.raises(ValueError, match="its checksum is wrong"):
        decoded(bytes(whole), (Drawn,))


def planted(text: str, arrays: bytes = b"") -> bytes:
    """What somebody writes who knows the format."""
    from zlib import crc32

    rest = len(text).to_bytes(8, "little") + text.encode() + arrays
    return crc32(rest).to_bytes(4, "little") + rest


@pytest.mark.parametrize(
    "data",
    [
        b"",
        pickle.dumps({"a": 1}),
        planted("no JSON"),
        planted('{"array": ["<f8", [1000000000000], 0]}'),
        planted('{"array": ["|O", [1], 0]}', bytes(8)),
        planted('{"array": ["<f8", [-1], 0]}', bytes(8)),
        planted('{"array": ["<f8", [1], 8]}', bytes(8)),
        planted('{"code": "print()"}'),
        planted('{"record": ["Popen", {"args": "true"}]}'),
        planted('{"record": ["Drawn", {"name": "x"}]}'),
        planted('{"record": ["Drawn", 3]}'),
        planted("[" * 100_000),
        encoded(Other("x")),
    ],
    ids=range(13),
)
def test_what_is_not_data_of_ours_is_refused(data):
    with pytest.raises(ValueError, match=r".+"):
        decoded(data, (Drawn,))


@pytest.mark.parametrize("value", [object(), {1: 2}, np.array([None]), np.zeros(2, dtype=np.float32), b"bytes"])
def test_what_is_no_data_is_not_kept(value):
    with pytest.raises(TypeError, match="not kept"):
        encoded(value)
