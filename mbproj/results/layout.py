"""The layout of a results file: each dataset's path, shape after the time axis, unit, description and frame."""

from __future__ import annotations

from collections.abc import Mapping

from mbproj.base.dataclass import dataclass
from mbproj.results.report_schema.runs import COUNTS

FORMAT = "mbproj results"
SCHEMA_VERSION = 3

FLOAT, COUNT = "f8", "i8"
GLOBAL, BODY = "global axes", "body axes"


@dataclass(frozen=True)
class Dataset:
    """One array of the file, first axis time. `shape` are the other axes: numbers, or symbols in `SIZES`."""

    path: str
    shape: tuple[str | int, ...]
    unit: str
    description: str
    frame: str | None = None
    dtype: str = FLOAT

    @property
    def symbol(self) -> str | None:
        """The symbol for the number of columns ("n", "k", "nj", "nc"); None for a series."""
        return str(self.shape[0]) if self.shape else None


@dataclass(frozen=True)
class Constant:
    """An array of marks or numbers that do not change with time, written once where the run knows them. Its shape has
    symbols as in `Dataset`."""

    path: str
    shape: tuple[str | int, ...]
    description: str
    frame: str
    unit: str = "1"
    dtype: type = bool


@dataclass(frozen=True)
class NameList:
    """A list of names in the file: the symbol of its length, its path, a description."""

    symbol: str
    path: str
    description: str

    @property
    def group(self) -> str:
        """The group with the datasets of the named items."""
        return self.path.partition("/")[0]


#: Lists of names by kind; their lengths are the sizes that `Dataset.shape` names.
NAMES = {
    "bodies": NameList("n", "bodies/names", "names of the bodies"),
    "markers": NameList("k", "markers/names", "names of the markers"),
    "joints": NameList("nj", "joints/names", "names of the joints"),
    "coordinates": NameList("nc", "joints/coordinate_names", "names of the joint coordinates, joint.coordinate"),
    "coordinate_units": NameList("nc", "joints/coordinate_units", "unit of each joint coordinate, rad or m"),
    "forces": NameList(
        "nf",
        "forces/names",
        "names of the forces that act along a length or a joint coordinate; six columns of each bushing, .x to .rz; "
        "then reflected inertias, joint.coordinate.inertia",
    ),
    "force_units": NameList("nf", "forces/units", "unit of what each force acts along, rad or m"),
    "motions": NameList("nm", "motions/names", "names of the motions"),
    "motion_units": NameList("nm", "motions/units", "unit of the joint coordinate that each motion drives, rad or m"),
}

#: Lists of names by kind, which a file has only where the scene has such items.
LATER_NAMES = {
    "applied": NameList("na", "forces/applied_names", "names of the forces and torques of given components on bodies"),
    "applied_units": NameList("na", "forces/applied_units", "rad of a torque, m of a force"),
    "stops": NameList("ns", "stops/names", "names of the stops: joint.coordinate.low or .high, or that of the force"),
    "stop_units": NameList("ns", "stops/units", "unit of what each stop limits, rad or m"),
    "frictions": NameList("nr", "friction/names", "names of the dry frictions: the force's, force.coordinate, stop.1"),
    "friction_units": NameList("nr", "friction/units", "unit of what each dry friction resists, rad or m"),
    "states": NameList("nx", "states/names", "names of the states: a scene's own, and those of elements"),
    "state_units": NameList("nx", "states/units", "unit of each state"),
    "signals": NameList("nu", "signals/names", "names of the signals"),
    "signal_units": NameList("nu", "signals/units", "unit of each signal"),
    "tensions": NameList("nt", "ropes/names", "names of the portions of ropes, rope.tension_1"),
    "touching": NameList("nv", "curves/names", "names of the joints that follow curves"),
}
ALL_NAMES = {**NAMES, **LATER_NAMES}

#: The units of joint coordinates.
UNITS = ("rad", "m")

