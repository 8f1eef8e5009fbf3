"""The data of a mechanism and its run for a page: plain data for JSON, and blocks of packed numbers."""

from __future__ import annotations

import zlib
from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field
from typing import Any

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.results.record import Results
from mbproj.show.appearance.mechanism import DrawnSpan, Look, View
from mbproj.show.appearance.motion import PoseHistory

# --- Numbers as compact bytes -----------------------------------------------------------------------------------------
# Integer multiples of a step, stored as differences in time, byte by byte, compressed.
# A smooth motion has small differences of second or third order, whose bytes are mostly zero. The integers are stored
# exactly, so no error adds up. `browser/unpack.js` reads the bytes.


#: The integer that stands for NaN and infinity.
NO_NUMBER = -(2**31)
#: The bound on all integers, so that none equals NO_NUMBER, and differences fit into 32 bits with wrap-around.
LARGEST = 2**30
#: The orders of differences that are tried.
ORDERS = range(4)


@dataclass
class Packer:
    """A collector of blocks of numbers. `blocks` describes them for the page; `text` is all their bytes."""

    blocks: list[dict[str, object]] = field(default_factory=list)
    _bytes: list[bytes] = field(default_factory=list)
    _length: int = 0

    def add(self, values: Array, step: float | Array) -> int:
        """Add values (T, c), each rounded to a multiple of `step` (one for all, or one for each column). Return the
        number of the block."""
        steps = np.broadcast_to(np.asarray(step, dtype=float), (values.shape[1],))
        whole = multiples(values, steps)
        order = min(ORDERS, key=lambda order: _cost(_differences(whole, order)))
        data = _planes(_differences(whole, order))
        same = bool((steps == steps[:1]).all())
        self.blocks.append(
            {
                "at": self._length,
                "rows": int(values.shape[0]),
                "columns": int(values.shape[1]),
                "order": order,
                "steps": [float(steps[0])] if same and len(steps) else steps.tolist(),
            }
        )
        self._bytes.append(data)
        self._length += len(data)
        return len(self.blocks) - 1

    def text(self) -> str:
        """All bytes, compressed by zlib, in base 64."""
        return b64encode(zlib.compress(b"".join(self._bytes), 9)).decode("ascii")


def multiples(values: Array, steps: Array) -> np.ndarray:
    """The nearest multiples (T, c) of the steps; NO_NUMBER where a value is not finite or too large."""
    with np.errstate(invalid="ignore", over="ignore"):
        scaled = np.rint(values / steps)
        fits = np.abs(scaled) < LARGEST  # False for NaN
    return np.where(fits, scaled, NO_NUMBER).astype(np.int64).astype(np.int32)


def step_of(values: Array, digits: int) -> Array:
    """The step (c,) with which each column keeps `digits` binary digits of its largest number; 1 where all are zero."""
    with np.errstate(invalid="ignore"):
        largest = np.max(np.abs(values), axis=0, where=np.isfinite(values), initial=0.0)
    _, exponent = np.frexp(largest)
    steps: Array = np.where(largest > 0.0, np.ldexp(1.0, np.clip(exponent - digits, -1000, 1000)), 1.0)
    return steps


def _differences(whole: np.ndarray, order: int) -> np.ndarray:
    """The differences of an order along time, in 32 bits with wrap-around. The first rows stay, so that they can be
    summed again."""
    differences = whole.copy()
    for turn in range(min(order, max(len(whole) - 1, 0))):
        differences[turn + 1 :] = differences[turn + 1 :] - differences[turn:-1]
    return differences


def _cost(differences: np.ndarray) -> float:
    """About the number of bits that the differences need."""
    return float(np.log2(1.0 + np.abs(differences.astype(float))).sum())


def _planes(differences: np.ndarray) -> bytes:
    """The bytes of the differences, column after column: first all lowest bytes. A sign bit at the low end keeps small
    numbers of both signs small."""
    flat = np.ascontiguousarray(differences.T).ravel()
    unsigned = ((flat << 1) ^ (flat >> 31)).astype("<u4")
    return np.ascontiguousarray(unsigned.view(np.uint8).reshape(-1, 4).T).tobytes()


# --- The series that a page charts ------------------------------------------------------------------------------------
# All that the run recorded, as far as there is room.


#: The most numbers of all series together. Groups that come later are left out first.
ROOM = 1_200_000


