"""`Results`: the record of a run; each array is read from the file when it is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import brief, dataclass
from mbproj.base.errors import choose_from
from mbproj.base.settings import Settings
from mbproj.base.text import text_of
from mbproj.results import crash_safety as restarting
from mbproj.results import events as happening
from mbproj.results import largest_loads, provenance
from mbproj.results import notes as noting
from mbproj.results import trust as trusting
from mbproj.results.crash_safety import Checkpoint
from mbproj.results.events import RecordedEvent
from mbproj.results.faults import no_such_name
from mbproj.results.file.contents import Contents, KeptArrays
from mbproj.results.largest_loads import Load
from mbproj.results.layout import ALL_NAMES, CONSTANTS, DATASETS, LATER, MARKS, Dataset, datasets_for, trailing
from mbproj.results.notes import Note
from mbproj.results.provenance import UnfitSettings, settings_from
from mbproj.results.trust import Poses, Trust
from mbproj.scene.records import Vector
from mbproj.scene.scene import Scene

if TYPE_CHECKING:
    from mbproj.results.verification import Verification
    from mbproj.scene.meshes import TriangleMesh


# --- The results of one body, marker, joint or other item -------------------------------------------------------------
# The columns of the layout, in its order, by name.


#: The kinds of items that act along a coordinate.
ACTING = ("forces", "motions", "stops", "frictions")


@dataclass(frozen=True)
class ShownPart:
    """The part of a file that a `Results` shows: its samples, and its columns by symbol of the layout."""

    samples: slice
    columns: Mapping[str, Integers]


@dataclass(frozen=True)
class BodyResults:
    """The motion of a body: arrays (T, 3), orientation (T, 4); units and frames as in the layout."""

    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array

    __repr__ = brief


@dataclass(frozen=True)
class MarkerResults:
    """The motion of a marker: arrays (T, 3) in global axes, in m, m/s, m/s²."""

    position: Array
    velocity: Array
    acceleration: Array

    __repr__ = brief


@dataclass(frozen=True)
class JointResults:
    """A joint: its violations (T), of all rows in m or rad, of rows in m, of rows in rad. Its reactions act on body 2,
    (T, 3) in N and N m, in global axes."""

    violation: Array
    violation_length: Array
    violation_angle: Array
    reaction_force: Array
    reaction_torque: Array

    __repr__ = brief


@dataclass(frozen=True)
class ForceResults:
    """A force: the coordinate (T) in m or rad along which it acts, its rate, and the force in N or torque in N m."""

    coordinate: Array
    rate: Array
    force: Array

    __repr__ = brief


@dataclass(frozen=True)
class MotionResults:
    """A motion: the joint coordinate as prescribed (T) in m or rad, its rate, and the driving force in N or torque in
    N m."""

    value: Array
    rate: Array
    force: Array

    __repr__ = brief


@dataclass(frozen=True)
class Stop:
    """A stop: the distance (T) of the mechanism from it in m or rad, its rate, and the push of the stop in N or N m."""

    gap: Array
    rate: Array
    force: Array

    __repr__ = brief


@dataclass(frozen=True)
class Friction:
    """A dry friction: the rate (T) of the coordinate that it resists in m/s or rad/s, and its force in N or torque in
    N m. Its state is 1 or -1 where it slides up or down, 0 where it sticks. Last comes its lost energy in J."""

    rate: Array
    force: Array
    state: Array
    dissipation: Array

    __repr__ = brief


@dataclass(frozen=True)
class Coordinate:
    """A joint coordinate: its value (T) in the `unit` rad or m, and its rate."""

    value: Array
    speed: Array
    unit: str

    __repr__ = brief


@dataclass(frozen=True)
class Over:
    """The abscissa of pictures in place of time: a joint coordinate with its unit, rad or m. `values` (T) are those of
    the axis: angles in degrees, `modulo` a turn if asked for; `rate` (T) is in rad/s or m/s."""

    name: str
    unit: str
    values: Array
    rate: Array
    modulo: bool

    __repr__ = brief


# --- `Results` --------------------------------------------------------------------------------------------------------


NAMES_BY_PATH = MappingProxyType({entry.path: kind for kind, entry in ALL_NAMES.items()})
BY_PATH: Mapping[str, Dataset] = MappingProxyType({each.path: each for each in (*DATASETS, *LATER)})

#: A sample belongs to a window that it misses by less than this part of the last time, since 70 × 0.01 exceeds 0.7.
SAME_TIME = 1e-9


Same = TypeVar("Same", bound="Results")


class Results:
    """A run's results: `results["bodies/position"]`, `results.time`, `results.marker("tip").position`, ...

    Arrays are read from the file on first use, cached up to a size, and read-only. The file stays open until `close` or
    the end of a `with`. `contents` is the opened file, `path` its path; `partial` says that it is OUT.part, of a run
    that was killed or still goes on. Damage that shows only when an array is read raises InputError, as in
    `open_results`.
    """

    #: The abscissa of pictures, where that is not time.
    shown_over: Over | None = None

    def __init__(
        self,
        contents: Contents,
        attributes: Mapping[str, Any],
        names: Mapping[str, tuple[str, ...]],
        view: ShownPart,
    ) -> None:
        self.contents, self._view, self._all_names = contents, view, names
        self._arrays = KeptArrays()
        self.path = contents.path
        self.partial = self.path.name.endswith(".part")
        self.attributes = attributes

    def __enter__(self: Same) -> Same:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; arrays that were read before stay valid."""
        self.contents.close()

    def __getitem__(self, path: str) -> npt.NDArray[Any]:
        """The array of a dataset of the layout, first axis time; floats, or integers where it counts. The names of
        columns, as "joints/names", are an array of strings. What does not change has no time, as in `constant`. Raises
        KeyError with the nearest path."""
        if text_of(path, "the path of a dataset") in NAMES_BY_PATH:
            return np.array(self.names(NAMES_BY_PATH[path]))
        if path in MARKS and (marks := self.constant(path)) is not None:
            return marks
        if path not in BY_PATH or BY_PATH[path] not in self.datasets:
            known = "the run did not know it" if path in MARKS else choose_from(path, [*BY_PATH, *MARKS])
            raise KeyError(f"results have no dataset '{path}'; {known}")
        return self._arrays.get(path, lambda: self._read(BY_PATH[path]))

    def _read(self, dataset: Dataset) -> npt.NDArray[Any]:
        shape = (None, *trailing(dataset, self._all_sizes()))
        values = self.contents.array(dataset.path, shape, dataset.dtype, self._view.samples)
        if dataset.path == "time" and not (np.isfinite(values).all() and (np.diff(values) >= 0.0).all()):
            raise self.contents.damaged("time", "does not ascend")
        columns = self._view.columns.get(dataset.symbol or "")
        if columns is not None:
            values = np.take(values, columns, axis=1)
        values.flags.writeable = False
        return values

    def _all_sizes(self) -> dict[str, int]:
        """The number of columns of the file, by symbol of the layout."""
        return {entry.symbol: len(self._all_names[kind]) for kind, entry in ALL_NAMES.items()}

    @property
    def datasets(self) -> tuple[Dataset, ...]:
        """The datasets of the layout that the file has."""
        return datasets_for(self._all_sizes())

    def constant(self, path: str) -> npt.NDArray[Any] | None:
        """An array of the layout that does not change with time, as "joints/reaction_force_unique" (nj, 3); None where
        the run did not know it: its loops were too large, or its program had not given it to the writer."""
        constant = next((entry for entry in CONSTANTS if entry.path == text_of(path, "the path of marks")), None)
        if constant is None:
            raise KeyError(f"results have no marks '{path}'; {choose_from(path, [entry.path for entry in CONSTANTS])}")
        if not self.contents.has(path):
            return None
        values = self.contents.array(path, trailing(constant, self._all_sizes()), constant.dtype)
        columns = self._view.columns.get(str(constant.shape[0]))
        return values if columns is None else np.take(values, columns, axis=0)

    def shape(self, path: str) -> tuple[int, ...]:
        """The shape of a dataset's array, without reading it."""
        sizes = {ALL_NAMES[kind].symbol: len(self.names(kind)) for kind in ALL_NAMES}
        return (self._view.samples.stop - self._view.samples.start, *trailing(BY_PATH[path], sizes))

    @property
    def time(self) -> Array:
        """The times of the samples (T,), in s."""
        return self["time"]

    def names(self, kind: str) -> tuple[str, ...]:
        """Names of the columns by kind: "bodies", "markers", "joints", "coordinates", "forces", "motions", "stops",
        "frictions", "states", or their "coordinate_units", "force_units", "motion_units", "stop_units",
        "friction_units", "state_units"."""
        columns = self._view.columns.get(ALL_NAMES[kind].symbol)
        names = self._all_names[kind]
        return names if columns is None else tuple(names[column] for column in columns)

    def body(self, name: str) -> BodyResults:
        """The motion of a body. Raises InputError with the nearest name where there is none, as the next methods do."""
        return BodyResults(*self._columns("n", self._find("bodies", name)))

    def marker(self, name: str) -> MarkerResults:
        """The path of a marker."""
        return MarkerResults(*self._columns("k", self._find("markers", name)))

    def joint(self, name: str) -> JointResults:
        """A joint's violations and reactions."""
        return JointResults(*self._columns("nj", self._find("joints", name)))

    def force(self, name: str) -> ForceResults:
        """The coordinate along which a force acts, and its size."""
        return ForceResults(*self._columns("nf", self._find("forces", name)))

    def motion(self, name: str) -> MotionResults:
        """The coordinate that a motion prescribes, and its driving force."""
        return MotionResults(*self._columns("nm", self._find("motions", name)))

    def stop(self, name: str) -> Stop:
        """The distance of the mechanism from a stop, and the push of the stop."""
        return Stop(*self._columns("ns", self._find("stops", name)))

    def friction(self, name: str) -> Friction:
        """The sliding, the force and the losses of a dry friction, by the name of its force, or force.coordinate."""
        return Friction(*self._columns("nr", self._find("frictions", name)))

    def coordinate(self, name: str) -> Coordinate:
        """A joint coordinate by its whole name, e.g. "A.angle"."""
        column = self._find("coordinates", name)
        value, speed = self._columns("nc", column)
        return Coordinate(value, speed, self.names("coordinate_units")[column])

    def meshes(self) -> dict[str, TriangleMesh]:
        """The meshes by which bodies are drawn, by body."""
        return provenance.meshes(self.contents)

    def better(self) -> Poses | None:
        """The poses of the better solution that certified the run, at those of these samples that it has; None where
        the file has none."""
        return trusting.read_better(self.contents, len(self.names("bodies")), self._view.samples)

    def _columns(self, symbol: str, column: int) -> list[Array]:
        return [self[dataset.path][:, column] for dataset in self.datasets if dataset.symbol == symbol]

    def _find(self, kind: str, name: str) -> int:
        names = self.names(kind)
        if text_of(name, "a name") not in names:
            raise no_such_name(kind, name, names, f"'{self.path}'")
        return names.index(name)

    def select(
        self: Same,
        *,
        start: float = -np.inf,
        stop: float = np.inf,
        markers: Sequence[str] | None = None,
        joints: Sequence[str] | None = None,
        acting: Sequence[str] | None = None,
    ) -> Same:
        """The part of these results with start <= time <= stop, these markers and joints, and those forces, motions,
        stops and frictions named in `acting`; None: all. The name of a force selects all of its coordinates."""
        columns = dict(self._view.columns)
        if markers is not None:
            columns["k"] = self._positions("k", [self._find("markers", name) for name in markers])
        for kind in ACTING if acting is not None else ():
            at = [i for i, name in enumerate(self.names(kind)) if {name, name.partition(".")[0]} & {*(acting or ())}]
            columns[ALL_NAMES[kind].symbol] = self._positions(ALL_NAMES[kind].symbol, at)
        if joints is not None:
            columns["nj"] = self._positions("nj", [self._find("joints", name) for name in joints])
            of_joints = [i for i, name in enumerate(self.names("coordinates")) if name.rpartition(".")[0] in joints]
            columns["nc"] = self._positions("nc", of_joints)
        first, time = self._view.samples.start, self.time
        slack = SAME_TIME * float(np.max(np.abs(time), initial=0.0))
        low, high = np.searchsorted(time, start - slack, "left"), np.searchsorted(time, stop + slack, "right")
        view = ShownPart(slice(first + int(low), first + max(int(low), int(high))), columns)
        return type(self)(self.contents, self.attributes, self._all_names, view)

    def __contains__(self, path: object) -> bool:
        """Whether the file has an array of the layout at a path, as "joints/coordinate"."""
        return any(path == dataset.path for dataset in self.datasets) or (
            path in MARKS and self.contents.has(str(path))
        )

    def over(self: Same, name: str, *, modulo: bool = False, of: Results | None = None) -> Same:
        """These results with a joint coordinate, as "A.angle", in place of time as the abscissa of pictures. An angle
        is in degrees, with `modulo` within a turn. `of` are results of the same samples that have the coordinate, where
        this view leaves it out. Raises InputError with the nearest name where there is none."""
        coordinate, shown = (of or self).coordinate(name), copy(self)
        values = np.degrees(coordinate.value) if coordinate.unit == "rad" else coordinate.value
        is_turned = modulo and coordinate.unit == "rad"
        shown.shown_over = Over(
            name, coordinate.unit, values % 360.0 if is_turned else values, coordinate.speed, is_turned
        )
        return shown

    @property
    def abscissa(self) -> Array:
        """The abscissa (T,) of pictures: time in s, or the coordinate of `over`."""
        return self.time if self.shown_over is None else self.shown_over.values

    def __repr__(self) -> str:
        if not self.contents.is_open:
            return f"Results of '{self.contents.path}', closed"
        from mbproj.results.views import as_text, rows

        return as_text(self.title, rows(self.status, self.time, self.names, self.attributes))

    def _repr_html_(self) -> str | None:
        """The HTML that a notebook shows; None for closed results, whose text it shows instead."""
        if not self.contents.is_open:
            return None
        from mbproj.results.views import as_html, rows

        return as_html(self.title, rows(self.status, self.time, self.names, self.attributes))

    def to_pandas(self) -> Any:
        """A DataFrame: the index is time in s, columns are (kind, name, quantity): `["markers"]["tip"]["position_x"]`.
        `attrs["units"]` has the unit of each column. Raises ImportError where pandas is not installed."""
        from mbproj.results.views import to_pandas

        return to_pandas(self.datasets, self.names, self.__getitem__)

    def to_xarray(self) -> Any:
        """A Dataset with the dimensions time, body, joint, marker, ..., all with their names as coordinates. Raises
        ImportError where xarray is not installed."""
        from mbproj.results.views import to_xarray

        about = {"title": self.title, "status": self.status}
        return to_xarray(self.datasets, self.names, self.__getitem__, about)

    @property
    def scene(self) -> Scene:
        """The scene of the run, read again. Raises InputError where its bodies are not those of the results."""
        from mbproj.results.provenance import scene_again

        return scene_again(self.scene_text, self.scene_path, self.overrides, self.names("bodies"), self.path)

    def _positions(self, symbol: str, chosen: Sequence[int]) -> Integers:
        """The numbers of columns in the file, for those in this view."""
        here = np.array(chosen, dtype=np.intp)
        return self._view.columns[symbol][here] if symbol in self._view.columns else here

    @property
    def status(self) -> str:
        """The status of the run: "running", "complete", "failed: cause" or "interrupted"."""
        return str(self.attributes["status"])

    @property
    def title(self) -> str:
        """The title of the scene."""
        return provenance.text(self.contents, "title")

    @property
    def scene_text(self) -> str:
        """The scene file as it was read."""
        return provenance.text(self.contents, "text")

    @property
    def scene_path(self) -> Path | None:
        """The path of the scene file; None for text from elsewhere."""
        return provenance.path(self.contents)

    @property
    def overrides(self) -> dict[str, str]:
        """The parameters that --set changed."""
        return provenance.overrides(self.contents)

    @property
    def settings(self) -> Settings:
        """The settings of the run, with all defaults filled in."""
        try:
            return settings_from(provenance.as_json(self.contents, "settings"))
        except UnfitSettings as error:
            raise self.contents.damaged("scene/settings", f"is wrong: {error}") from error

    @property
    def notes(self) -> tuple[Note, ...]:
        """The notes on the run and its scene, as `mbproj run` shows them."""
        return noting.read(self.attributes, self.path)

    @property
    def gravity(self) -> Vector:
        """The acceleration of gravity in m/s², global."""
        x, y, z = self.contents.array("scene/gravity", (3,)).tolist()
        if not isfinite(x + y + z):
            raise self.contents.damaged("scene/gravity", "is not finite")
        return x, y, z

    @property
    def trust(self) -> Trust | None:
        """The comparison of the run with a better solution: for all markers and samples, whatever was selected; None
        for a run that was not certified."""
        return trusting.read(self.contents)

    @property
    def certified(self) -> tuple[float, ...] | None:
        """The limits (m) for which the run was to be certified, even if that was cut off; None: it was not asked
        for."""
        return trusting.asked_limits(self.contents)

    @property
    def events(self) -> tuple[RecordedEvent, ...]:
        """The events of the run, in the order of time, whatever was selected; () in files of older programs."""
        return happening.read(self.contents)

    @property
    def event_times(self) -> Array:
        """The times of the events (n,), in s."""
        return np.array([event.time for event in self.events])

    @property
    def stored_loads(self) -> tuple[Load, ...]:
        """The largest loads of the whole run, as its file has them; () in files of older programs."""
        return largest_loads.read(self.contents)

    @property
    def checkpoint(self) -> Checkpoint | None:
        """The state from which the run can be continued, whatever was selected; None in files of older programs, or
        after a kill before the first one."""
        return restarting.read(self.contents)

    @property
    def verification(self) -> Verification | None:
        """The findings of `verify --store`; None where it was not run."""
        from mbproj.results.verification import read

        return read(self.contents)