VIOLATION = "largest absolute value of the joint's rows of C"
REACTION = "the joint exerts on body 2 at the joint's point in body 2"
PER_COLUMN = "per column in joints/coordinate_units"
SINCE_START = "since the start of the run"

DATASETS: tuple[Dataset, ...] = (
    Dataset("time", (), "s", "time of the samples"),
    Dataset("bodies/position", ("n", 3), "m", "centre of mass", GLOBAL),
    Dataset("bodies/orientation", ("n", 4), "1", "Euler parameters, scalar first, body to global"),
    Dataset("bodies/velocity", ("n", 3), "m/s", "velocity of the centre of mass", GLOBAL),
    Dataset("bodies/angular_velocity", ("n", 3), "rad/s", "angular velocity", BODY),
    Dataset("bodies/acceleration", ("n", 3), "m/s^2", "acceleration of the centre of mass", GLOBAL),
    Dataset("bodies/angular_acceleration", ("n", 3), "rad/s^2", "angular acceleration", BODY),
    Dataset("markers/position", ("k", 3), "m", "position of the marker", GLOBAL),
    Dataset("markers/velocity", ("k", 3), "m/s", "velocity of the marker", GLOBAL),
    Dataset("markers/acceleration", ("k", 3), "m/s^2", "acceleration of the marker", GLOBAL),
    Dataset("joints/violation", ("nj",), "m or rad", VIOLATION),
    Dataset("joints/violation_length", ("nj",), "m", f"{VIOLATION} that are lengths"),
    Dataset("joints/violation_angle", ("nj",), "rad", f"{VIOLATION} that are angles"),
    Dataset("joints/reaction_force", ("nj", 3), "N", f"force that {REACTION}", GLOBAL),
    Dataset("joints/reaction_torque", ("nj", 3), "N m", f"torque that {REACTION}", GLOBAL),
    Dataset("joints/coordinate", ("nc",), "rad or m", f"joint coordinate, unwrapped; unit {PER_COLUMN}"),
    Dataset("joints/speed", ("nc",), "rad/s or m/s", f"rate of the joint coordinate; unit {PER_COLUMN}, per second"),
    Dataset("forces/coordinate", ("nf",), "rad or m", "length, unwrapped joint coordinate or deflection it acts along"),
    Dataset("forces/rate", ("nf",), "rad/s or m/s", "its rate"),
    Dataset("forces/force", ("nf",), "N m or N", "torque or force along it, positive where it drives it up"),
    Dataset("motions/value", ("nm",), "rad or m", "joint coordinate as the motion prescribes it"),
    Dataset("motions/rate", ("nm",), "rad/s or m/s", "its rate"),
    Dataset("motions/force", ("nm",), "N m or N", "driving torque or force, positive where it drives it up"),
    Dataset("diagnostics/position_violation", (), "m or rad", "largest absolute value of C, norm rows included"),
    Dataset("diagnostics/velocity_violation", (), "m/s or rad/s", "largest absolute value of the time derivative of C"),
    Dataset(
        "diagnostics/acceleration_violation",
        (),
        "m/s^2 or rad/s^2",
        "largest absolute value of the second time derivative of C",
    ),
    Dataset("diagnostics/kinetic_energy", (), "J", "kinetic energy"),
    Dataset("diagnostics/potential_energy", (), "J", "potential energy of gravity and springs"),
    Dataset("diagnostics/total_energy", (), "J", "kinetic and potential energy"),
    Dataset("diagnostics/work", (), "J", f"work W that forces and motions have done {SINCE_START}"),
    Dataset("diagnostics/dissipation", (), "J", f"energy D that dampers and friction have lost {SINCE_START}"),
    Dataset("diagnostics/energy_balance", (), "J", "E(t) - E(0) - W + D: zero but for errors of integration"),
    Dataset("diagnostics/step_size", (), "s", "step that led to the sample"),
    *(Dataset(f"diagnostics/{fact.key}", (), fact.unit, f"{fact.words} {SINCE_START}", dtype=COUNT) for fact in COUNTS),
)

