"""The facts of what is asked of results beside their contents: parts of `info`, and `compare-results`."""

from __future__ import annotations

from dataclasses import replace

from mbproj.report_schema import Fact
from mbproj.report_schema.check import NOT_UNIQUE

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