@dataclass(frozen=True, eq=False)
class SeriesGroup:
    """The series of one quantity: one of the run (`kind` ""), or one for each of `owners`, in `components` ("" for a
    scalar).

    `units` has one entry for the run, or one for each owner. `logarithmic` series are shown on a logarithmic scale."""

    name: str
    kind: str
    owners: tuple[str, ...]
    components: tuple[str, ...]
    units: tuple[str, ...]
    path: str
    logarithmic: bool = False

    @property
    def columns(self) -> int:
        """The number c of columns."""
        return max(len(self.owners), 1) * len(self.components)

    def values(self, results: Results) -> Array:
        """The series over all samples (T, c)."""
        read = np.asarray(results[self.path], dtype=float)
        return read.reshape(len(read), -1)


XYZ = ("x", "y", "z")
_RUN = (
    ("position violation", "m or rad", "diagnostics/position_violation", True),
    ("velocity violation", "m/s or rad/s", "diagnostics/velocity_violation", True),
    ("kinetic energy", "J", "diagnostics/kinetic_energy", False),
    ("potential energy", "J", "diagnostics/potential_energy", False),
    ("total energy", "J", "diagnostics/total_energy", False),
    ("energy balance", "J", "diagnostics/energy_balance", False),
    ("step size", "s", "diagnostics/step_size", True),
)
#: The kind of owners, quantity, unit and dataset of vector series. Angular velocities of bodies are in body axes, all
#: others in global axes.
_VECTORS = (
    ("joints", "reaction force", "N", "joints/reaction_force"),
    ("joints", "reaction torque", "N m", "joints/reaction_torque"),
    ("markers", "velocity", "m/s", "markers/velocity"),
    ("bodies", "velocity", "m/s", "bodies/velocity"),
    ("bodies", "angular velocity", "rad/s", "bodies/angular_velocity"),
    ("markers", "acceleration", "m/s²", "markers/acceleration"),
    ("bodies", "acceleration", "m/s²", "bodies/acceleration"),
    ("touching", "contact", "m", "curves/contact"),
)


def groups_of(results: Results) -> Iterator[SeriesGroup]:
    """All groups that the results have, the most useful first."""
    for name, unit, path, logarithmic in _RUN:
        yield SeriesGroup(name, "", (), ("",), (unit,), path, logarithmic)
    for group in _of_columns(results):
        if group.owners:
            yield group


def _of_columns(results: Results) -> Iterator[SeriesGroup]:
    joints, along, units = (results.names(kind) for kind in ("joints", "coordinates", "coordinate_units"))
    yield SeriesGroup("violation", "joints", joints, ("",), ("m or rad",) * len(joints), "joints/violation", True)
    yield SeriesGroup("coordinate", "coordinates", along, ("",), units, "joints/coordinate")
    yield SeriesGroup("rate", "coordinates", along, ("",), tuple(f"{unit}/s" for unit in units), "joints/speed")
    forces, lengths = results.names("forces"), results.names("force_units")
    yield SeriesGroup("coordinate", "forces", forces, ("",), lengths, "forces/coordinate")
    yield SeriesGroup("force", "forces", forces, ("",), _force_units(lengths), "forces/force")
    ropes = results.names("tensions")
    yield SeriesGroup("tension", "tensions", ropes, ("",), ("N",) * len(ropes), "ropes/tension")
    motions = results.names("motions")
    yield SeriesGroup("force", "motions", motions, ("",), _force_units(results.names("motion_units")), "motions/force")
    for kind, of in (("states", "state"), ("signals", "signal")):
        yield SeriesGroup("value", kind, results.names(kind), ("",), results.names(f"{of}_units"), f"{kind}/value")
    for kind, name, unit, path in _VECTORS:
        owners = results.names(kind)
        yield SeriesGroup(name, kind, owners, XYZ, (unit,) * len(owners), path)


def _force_units(units: Sequence[str]) -> tuple[str, ...]:
    """The units of forces along coordinates with these units."""
    return tuple("N m" if unit == "rad" else "N" for unit in units)


def fitting(groups: Iterable[SeriesGroup], frames: int) -> tuple[list[SeriesGroup], list[SeriesGroup]]:
    """The groups for which there is room, and those that are left out."""
    fitted: list[SeriesGroup] = []
    left: list[SeriesGroup] = []
    room = ROOM
    for group in groups:
        size = group.columns * frames
        (fitted if size <= room else left).append(group)
        room -= size if size <= room else 0
    return fitted, left


