"""The facts of designs and families: `fit`, `optimise`, `sensitivity`, `sweep`, `batch`, `verify`."""

from __future__ import annotations

from dataclasses import replace

from mbproj.report_schema import ALWAYS, Fact
from mbproj.report_schema.run import EXPECTATIONS, NOTES

#: What `fit` and `optimise` say.
DESIGN = (
    Fact("engine", "string", "", "search method"),
    Fact("why", "string", "", "why this one"),
    Fact(
        "slopes",
        "object | null",
        "",
        "how slopes were found; null where none were needed",
        fields=(
            Fact("by", "string", "", '"dual numbers" or "differences of runs"'),
            Fact("because", "string", "", 'why not by dual numbers; "" where by these'),
            Fact("apart", "map of string", "", "by measure with slopes by differences: why"),
        ),
    ),
    Fact("starts", "integer", "1", "number of searches, or of designs on the front"),
    Fact("reused", "integer", "1", "searches of an earlier command"),
    Fact("runs", "integer", "1", "number of runs"),
    Fact("value", "number | null", "by goal", "value that the search made smallest"),
    Fact("front", "array of array of number or null", "by goal", "goals of each design on the front"),
    Fact("rms", "number | null", "1", "root mean square of all residuals in standard deviations; null without any"),
    Fact(
        "numbers",
        "map of object",
        "",
        "by path: the number that was found",
        fields=(
            Fact("value", "number", "by number", "its value"),
            Fact("unit", "string", "", "its unit"),
            Fact("deviation", "number | null", "by number", "its standard deviation; null where nothing shows it"),
        ),
    ),
    Fact("goals", "map of number or null", "by goal", "goals by name"),
    Fact("constraints", "map of number or null", "by constraint", "by constraint: how far it is from its bound"),
    Fact("unseen", "array of string", "", "combinations of numbers that the measurements do not show"),
)
#: What `optimise --topologies` says.
TOPOLOGIES = (
    Fact("best", "string", "", "topology that was chosen"),
    Fact(
        "topologies",
        "array of object",
        "",
        "the topologies, the chosen one first",
        fields=(
            Fact("topology", "string", "", "its name"),
            Fact("rms", "number | null", "m or rad", "root mean square of what it is off by; null where it failed"),
            Fact("bodies", "integer", "1", "number of bodies"),
            Fact("cause", "string", "", 'why it failed; "" where it did not'),
        ),
    ),
)
#: What `sensitivity` says of each measure and number.
SENSITIVITY = (
    Fact("measure", "string", "", "what the scene expects, by name"),
    Fact("number", "string", "", "the number of the scene"),
    Fact("value", "number | null", "by measure", "value of the measure"),
    Fact("slope", "number | null", "by `unit`", "derivative by the number; null where it was left out"),
    Fact("uncertainty", "number | null", "by `unit`", "its error"),
    Fact("elasticity", "number | null", "1", "change of the measure in percent for one percent of the number"),
    Fact("unit", "string", "", "unit of the slope"),
    Fact("by", "string", "", "how the slope was found, or that it was left out"),
    Fact("because", "string", "", 'why not by dual numbers; "" where by these'),
)
#: What `sweep` says.
SWEEP = (
    Fact("cases", "integer", "1", "number of cases", at="whole"),
    Fact("computed", "integer", "1", "cases that were computed now"),
    Fact("by_arrays", "integer", "1", "of these those that were computed as arrays"),
    Fact("reused", "integer", "1", "cases of an earlier command"),
    Fact("failed", "integer", "1", "cases that failed"),
    Fact("left", "integer", "1", "cases that are left after an interruption"),
    Fact(
        "failures",
        "array of object",
        "",
        "failures by their message, most frequent first",
        fields=(
            Fact("message", "string", "", "the message"),
            Fact("status", "string", "", "how the cases ended"),
            Fact("count", "integer", "1", "number of cases"),
            Fact("first_case", "integer", "1", "the first of them"),
        ),
    ),
)
#: What a report for a pipeline says of a scene, too.
FORMULATION = Fact("formulation", "string | null", "", "coordinates that were computed in; null where it could not run")
_CODE = Fact("exit_code", "integer", "", "exit code")
#: What `batch` says.
BATCH = (
    _CODE,
    Fact("hold", "integer", "1", "scenes whose expectations all hold"),
    Fact("without_expectations", "integer", "1", "scenes that ran and expect nothing"),
    Fact("fall_short", "integer", "1", "scenes of which an expectation does not hold"),
    Fact("failed", "integer", "1", "scenes that could not run"),
    Fact("expectations", "integer", "1", "number of expectations"),
    Fact("expectations_hold", "integer", "1", "expectations that hold"),
    Fact("not_run", "array of string", "", "scenes that an interruption left"),
    Fact(
        "scenes",
        "array of object",
        "",
        "the scenes",
        fields=(
            Fact("scene", "string", "", "the scene file"),
            Fact("result", "string", "", "how it ended, in words"),
            _CODE,
            Fact("seconds", "number", "s", "time that it took"),
            FORMULATION,
            Fact("message", "string | null", "", "why it could not run; null where it could"),
            Fact("output", "string | null", "", "the results file; null without --keep"),
            replace(NOTES, when=ALWAYS),
            EXPECTATIONS,
        ),
    ),
)
_FINDING = (
    Fact("name", "string", "", "name of the check"),
    Fact("claim", "string", "", "what must hold"),
    Fact("measured", "number | null", "1", "relative error or order; null where it does not apply"),
    Fact("allowed", "number | null", "1", "what is allowed"),
    Fact("verdict", "string", "", '"passed", "failed" or "does not apply"'),
    Fact("remark", "string", "", "why"),
    Fact("at_least", "boolean", "", "whether the measured number must be at least the allowed one"),
)
#: What a verification found.
VERIFICATION = (
    Fact("holds", "boolean", "", "whether no check fails"),
    Fact("formulation", "string", "", "coordinates of its runs"),
    Fact("mbproj_version", "string", "", "version of mbproj", at="version"),
    Fact("checks", "array of object", "", "the checks", fields=_FINDING),
)
#: What `verify` says.
VERIFY = (Fact("scene", "string", "", "the scene file, as it was named"), *VERIFICATION)
