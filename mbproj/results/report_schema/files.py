"""The facts of `mbproj info`: the contents of a results file, its attributes, and how mbproj was built."""

from __future__ import annotations

from dataclasses import replace

from mbproj.results.report_schema.facts import ALWAYS, Fact, facts_of
from mbproj.results.report_schema.runs import (
    ACCURACY,
    COUNTS,
    CREEP,
    FRICTIONS,
    LENGTHS,
    NOTES,
    RATES,
    RECORDED,
    ROWS,
    SETTINGS,
    TRUST,
)
from mbproj.results.report_schema.scenes import NOT_UNIQUE
from mbproj.results.report_schema.studies import VERIFICATION

#: The attributes that a results file has from its start.
ROOT = (
    Fact("format", "string", "", 'kind of the file: "mbproj results"'),
    Fact("schema_version", "integer", "", "version of the layout"),
    Fact("date", "string", "", "when the run began, ISO 8601"),
    Fact("host", "string", "", "computer of the run"),
    Fact("pid", "integer", "", "number of its process"),
    Fact("mbproj_version", "string", "", "version of mbproj"),
    Fact("numpy_version", "string", "", "version of NumPy"),
    Fact("h5py_version", "string", "", "version of h5py"),
)
#: All attributes of a results file.
ATTRIBUTES = (*ROOT, *RECORDED, *ROWS, *ACCURACY)
_SAMPLED = "where the file has samples"


def _peak(kind: str, unit: str) -> Fact:
    """The joint that was open most."""
    return Fact(
        f"worst_{kind}",
        "object | null",
        "",
        f"largest violation of a joint in {kind}; null without joints",
        _SAMPLED,
        fields=(
            Fact("value", "number", unit, "its value"),
            Fact("time", "number", "s", "its time"),
            Fact("name", "string", "", "the joint"),
        ),
    )


#: All that `info` says of a results file.
INFO = (
    Fact("title", "string", "", "title of the scene"),
    Fact("file", "string", "", "the results file"),
    Fact("status", "string", "", '"complete", "running", "interrupted", or "failed: " and why'),
    Fact("partial", "boolean", "", "whether the run was killed or still goes on"),
    Fact("bodies", "integer", "1", "number of bodies"),
    Fact("joints", "integer", "1", "number of joints"),
    Fact("markers", "integer", "1", "number of markers"),
    Fact("coordinates", "integer", "1", "number of joint coordinates"),
    Fact("samples", "integer", "1", "number of samples"),
    Fact("start", "number", "s", "time of the first sample", _SAMPLED),
    Fact("end", "number", "s", "time of the last sample", _SAMPLED),
    *facts_of(COUNTS, *(fact.key for fact in COUNTS), when=_SAMPLED),
    Fact("position_violation_max", "number | null", LENGTHS, "largest |C| of the samples", _SAMPLED),
    Fact("position_violation_time", "number", "s", "time of it", _SAMPLED),
    Fact("velocity_violation_max", "number | null", RATES, "largest |dC/dt| of the samples", _SAMPLED),
    Fact("velocity_violation_time", "number", "s", "time of it", _SAMPLED),
    *facts_of(RECORDED, "worst_joint", when=_SAMPLED),
    _peak("length", "m"),
    _peak("angle", "rad"),
    *facts_of(RECORDED, "energy_drift", "energy_drift_relative", when=_SAMPLED, unknown=True),
    Fact("scene", "string | null", "", "the scene file; null where the scene was text", at="scene_path"),
    Fact("gravity", "array of number", "m/s^2", "acceleration of gravity, global axes"),
    NOT_UNIQUE,
    Fact("shared_at_contacts", "map of number", "s", "by contact: since when it shares a force arbitrarily"),
    replace(NOTES, when=ALWAYS),
    Fact("settings", "object", "", "settings of the run with all defaults", fields=SETTINGS),
    Fact("overrides", "map of string", "", "by name: values that --set changed"),
    Fact("attributes", "object", "", "attributes of the file"),
    Fact(
        "names",
        "object",
        "",
        "names of what is recorded",
        fields=tuple(
            Fact(kind, "array of string", "", f"names of {kind}")
            for kind in ("bodies", "markers", "joints", "coordinates")
        ),
    ),
    Fact(
        "stops",
        "map of object",
        "",
        "by stop: what it did",
        fields=(
            Fact("unit", "string", "", "unit of its gap"),
            Fact("least_gap", "number | null", LENGTHS, "least gap"),
            Fact("largest_force", "number | null", "N or N m", "largest force; null for a rigid stop"),
            Fact("impacts", "integer", "1", "number of impacts"),
            Fact("largest_impulse", "number", "N s or N m s", "largest impulse"),
            Fact("energy", "number", "J", "energy that impacts took"),
        ),
    ),
    replace(FRICTIONS, when=ALWAYS),
    replace(CREEP, when=ALWAYS),
    Fact(
        "events",
        "array of object",
        "",
        "events",
        fields=(
            Fact("time", "number", "s", "time of the event"),
            Fact("name", "string", "", "what had it"),
            Fact("kind", "string", "", "kind of the event"),
            Fact("direction", "integer", "1", "1 where it rises, -1 where it falls, 0 for one at a given time"),
            Fact("impulse", "number", "N s or N m s", "impulse of an impact"),
            Fact("energy", "number", "J", "energy that an impact took"),
        ),
    ),
    replace(TRUST, when="after run --certify"),
    Fact("verification", "object", "", "what verify found", "after verify --store", fields=VERIFICATION),
    Fact(
        "datasets",
        "map of object",
        "",
        "datasets by path",
        fields=(
            Fact("shape", "array of integer", "1", "shape"),
            Fact("unit", "string", "", "unit of the numbers"),
        ),
    ),
)
_BUILT, NOT_BUILT = "where it is built", "where it is not"
#: All that `info --build` says.
BUILD = (
    Fact("mbproj", "string", "", "version of mbproj"),
    Fact("python", "string", "", "version of Python"),
    Fact("numpy", "string", "", "version of NumPy"),
    Fact("h5py", "string", "", "version of h5py"),
    Fact("formulations", "array of string", "", "formulations that can run here"),
    Fact("plugins", "map of map of string", "", "by kind and name of a plugin: its module"),
    Fact(
        "kernel",
        "object",
        "",
        "the compiled kernel",
        fields=(
            Fact("built", "boolean", "", "whether it is there"),
            Fact("compiler", "string", "", "compiler", _BUILT),
            Fact("flags", "string", "", "options of the compiler", _BUILT),
            Fact("build_type", "string", "", "kind of the build", _BUILT),
            Fact("eigen", "string", "", "version of Eigen", _BUILT),
            Fact("instruction_set", "string", "", "processor that it is for", _BUILT),
            Fact("reason", "string", "", "why it is not there", NOT_BUILT),
            Fact("advice", "string | null", "", "what to do; null where it was not wanted", NOT_BUILT),
        ),
    ),
)


