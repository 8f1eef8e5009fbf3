"""Changes of a file's content by HDF5 itself: a file that is whole and holds nonsense, as somebody may send it."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from mbproj.results.file.checksums import stamp_attributes

TEXTS = ("", "x", "../../T", "a\x1b[31mb", "a\0b", "\ud7ff\u202e", "nan", "1e400", "x" * 70_000, "[" * 9_000, "null",
         "{}", "[]", '{"a": {"b": 1}}', '{"duration": 1e308}', "mbproj: 1", "\n\n\n", "- " * 5_000)  # fmt: skip
NUMBERS = (0, -1, 1, 2**31, 2**63 - 1, -(2**63), 1e308, -1e308, 1e-320, float("nan"), float("inf"), True)
TYPES = ("f4", "f8", ">f8", "i1", "i8", "u8", "c16", "S3", "V5", "?", [("a", "f8"), ("b", "S2")])
VALUES: tuple[Any, ...] = (None, -1, 0, 1e-300, 1e300, 10**30, 0.01, "x", "nan", [], [1, 2], {}, {"a": 1}, True,
                           "gpopm", "rk4", [1e308, 1e308])  # fmt: skip
PARTS = ("text", "path", "title", "settings", "overrides")


def dataset_replaced(file: h5py.File, draw: random.Random) -> str:
    """A dataset of another shape, type or storage."""
    name = _dataset(file, draw)
    old = file[name].shape or ()
    del file[name]
    shape = draw.choice([old, (), (0,), (1,), (*old, 2), old[::-1], (5,), (10**9,), (2**40,), (3, 2**33)])
    kind = draw.choice([*TYPES, h5py.vlen_dtype(np.float64), h5py.string_dtype(), h5py.ref_dtype])
    chunks = draw.choice([None, None, True, tuple(min(max(1, size), 10**7) for size in shape) or None])
    packed = draw.choice([None, None, "gzip", "lzf"]) if chunks and shape else None
    file.create_dataset(name, shape, kind, chunks=chunks if shape else None, compression=packed)
    return f"'{name}' is {shape} of {kind}, chunks {chunks}, {packed}"


def resized(file: h5py.File, draw: random.Random) -> str:
    """Datasets declare more or fewer samples than they have."""
    rows = draw.choice([0, 1, 3, 10**4, 10**8, 2**62])
    every = draw.random() < 0.5
    names = [name for name in _datasets(file) if file[name].maxshape and file[name].maxshape[0] is None]
    for name in names if every else draw.sample(names, 1):
        file[name].resize(rows, axis=0)
    return f"{'all' if every else 'one'} of {rows} rows"


def numbers(file: h5py.File, draw: random.Random) -> str:
    """Some numbers of a dataset become others."""
    names = [name for name in _datasets(file) if file[name].dtype.kind in "fi" and file[name].size]
    name, value = draw.choice(names), draw.choice(NUMBERS)
    values = file[name][...]
    flat = values.reshape(-1)
    with np.errstate(all="ignore"):
        number = np.array(value).astype(values.dtype)
    flat[draw.randrange(flat.size) if draw.random() < 0.5 else slice(None)] = number
    file[name][...] = values
    file[name].attrs.modify("crc32", np.int64(-1))
    return f"{value} in '{name}'"


def text(file: h5py.File, draw: random.Random) -> str:
    """A text of the scene becomes another."""
    name, value = f"scene/{draw.choice(PARTS)}", draw.choice(TEXTS)
    _write_text(file, name, value)
    return f"'{name}' is {value[:20]!r}"


def setting(file: h5py.File, draw: random.Random) -> str:
    """A setting, or a parameter that --set changed, becomes another."""
    name = draw.choice(["scene/settings", "scene/settings", "scene/overrides"])
    values = json.loads(bytes(file[name][()]))
    inner = values["projection"] if name.endswith("settings") and draw.random() < 0.5 else values
    key, value = draw.choice([*inner, "other", "length"]), draw.choice(VALUES)
    inner[key] = value
    _write_text(file, name, json.dumps(values))
    return f"{key} = {str(value)[:20]} in '{name}'"


def names(file: h5py.File, draw: random.Random) -> str:
    """Names become others, more or fewer."""
    name = draw.choice([name for name in _datasets(file) if name.endswith(("names", "units"))])
    values = [value.decode() for value in file[name][...].reshape(-1)]
    how = draw.choice(["more", "fewer", "other"])
    if how == "other" and values:
        values[draw.randrange(len(values))] = draw.choice(TEXTS)
    values = [*values, "more"] if how == "more" else values[:-1] if how == "fewer" else values
    del file[name]
    file[name] = np.array([value.encode() for value in values] or np.zeros(0, "S1"), dtype=None if values else "S1")
    return f"{how} of '{name}'"


def attribute(file: h5py.File, draw: random.Random) -> str:
    """An attribute becomes another, is gone, or is new."""
    owner = file[draw.choice(["/", "/", _dataset(file, draw), *(g for g in ("trust", "verification") if g in file)])]
    name = draw.choice([*owner.attrs, "other"])
    made = draw.choice([*TEXTS, *NUMBERS, np.zeros(3), h5py.Empty("f8"), np.zeros(2, TYPES[-1]), b"\xff\xfe"])
    if draw.random() < 0.3 and name in owner.attrs:
        del owner.attrs[name]
    else:
        owner.attrs[name] = np.bytes_(made) if isinstance(made, bytes) else _storable(made)
    if isinstance(owner, h5py.Group) and draw.random() < 0.5:
        stamp_attributes(owner)
    return f"attribute '{name}' of '{owner.name}' is {str(made)[:20]!r}"


def gone(file: h5py.File, draw: random.Random) -> str:
    """A dataset or a group is gone, or a group stands in the place of a dataset."""
    name = draw.choice([_dataset(file, draw), *file])
    del file[name]
    if draw.random() < 0.3:
        file.create_group(name)
    return f"no '{name}'"


def link(file: h5py.File, draw: random.Random) -> str:
    """A link to elsewhere, or round in a circle."""
    name = draw.choice([_dataset(file, draw), "new", "scene/new", "trust", *file])
    if name in file:
        del file[name]
    targets = (h5py.SoftLink("/time"), h5py.SoftLink("/" + name), h5py.ExternalLink("pipe", "/time"),
               h5py.ExternalLink("/dev/zero", "/"), file["/"])  # fmt: skip
    target = draw.choice(targets)
    file[name] = target
    return f"'{name}' leads to {target}"


def stored_elsewhere(file: h5py.File, draw: random.Random) -> str:
    """A dataset whose numbers stand in a pipe or a device."""
    name = _dataset(file, draw)
    shape, kind = file[name].shape or (1,), file[name].dtype
    del file[name]
    source = draw.choice(["pipe", "/dev/zero", "/etc/passwd"])
    if draw.random() < 0.5:
        size = max(1, int(np.prod(shape)) * kind.itemsize)
        file.create_dataset(name, shape, kind, external=[(source, 0, size)])
    else:
        layout = h5py.VirtualLayout(shape, kind)
        layout[...] = h5py.VirtualSource(source, "x", shape=shape)
        file.create_virtual_dataset(name, layout)
    return f"'{name}' stands in {source}"


def nested(file: h5py.File, draw: random.Random) -> str:
    """Groups in groups, or very many of them."""
    deep, inner = draw.choice([300, 3000]), file.create_group("deep")
    for number in range(deep):
        made = inner.create_group(f"g{number}")
        inner = made if draw.random() < 0.9 else inner
    return f"{deep} groups"


CHANGES: tuple[Callable[[h5py.File, random.Random], str], ...] = (
    dataset_replaced, dataset_replaced, resized, numbers, text, setting, setting, names, attribute, gone, link,
    stored_elsewhere, nested,
)  # fmt: skip


def change_contents(path: Path, draw: random.Random) -> str:
    """Changes the file at `path` once or twice; says how. What h5py does not let us write is no change."""
    said = []
    for _ in range(draw.choice([1, 1, 1, 2])):
        change = draw.choice(CHANGES)
        try:
            with h5py.File(path, "r+") as file:
                said.append(f"{change.__name__}: {change(file, draw)}")
        except (OSError, RuntimeError, LookupError, ValueError, TypeError, OverflowError, MemoryError) as error:
            said.append(f"{change.__name__} not made: {type(error).__name__}")
    return "; ".join(said)


def _datasets(file: h5py.File) -> list[str]:
    found: list[str] = []
    file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    return found


def _dataset(file: h5py.File, draw: random.Random) -> str:
    return draw.choice(_datasets(file))


def _write_text(file: h5py.File, name: str, value: str) -> None:
    del file[name]
    file[name] = np.array(value.encode("utf-8", "surrogatepass"), dtype=f"S{max(1, len(value.encode()))}")


def _storable(value: Any) -> Any:
    return value.replace("\0", "0") if isinstance(value, str) else value