# --- The data of a mechanism and its run for a page -------------------------------------------------------------------


#: Binary digits of positions relative to the mechanism (as in float32), of Euler parameters, of series, and of vertices
#: of meshes. Then the largest distance of a position from the middle, as a power of two of its step.
POSITION, TURN, SERIES, VERTEX, FARTHEST = 24, 19, 18, 16, 29
#: The step of logarithms of sizes, and the size that replaces zero.
LOGARITHM, ZERO = 2.0**-10, 1e-18


def view_data(view: View) -> dict[str, Any]:
    """The data of a view. The page's axes have their origin at its middle."""
    return {
        "middle": _numbers(view.middle),
        "eye": _numbers(view.eye),
        "up": _numbers(view.up),
        "radius": float(view.radius),
        "flat": view.flat,
        "points": [_short(point - view.middle) for point in view.points],
    }


def look_data(look: Look, packer: Packer) -> dict[str, Any]:
    """The data of a look. Parts refer to meshes by their numbers."""
    meshes: list[dict[str, Any]] = []
    parts = []
    for drawn in look.drawn:
        part = drawn.part
        entry: dict[str, Any] = {
            "kind": part.kind,
            "size": _short(part.size),
            "position": _short(part.position),
            "orientation": _short(part.orientation),
            "carrier": drawn.carrier,
            "layer": drawn.layer,
            "item": drawn.item,
        }
        if part.mesh is not None:
            entry["mesh"] = len(meshes)
            step = float(step_of(part.mesh.vertices.reshape(-1, 1), VERTEX)[0])
            corners = packer.add(part.mesh.vertices, step), packer.add(part.mesh.triangles.astype(float), 1.0)
            meshes.append(dict(zip(("vertices", "triangles"), corners, strict=True)))
        parts.append(entry)
    return {
        "bodies": [{"name": body.name, "colour": body.colour, "opacity": body.opacity} for body in look.bodies],
        "joints": [
            {"name": joint.name, "type": joint.type, "bodies": list(joint.bodies), "point": _short(joint.point)}
            for joint in look.joints
        ],
        "markers": [
            {"name": marker.name, "body": marker.body, "point": _numbers(marker.point)} for marker in look.markers
        ],
        "spans": [
            {
                "kind": span.kind,
                "name": span.name,
                "carriers": list(span.carriers),
                "points": [_short(point) for point in span.points],
                "radius": span.radius,
                **_rope_data(span),
            }
            for span in look.spans
        ],
        "forces": list(look.forces),
        "loads": [
            {"name": load.name, "body": load.body, "point": _short(load.point), "torque": load.torque}
            for load in look.loads
        ],
        "parts": parts,
        "meshes": meshes,
        "thickness": look.thickness,
        "gravity": _numbers(look.gravity),
    }


def motion_data(motion: PoseHistory, size: float, packer: Packer) -> dict[str, Any]:
    """The data of a motion: poses with positions relative to their middle. `size` is that of the mechanism in m."""
    count = len(motion.time)
    low, high = motion.position.min(axis=(0, 1)), motion.position.max(axis=(0, 1))
    centre = 0.5 * (low + high)
    travel = 0.5 * float((high - low).max(initial=0.0))
    step = max(2.0 ** (np.ceil(np.log2(size)) - POSITION), 2.0 ** (np.ceil(np.log2(travel or size)) - FARTHEST))
    time = motion.time[:, None]
    return {
        "time": packer.add(time, step_of(time, FARTHEST)),
        "position": packer.add((motion.position - centre).reshape(count, -1), step),
        "orientation": packer.add(_steady(motion.orientation).reshape(count, -1), 2.0**-TURN),
        "centre": _numbers(centre),
    }


def path_data(look: Look, motion: PoseHistory, packer: Packer) -> list[dict[str, Any]]:
    """The paths of the points at which rolling joints touch, global, in m."""
    paths = ((each.name, each.path(motion)) for each in look.touching)
    return [{"name": name, "block": packer.add(path, step_of(path, POSITION))} for name, path in paths]


