"""The /trust group of a results file (`run --certify`): how long each marker can be trusted, its error over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import h5py
import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import brief, dataclass
from mbproj.results.file.checksums import NOT_YET, crc32, create_text, describe, stamp, stamp_attributes
from mbproj.results.file.contents import Contents

GROUP = "trust"
#: The status of the group where the run ended before the better solution was computed.
NOT_COMPUTED = "not computed"


@dataclass(frozen=True, eq=False)
class Poses:
    """The poses of the scene's bodies: centres of mass `position` (S, n, 3) in m, Euler parameters `orientation`
    (S, n, 4)."""

    position: Array
    orientation: Array

    __repr__ = brief


@dataclass(frozen=True, eq=False)
class Trust:
    """The comparison of a run with a better solution, for k points (markers, or bodies' centres of mass) and E limits.

    `error` (S, k): distance to the better solution in m at the times (S,), the samples of the run; `uncertainty`
    (S, k): the bound of that solution's own error. `horizon` (k, E): the first time in s at which the error exceeds a
    limit, within the range `horizon_low`, `horizon_high`; infinite where the limit holds to the end. `growth_rate` in
    1/s and `growth_power` fit the error's growth (k,); `growth_law` says which is nearer ("": none). `solution`
    describes the better one, `remark` is a further note. `better` are its poses at the same times, to be written;
    `read_better` reads them from a file.
    """

    names: tuple[str, ...]
    limits: Array
    time: Array
    error: Array
    uncertainty: Array
    horizon: Array
    horizon_low: Array
    horizon_high: Array
    growth_rate: Array
    growth_power: Array
    growth_law: tuple[str, ...]
    solution: str
    remark: str = ""
    better: Poses | None = None

    __repr__ = brief

    def untrusted_from(self, limit: float, name: str | None = None) -> float | None:
        """The first time (s) at which the error of the point `name` may exceed `limit` (m), or that of any point where
        no point has this name; None where it never does."""
        columns = [self.names.index(name)] if name in self.names else slice(None)
        beyond = np.flatnonzero(~(self.error + self.uncertainty <= limit)[:, columns].all(axis=1))
        return float(self.time[beyond[0]]) if len(beyond) else None


@dataclass(frozen=True)
class TrustDataset:
    """A dataset of the group: its axes ("S" samples, "k" points, "E" limits), unit, description."""

    axes: str
    unit: str
    description: str


LAYOUT: Mapping[str, TrustDataset] = MappingProxyType(
    {
        "limits": TrustDataset("E", "m", "limits of the error that the horizons are of"),
        "error": TrustDataset("Sk", "m", "distance to the better solution at the samples of the run"),
        "uncertainty": TrustDataset("Sk", "m", "largest error that the better solution itself may have"),
        "horizon": TrustDataset(
            "kE", "s", "first time at which the error exceeds the limit; infinite where it does not"
        ),
        "horizon_low": TrustDataset("kE", "s", "first time at which the error can exceed the limit"),
        "horizon_high": TrustDataset("kE", "s", "first time by which the error must have exceeded the limit"),
        "growth_rate": TrustDataset("k", "1/s", "a of exp(a t) fitted to the largest error so far"),
        "growth_power": TrustDataset("k", "1", "p of t^p fitted to the largest error so far"),
    }
)
#: The datasets with the poses of the better solution, for "n" bodies.
POSES: Mapping[str, TrustDataset] = MappingProxyType(
    {
        "position": TrustDataset("Sn3", "m", "centres of mass in the better solution; nan where that has ended"),
        "orientation": TrustDataset("Sn4", "1", "Euler parameters there, scalar first, body to global"),
    }
)
#: The growth laws of errors; "" is none.
LAWS = {"", "exponential", "power"}
LAW = h5py.string_dtype("utf-8", len("exponential"))


def create(file: h5py.File, names: Sequence[str], limits: Sequence[float], bodies: int) -> None:
    """Create the group of a run that is to be certified, with its names and limits only."""
    sizes = {"S": 0, "k": len(names), "E": len(limits), "n": bodies, "3": 3, "4": 4}
    create_text(file, f"{GROUP}/names", names, "markers, or bodies (their centres of mass) where there are none")
    for name, entry in {**LAYOUT, **POSES}.items():
        shape = tuple(sizes[axis] for axis in entry.axes)
        longest = tuple(None if axis == "S" else sizes[axis] for axis in entry.axes)
        chunked = "S" in entry.axes
        data = file.create_dataset(
            f"{GROUP}/{name}",
            shape,
            "f8",
            maxshape=longest,
            chunks=chunked or None,
            fletcher32=chunked,
            fillvalue=np.nan,
        )
        describe(data, {"units": entry.unit, "description": entry.description})
        stamp(data, NOT_YET)
    file[GROUP]["limits"][:] = limits
    stamp(file[GROUP]["limits"], crc32(np.array(limits, dtype=float)))
    law = file.create_dataset(f"{GROUP}/growth_law", (len(names),), LAW)
    stamp(law, NOT_YET)
    said = "the nearer of the two fits, 'exponential' or 'power'; empty where there is none"
    describe(law, {"description": said})
    file[GROUP].attrs["status"] = NOT_COMPUTED


def room(trust: Trust) -> int:
    """The most bytes that `write` adds to the file."""
    better = trust.better
    return 2 * trust.error.nbytes + (0 if better is None else 2 * (better.position.nbytes + better.orientation.nbytes))


def write(file: h5py.File, trust: Trust) -> None:
    """Write the comparison into the group."""
    group = file[GROUP]
    named = {name: getattr(trust, name) for name in LAYOUT}
    if trust.better is not None:
        named |= {name: getattr(trust.better, name) for name in POSES}
    for name, values in named.items():
        if "S" in {**LAYOUT, **POSES}[name].axes:
            group[name].resize(values.shape)
        group[name][...] = values
        stamp(group[name], crc32(values))
    laws = np.array([law.encode() for law in trust.growth_law], dtype=LAW)
    group["growth_law"][...] = laws
    stamp(group["growth_law"], crc32(laws))
    group.attrs.update({"solution": trust.solution, "remark": trust.remark, "status": "complete"})
    stamp_attributes(group)


def asked_limits(contents: Contents) -> tuple[float, ...] | None:
    """The limits in m for which the run was, or was to be, certified; None for other runs."""
    if not contents.has(GROUP):
        return None
    limits = contents.array(f"{GROUP}/limits", (None,))
    if not (np.isfinite(limits).all() and (limits > 0.0).all()):
        raise contents.damaged(f"{GROUP}/limits", "has a limit that is not positive")
    return tuple(map(float, limits))


def read(contents: Contents) -> Trust | None:
    """Read the comparison; None where the file has no such group, or it was not computed."""
    if not contents.has(GROUP):
        return None
    attributes = contents.attributes(GROUP)
    if attributes.get("status") == NOT_COMPUTED:
        return None
    names, laws = (contents.texts(f"{GROUP}/{name}") for name in ("names", "growth_law"))
    sizes = {
        "S": contents.rows(f"{GROUP}/error", (len(names),)),
        "k": len(names),
        "E": contents.rows(f"{GROUP}/limits", ()),
    }
    values: dict[str, Any] = {
        name: contents.array(f"{GROUP}/{name}", tuple(sizes[axis] for axis in entry.axes))
        for name, entry in LAYOUT.items()
    }
    values["time"] = contents.array("time", (None,), window=slice(0, sizes["S"]))
    solution, remark = (attributes.get(name) for name in ("solution", "remark"))
    fits = len(laws) == len(names) and len(values["time"]) == sizes["S"] > 0
    if not (fits and set(laws) <= LAWS and isinstance(solution, str) and isinstance(remark, str)):
        raise contents.damaged(GROUP, "does not fit together")
    return Trust(names=names, growth_law=laws, solution=solution, remark=remark, **values)


def better_samples(contents: Contents, bodies: int) -> int:
    """The number of samples of the better solution's poses; 0 where the file has none."""
    if not contents.has(f"{GROUP}/position"):
        return 0
    for name in POSES:
        contents.check_room(f"{GROUP}/{name}")
    return contents.rows(f"{GROUP}/position", (bodies, 3))


def read_better(contents: Contents, bodies: int, window: slice) -> Poses | None:
    """Read the poses of the better solution at the samples of the window; None where the file does not have them."""
    samples = better_samples(contents, bodies)
    if not samples:
        return None
    rows = slice(window.start, min(window.stop, samples))
    position, orientation = (
        contents.array(f"{GROUP}/{name}", (samples, bodies, width), window=rows)
        for name, width in (("position", 3), ("orientation", 4))
    )
    return Poses(position, orientation)
