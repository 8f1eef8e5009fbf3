"""Checks a file's groups and links before any dataset is used: nothing in a results file may lead to another file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import h5py
from h5py import h5d, h5g, h5l, h5o

from mbproj.errors import InputError, Problem

#: Links that name the place of an object. mbproj writes only hard links, which lead to an object of the file itself.
LINKS = {h5l.TYPE_SOFT: "a soft link", h5l.TYPE_EXTERNAL: "an external link"}


def check_structure(file: h5py.File, path: Path) -> None:
    """Raises InputError that names the first link out of the file, or the first dataset with its numbers in another.
    None of the other files is opened."""
    for name, what in _ways_out(file.id):
        message = f"'{path}': '{name}' is {what}, which could lead to another file"
        raise InputError(Problem(message, hint="a results file holds all of its data itself; repeat the run"))


def _ways_out(root: h5g.GroupID) -> Iterator[tuple[str, str]]:
    """Yield each link or dataset that leads out of the file, and its kind. Every object is visited once."""
    groups = [("", h5g.open(root, b"/"))]
    seen = {h5o.get_info(root).addr}
    while groups:
        prefix, group = groups.pop()
        for link, kind in _links(group):
            name = f"{prefix}/{link.decode('utf-8', 'replace')}"
            if kind != h5l.TYPE_HARD:
                yield name, LINKS.get(kind, "a link of an unknown kind")
                continue
            info = h5o.get_info(group, link)
            if info.addr in seen:
                continue
            seen.add(info.addr)
            if info.type == h5o.TYPE_GROUP:
                groups.append((name, h5g.open(group, link)))
            elif info.type == h5o.TYPE_DATASET:
                elsewhere = _storage_elsewhere(h5d.open(group, link))
                if elsewhere:
                    yield name, elsewhere


def _links(group: h5g.GroupID) -> list[tuple[bytes, int]]:
    found: list[tuple[bytes, int]] = []
    group.links.iterate(lambda name, info: found.append((name, info.type)), info=True)
    return found


def _storage_elsewhere(dataset: h5d.DatasetID) -> str | None:
    """The kind of a dataset whose numbers are in another file; None for others. Its properties tell; its shape is not
    asked for, since HDF5 would open other files for that of a virtual dataset."""
    properties = dataset.get_create_plist()
    if properties.get_layout() == h5d.VIRTUAL:
        return "a virtual dataset"
    if properties.get_external_count():
        return "a dataset in external storage"
    return None