def group_data(group: SeriesGroup, values: Array, packer: Packer) -> dict[str, Any]:
    """The data of a group with its series (F, c); logarithmic series become powers of ten."""
    powers = np.log10(np.maximum(np.abs(values), ZERO)) if group.logarithmic else values
    return {
        "name": group.name,
        "kind": group.kind,
        "owners": list(group.owners),
        "components": list(group.components),
        "units": list(group.units),
        "logarithmic": group.logarithmic,
        "block": packer.add(powers, LOGARITHM if group.logarithmic else step_of(values, SERIES)),
    }


def _steady(orientation: Array) -> Array:
    """Euler parameters (T, n, 4) with signs that do not jump from sample to sample."""
    turns = np.einsum("tnk,tnk->tn", orientation[1:], orientation[:-1])
    signs = np.cumprod(np.where(turns < 0.0, -1.0, 1.0), axis=0)
    steady = orientation.copy()
    steady[1:] *= signs[..., None]
    return steady


def _numbers(values: Sequence[float] | Array) -> list[float]:
    return [float(value) for value in values]


def _rope_data(span: DrawnSpan) -> dict[str, Any]:
    """The data of the circles that a part of a rope touches."""
    if span.normal is None:
        return {}
    return {"radii": list(span.radii), "normal": _numbers(span.normal), "frame": span.frame}


def _short(values: Sequence[float] | Array) -> list[float]:
    """The values with seven digits, which are enough to draw."""
    return [float(f"{value:.7g}") for value in values]


# --- The samples of a run that a page shows ---------------------------------------------------------------------------
# As many as 60 frames a second can show, and a browser can hold.


#: Frames a second, and the fewest frames of a run: a short run is watched more slowly.
RATE, FEWEST = 60.0, 600
#: The count of pose numbers (7 for each body and frame) above which frames are left out, and above which no page is
#: made. A browser holds four bytes for each, the file about two.
THINNED, REFUSED = 10_000_000, 60_000_000


@dataclass(frozen=True, eq=False)
class PageFrames:
    """The samples (F,) that are shown, and a remark where these are not all."""

    rows: Integers
    remark: str


def frames_of(time: Array, whole: Integers, bodies: int, full: bool = False) -> PageFrames:
    """The frames of a run with samples at `time` (T,), chosen from the samples `whole`, which are finite. With `full`,
    all of those.

    Raises InputError where no browser could hold them."""
    span = float(time[whole[-1]] - time[whole[0]]) if len(whole) else 0.0
    wanted = len(whole) if full else min(len(whole), max(FEWEST, int(np.ceil(RATE * span))) + 1)
    room = max(2, THINNED // (7 * max(bodies, 1)))
    if full and 7 * bodies * wanted > REFUSED:
        message = f"{wanted} frames of {bodies} bodies are {7e-6 * bodies * wanted:.0f} million numbers"
        hint = f"leave --full out, or take a part with --from and --to; a page holds {REFUSED // 1_000_000} million"
        raise InputError(Problem(f"{message}, more than a browser opens", hint=hint))
    if 14 * bodies > REFUSED:
        message = f"{bodies} bodies are more than a browser shows"
        raise InputError(Problem(message, hint=f"a page holds {REFUSED // 14} bodies"))
    count = wanted if full else min(wanted, room)
    rows = whole if count >= len(whole) else whole[_spread(time[whole], count)]
    return PageFrames(rows, _remark(len(rows), len(whole), count < wanted))


def _spread(time: Array, count: int) -> Integers:
    """Samples that are spread evenly in time: the nearest to `count` even times."""
    even = np.linspace(time[0], time[-1], count)
    after = np.clip(np.searchsorted(time, even), 1, len(time) - 1)
    nearer = np.where(even - time[after - 1] < time[after] - even, after - 1, after)
    return np.unique(nearer)


def _remark(shown: int, recorded: int, cramped: bool) -> str:
    if shown == recorded:
        return ""
    why = "the page would be too large for a browser with more" if cramped else "more than a screen can show"
    return f"{shown} of {recorded} samples are shown: {why}"


def largest_between(values: Array, whole: Integers, rows: Integers) -> Array:
    """The largest of `values` (T, c) since the frame before, (F, c), so that a peak between two frames is not lost."""
    starts = np.concatenate([[whole[0]], rows[:-1] + 1]) if len(rows) else rows
    largest = [np.fmax.reduce(values[start : row + 1], axis=0) for start, row in zip(starts, rows, strict=True)]
    return np.array(largest).reshape(len(rows), values.shape[1])