# --- The facts of what is asked of results beside their contents ------------------------------------------------------
# Parts of `info`, and `compare-results`.


_FILE = Fact("file", "string", "", "the results file")
#: What `info --steps` says.
STEPS = (
    _FILE,
    Fact(
        "steps",
        "array of object",
        "",
        "some of the smaller steps",
        fields=(
            Fact("time", "number", "s", "time of the step"),
            Fact("step", "number", "s", "its size"),
            Fact("error", "number | null", "1", "its error in tolerances; null where it cannot be made"),
            Fact("shares", "map of number", "1", "by body and state: its part in the square of the error"),
            Fact("reason", "string", "", 'what limits the step beside accuracy; "" for nothing'),
        ),
    ),
)
#: What `info --energy` says.
ENERGY = (
    _FILE,
    Fact("start", "number", "J", "energy at the start"),
    Fact("put_in", "number", "J", "energy that forces and motions put in"),
    Fact("dissipated", "number", "J", "energy that dampers took"),
    Fact("integrator", "number", "J", "energy that the integrator added"),
    Fact("projection", "number", "J", "energy that the projection added"),
    Fact("end", "number", "J", "energy at the end"),
)
_RESULTS, _SWEEP = "of a results file", "of the folder of a sweep"
#: What `info --check` says of a results file, or of the folder of a sweep.
SOUNDNESS = (
    replace(_FILE, when=_RESULTS),
    Fact("folder", "string", "", "the folder", _SWEEP),
    Fact("sound", "boolean", "", "whether nothing is wrong with it"),
    Fact("faults", "array of string", "", "what is wrong"),
    Fact("datasets", "integer", "1", "datasets that were read", _RESULTS),
    Fact("bytes", "integer", "1", "bytes of the samples", _RESULTS),
    Fact("rows", "integer", "1", "rows of the store", _SWEEP),
    Fact("files", "integer", "1", "results files that were read", _SWEEP),
    Fact("unguarded", "array of string", "", "what has no checksum, as an older mbproj wrote it"),
    Fact("damaged", "array of string", "", "results files that are damaged", _SWEEP),
)
#: What `info --thresholds` says of each threshold.
THRESHOLD_ROWS = (
    Fact("value", "number", "by `unit`", "its value"),
    Fact("unit", "string", "", "its unit"),
    Fact("used_by", "string", "", 'code that has it: "numpy", "kernel" or "both"'),
    Fact("why", "string", "", "what it decides"),
    Fact("source", "string", "", "where it comes from"),
)
_DIFFERENCE = (
    Fact("difference", "number", "by quantity", "difference"),
    Fact("of", "string | null", "", "name of what differs; null where it has none"),
    Fact("time", "number", "s", "time of it"),
)
#: What `compare-results` says.
COMPARISON = (
    Fact("first", "string", "", "the first results file"),
    Fact("second", "string", "", "the second results file"),
    Fact("same", "boolean", "", "whether the motion is the same, and as long"),
    Fact("samples", "array of integer", "1", "numbers of samples of both", at="counts"),
    Fact("samples_compared", "integer", "1", "number of times that both have", at="samples"),
    Fact("ends", "array of number", "s", "last times of both"),
    Fact(
        "parting",
        "object | null",
        "",
        "where they part first; null where they do not",
        fields=(
            Fact("quantity", "string", "", "quantity that differs"),
            *(replace(fact, at=f"first.{fact.key}") for fact in _DIFFERENCE),
        ),
    ),
    replace(NOT_UNIQUE, words=f"{NOT_UNIQUE.words}, which are not compared", at="left_out"),
    Fact("only_in_one", "map of array of string", "", "by kind: names that only one of them has", at="missing"),
    Fact(
        "quantities",
        "array of object",
        "",
        "the quantities",
        fields=(
            Fact("quantity", "string", "", "name of the quantity"),
            Fact("unit", "string", "", "its unit"),
            Fact("allowed", "number", "by `unit`", "difference that is allowed"),
            Fact("same", "boolean", "", "whether no difference is larger"),
            Fact("largest", "object", "", "largest difference", fields=_DIFFERENCE),
            Fact("first", "object | null", "", "first that is larger; null for none", fields=_DIFFERENCE),
        ),
    ),
)


