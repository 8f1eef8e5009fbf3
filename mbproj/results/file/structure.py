"""A file's groups and links, looked over before any dataset is used: nothing in a results file leads out of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import h5py
from h5py import h5d, h5g, h5l, h5o

from mbproj.errors import InputError, Problem

#: Links that name where an object is; mbproj writes hard links alone, which are the object.
LINKS = {h5l.TYPE_SOFT: "a soft link", h5l.TYPE_EXTERNAL: "an external link"}


def check_structure(file: h5py.File, path: Path) -> None:
    """Raises InputError that names the first link out of the file, or the first dataset whose numbers stand in another.
    Nothing that they lead to is opened."""
    for name, what in _ways_out(file.id):
        message = f"'{path}': '{name}' is {what}, which could lead to another file"
        raise InputError(Problem(message, hint="a results file holds all of its data itself; repeat the run"))


def _ways_out(root: h5g.GroupID) -> Iterator[tuple[str, str]]:
    """Each link or dataset that leads out of the file, and what it is. Every object is visited once."""
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
    """What a dataset is whose numbers stand elsewhere. Its properties are asked, not its shape: that of a virtual
    dataset depends on files which HDF5 would open."""
    properties = dataset.get_create_plist()
    if properties.get_layout() == h5d.VIRTUAL:
        return "a virtual dataset"
    if properties.get_external_count():
        return "a dataset in external storage"
    return None
