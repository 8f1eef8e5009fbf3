"""The facts of `mbproj info`: the contents of a results file, its attributes, and how mbproj was built."""

from __future__ import annotations

from dataclasses import replace

from mbproj.facts import ALWAYS, Fact, shared
from mbproj.facts.run import ACCURACY, COUNTS, CREEP, FRICTIONS, LENGTHS, RATES, RECORDED, ROWS, TRUST

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
_PEAK = "joint with the largest violation, its value and time; null without joints"
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
    *shared(COUNTS, *(fact.key for fact in COUNTS), when=_SAMPLED),
    Fact("position_violation_max", "number | null", LENGTHS, "largest |C| of the samples", _SAMPLED),
    Fact("position_violation_time", "number", "s", "time of it", _SAMPLED),
    Fact("velocity_violation_max", "number | null", RATES, "largest |dC/dt| of the samples", _SAMPLED),
    Fact("velocity_violation_time", "number", "s", "time of it", _SAMPLED),
    *shared(RECORDED, "worst_joint", when=_SAMPLED),
    Fact("worst_length", "object | null", "m, s", _PEAK, _SAMPLED),
    Fact("worst_angle", "object | null", "rad, s", _PEAK, _SAMPLED),
    *shared(RECORDED, "energy_drift", "energy_drift_relative", when=_SAMPLED, unknown=True),
    Fact("scene", "string | null", "", "the scene file; null where the scene was text"),
    Fact("gravity", "array", "m/s^2", "acceleration of gravity, global axes"),
    Fact("reactions_not_unique", "object", "", "by joint: reaction components that redundant joints can share at will"),
    Fact("shared_at_contacts", "object", "s", "by contact: since when it shares a force arbitrarily"),
    Fact("settings", "object", "SI", "settings of the run with all defaults"),
    Fact("overrides", "object", "", "by name: values that --set changed"),
    Fact("attributes", "object", "", "attributes of the file"),
    Fact("names", "object", "", "names of bodies, markers, joints and coordinates"),
    Fact("stops", "object", "m or rad, N or N m, J", "by stop: least gap, largest force, impacts and what they took"),
    replace(FRICTIONS, when=ALWAYS),
    replace(CREEP, when=ALWAYS),
    Fact("events", "array", "s, N s or N m s, J", "events: time, name, kind, direction, impulse and energy"),
    replace(TRUST, when="after run --certify"),
    Fact("verification", "object", "", "result of each check", "after verify --store"),
    Fact("datasets", "object", "", "by path: shape and unit"),
)
#: All that `info --build` says.
BUILD = (
    Fact("mbproj", "string", "", "version of mbproj"),
    Fact("python", "string", "", "version of Python"),
    Fact("numpy", "string", "", "version of NumPy"),
    Fact("h5py", "string", "", "version of h5py"),
    Fact("formulations", "array", "", "formulations that can run here"),
    Fact("plugins", "object", "", "by kind: names of plugins and their modules"),
    Fact(
        "kernel",
        "object",
        "",
        "whether it is `built`, by what compiler and for which processor, or the `reason` and `advice`",
    ),
)