# --- The facts of loads -----------------------------------------------------------------------------------------------
# `loads`, of actuators along a motion, and `info --loads`, of a run.


_UNIT = "by unit"
_PLACE_OF = Fact("place_of", "string | null", "", "coordinate that tells the place in the cycle; null without one")
_LOAD = (
    Fact("kind", "string", "", "kind of what is loaded"),
    Fact("name", "string", "", "its name"),
    Fact("quantity", "string", "", "what loads it"),
    Fact("unit", "string", "", "unit of the load"),
    Fact("largest", "number | null", _UNIT, "largest magnitude, of a scalar with its sign"),
    Fact("uncertainty", "number | null", _UNIT, "error that interpolation between samples may leave"),
    Fact("time", "number | null", "s", "time of the largest"),
    Fact("place", "number | null", "rad or m", "place in the cycle, an angle modulo a turn"),
    Fact("mean", "number | null", _UNIT, "mean over time"),
    Fact("rms", "number | null", _UNIT, "root mean square over time"),
    Fact("put_in", "number | null", "J", "work of a power above zero; null for other loads"),
    Fact("taken_out", "number | null", "J", "work of a power below zero; null for other loads"),
    Fact("unique", "boolean", "", "false where redundant joints can share it in any proportion"),
)
#: What `info --loads` says.
LARGEST_LOADS = (
    Fact("file", "string", "", "the results file"),
    _PLACE_OF,
    Fact(
        "loads",
        "array of object",
        "",
        "the loads",
        fields=(
            *_LOAD,
            Fact("above", "number", _UNIT, "level, a part of the largest", "with --level"),
            Fact("duration_above", "number", "s", "time above this level", "with --level"),
            Fact(
                "rainflow",
                "array of object",
                "",
                "rainflow count",
                "with --rainflow",
                fields=(
                    Fact("range", "number", _UNIT, "range of the swings"),
                    Fact("mean", "number", _UNIT, "their mean"),
                    Fact("cycles", "number", "1", "their number"),
                ),
            ),
        ),
    ),
)
_SAMPLES = "array of number or null"
#: What `loads` says.
ACTUATORS = (
    Fact("source", "string", "", "the results file or the scene"),
    Fact("degrees_of_freedom", "integer", "1", "number of degrees of freedom", at="freedom"),
    Fact("reached", "integer", "1", "degrees of freedom that the actuators reach", at="rank"),
    Fact("least_norm", "boolean", "", "whether forces of the least weighted sum of squares were taken", at="is_shared"),
    Fact("power_balance", "number", "1", "largest error of the power balance over the largest power", at="balance"),
    Fact("dead_centres", "array of number", "s", "times at which the actuators cannot move the mechanism", at="dead"),
    _PLACE_OF,
    Fact("largest", "array of object", "", "largest force and power of each actuator", fields=_LOAD),
    Fact(
        "smoothing",
        "array of object",
        "",
        "the motion against the data that was given",
        fields=(
            Fact("name", "string", "", "column of the data"),
            Fact("unit", "string", "", "its unit"),
            Fact("noise", "number", _UNIT, "root mean square by which the spline may change it"),
            Fact("largest", "number", _UNIT, "largest change"),
            Fact("time", "number", "s", "time of it"),
            Fact("rms", "number", _UNIT, "root mean square of the change"),
        ),
    ),
    Fact("time", "array of number", "s", "times of the samples"),
    Fact(
        "actuators",
        "map of object",
        "",
        "by actuator: its samples, null at a dead centre",
        fields=(
            Fact("unit", "string", "", "unit of its force"),
            Fact("weight", "number", "1", "its weight"),
            Fact("force", _SAMPLES, _UNIT, "force or torque"),
            Fact("rate", _SAMPLES, "m/s or rad/s", "rate of its coordinate"),
            Fact("power", _SAMPLES, "W", "power"),
        ),
    ),
)