#: The datasets of a scene with stops.
OF_STOPS: tuple[Dataset, ...] = (
    Dataset("stops/gap", ("ns",), "rad or m", "how far the mechanism is from the stop; negative where that gives way"),
    Dataset("stops/rate", ("ns",), "rad/s or m/s", "its rate"),
    Dataset("stops/force", ("ns",), "N m or N", "how hard the stop pushes, never negative; impacts are in /events"),
)


#: The datasets of a scene with dry friction that can stick.
OF_FRICTIONS: tuple[Dataset, ...] = (
    Dataset("friction/rate", ("nr",), "rad/s or m/s", "rate of the coordinate or along the tangent that it resists"),
    Dataset("friction/force", ("nr",), "N m or N", "torque or force along it, positive where it drives it up"),
    Dataset("friction/state", ("nr",), "1", "1 or -1 where it slides up or down, in a plane the cosine, 0: sticks"),
    Dataset("friction/dissipation", ("nr",), "J", f"energy that it has lost {SINCE_START}"),
)
#: The datasets of a scene with forces or torques of given components on bodies.
OF_APPLIED: tuple[Dataset, ...] = (
    Dataset("forces/applied", ("na", 3), "N m or N", "torque or force of given components on a body", GLOBAL),
    Dataset("forces/applied_power", ("na",), "W", "its power"),
)
#: The datasets of a scene with states, also those of elements.
OF_STATES = (Dataset("states/value", ("nx",), "any", "state; unit per column in states/units"),)
#: The datasets of a scene with signals.
OF_SIGNALS = (Dataset("signals/value", ("nu",), "any", "signal; unit per column in signals/units"),)
#: The datasets of a scene with ropes whose length is fixed or limited.
OF_ROPES = (Dataset("ropes/tension", ("nt",), "N", "tension of the portion, positive where it pulls"),)
#: The datasets of a scene with joints that follow curves.
OF_CURVES = (Dataset("curves/contact", ("nv", 3), "m", "place where the joint touches its curve", GLOBAL),)
#: All datasets that a file has only where the scene has such items.
LATER: tuple[Dataset, ...] = (*OF_STOPS, *OF_FRICTIONS, *OF_APPLIED, *OF_STATES, *OF_SIGNALS, *OF_ROPES, *OF_CURVES)


def datasets_for(sizes: Mapping[str, int]) -> tuple[Dataset, ...]:
    """The datasets of a file with these numbers of columns, by symbol; "time" is the first."""
    return (*DATASETS, *(dataset for dataset in LATER if sizes.get(dataset.symbol or "")))


UNIQUE = "whether the constraints determine this component; where not, redundant joints can share it in any proportion"
OPEN = "projection on the directions along which redundant joints can share it in any proportion"
CONSTANTS: tuple[Constant, ...] = (
    Constant("joints/reaction_force_unique", ("nj", 3), UNIQUE, GLOBAL),
    Constant("joints/reaction_torque_unique", ("nj", 3), UNIQUE, GLOBAL),
    Constant("joints/reaction_force_open", ("nj", 3, 3), OPEN, GLOBAL, dtype=float),
    Constant("joints/reaction_torque_open", ("nj", 3, 3), OPEN, GLOBAL, dtype=float),
)

#: The paths of these marks.
MARKS = frozenset(each.path for each in CONSTANTS)

#: The counters, cumulated since the start of the run.
COUNTERS = tuple(dataset.path for dataset in DATASETS if dataset.dtype == COUNT)


def trailing(dataset: Dataset | Constant, sizes: dict[str, int]) -> tuple[int, ...]:
    """The lengths of the axes after time (of all axes of a constant), with `sizes` for the symbols."""
    return tuple(sizes[axis] if isinstance(axis, str) else axis for axis in dataset.shape)
