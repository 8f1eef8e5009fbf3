"""What the store writes: what goes in comes out, and it holds data only."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbproj.studies.store import decoded, encoded
from tests.studies.parallel.drawn import Drawn


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
