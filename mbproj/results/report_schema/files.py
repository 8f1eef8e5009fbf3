"""The facts of `mbproj info`: the contents of a results file, its attributes, and how mbproj was built."""

from __future__ import annotations

from dataclasses import replace

from mbproj.report_schema import ALWAYS, Fact, facts_of
from mbproj.report_schema.check import NOT_UNIQUE
from mbproj.report_schema.designs import VERIFICATION
from mbproj.report_schema.run import ACCURACY, COUNTS, CREEP, FRICTIONS, LENGTHS, NOTES, RATES, RECORDED, ROWS, TRUST
from mbproj.report_schema.settings import SETTINGS

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
