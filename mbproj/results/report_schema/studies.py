"""The facts of studies of settings: `compare`, `tradeoff`, `threshold`, `stability`, `recommend`."""

from __future__ import annotations

from dataclasses import replace

from mbproj.results.report_schema.facts import ALWAYS, ANY_NAME, Fact, facts_of
from mbproj.results.report_schema.runs import COUNTS, EXPECTATIONS, LENGTHS, NOTES, RATES, ROWS, SETTING, SETTINGS

#: What all studies say.
EVERY_STUDY = (
    Fact("notes", "array of string", "", "notes"),
    Fact("files", "array of string", "", "files that were written"),
)
_UNTIL = Fact("until", "number", "s", "time of the end")
_OPTIONS = Fact("setting", "string", "", "options of mbproj run")
_FORMULATION = Fact("formulation", "string", "", 'coordinates of the run; "" where it failed')
_ERROR = Fact("error", "number | null", "m", "largest error of the points that count; null where it failed")
_VIOLATIONS = (
    Fact("position_violation", "number | null", LENGTHS, "largest |C|; null where it failed"),
    Fact("velocity_violation", "number | null", RATES, "largest |dC/dt|; null where it failed"),
)
_DRIFT = Fact("energy_drift", "number | null", "J", "largest error of the energy balance")
_UNTIMED = "; null where it was not timed"
#: The timings of a setting.
CPU_SECONDS = (
    Fact("cpu_seconds", "number | null", "s", "processor time of the steps of one run, median" + _UNTIMED),
    Fact("cpu_seconds_lowest", "number | null", "s", "the smallest of the timings" + _UNTIMED),
    Fact("cpu_seconds_highest", "number | null", "s", "the largest of the timings" + _UNTIMED),
)
_FAILURE = Fact("failure", "string", "", 'why the run did not get to its end; "" where it did')
#: What `compare` says of an energy row.
ENERGY_ROW = facts_of(
    ROWS,
    *("energy_row_given", "energy_row_moved", "rows_steps", "rows_left_near_rest", "rows_refused"),
    when="with an energy row",
    unknown=True,
)
#: The counts that `compare` says.
COMPARED = facts_of(
    COUNTS,
    *("steps", "evaluations", "projections", "projection_iterations", "velocity_iterations", "factorisations"),
    unknown=True,
)
#: The counts that `tradeoff` says.
COUNTED = facts_of(
    COUNTS,
    *("steps", "rejected_steps", "evaluations", "projections", "projection_iterations", "velocity_iterations"),
    "factorisations",
)
#: What `compare` says.
COMPARE = (
    _UNTIL,
    Fact(
        "entries",
        "array of object",
        "",
        "the settings",
        fields=(
            Fact("label", "string", "", "name of the setting"),
            _OPTIONS,
            _FORMULATION,
            *_VIOLATIONS,
            Fact("acceleration_violation", "number | null", "m/s^2 or rad/s^2", "largest |d²C/dt²|"),
            _ERROR,
            replace(_DRIFT, words="error of the energy balance at the end"),
            Fact("energy_drift_integrator", "number | null", "J", "part of the integrator in it"),
            Fact("energy_drift_projection", "number | null", "J", "part of the projection in it"),
            *ENERGY_ROW,
            *CPU_SECONDS,
            *COMPARED,
            _FAILURE,
        ),
    ),
)
#: The key of the error of a point.
OF_POINT = f"error_{ANY_NAME}"
#: What `tradeoff` varies.
VARIED = (
    *facts_of(SETTING, "projection", "integrator"),
    *facts_of(SETTINGS, "step", "tolerance"),
    *facts_of(SETTING, "every"),
    *facts_of(SETTING, "threshold", unknown=True),
)
#: What `tradeoff` says of each setting.
TRIALS = (
    _OPTIONS,
    *VARIED,
    _FORMULATION,
    _ERROR,
    Fact(OF_POINT, "number | null", "m", "largest error of this point; null where it failed"),
    *_VIOLATIONS,
    _DRIFT,
    Fact("warned", "boolean", "", "whether the run notes that its energy tells of a wrong motion"),
    *COUNTED,
    *CPU_SECONDS,
    Fact("first_cpu_seconds", "number | null", "s", "processor time of the first run, beside others"),
    Fact("on_front", "boolean", "", "whether no other timed setting is both cheaper and more accurate"),
    Fact("on_violation_front", "boolean", "", "whether none is both cheaper and better closed"),
    _FAILURE,
)
#: What `tradeoff` says.
TRADEOFF = (
    Fact("points", "array of string", "", "markers or bodies whose error counts"),
    _UNTIL,
    Fact("uncertain", "number", "m", "uncertainty of the reference", at="floor"),
    Fact("own", "integer | null", "1", "trial with the scene's own setting, from 0; null without one"),
    Fact("front", "array of integer", "1", "trials that no other timed one beats in cost and error"),
    Fact("compared", "array of integer", "1", "trials of the same steps with other projections"),
    Fact("trials", "array of object", "", "the settings", fields=TRIALS),
)
#: What `threshold` says.
THRESHOLD = (
    Fact("recommended", "integer | null", "1", "trial that is recommended, from 0; null for none"),
    _UNTIL,
    Fact(
        "trials",
        "array of object",
        "",
        "the thresholds: first none, with a projection after every step, last one that never projects",
        fields=(
            *facts_of(SETTING, "threshold", unknown=True),
            *facts_of(SETTING, "projection"),
            _ERROR,
            *_VIOLATIONS,
            _DRIFT,
            *facts_of(COUNTS, "steps", "projections", unknown=True),
            Fact("projections_saved", "number | null", "1", "part of the projections that it saves"),
            *CPU_SECONDS,
            Fact("recommended", "boolean", "", "whether it is recommended"),
            _FAILURE,
        ),
    ),
)
_STATES = '"holds", "degrades" or "fails"'
#: What `stability` says.
STABILITY = (
    Fact("vary", "string", "", "the quantity that is varied"),
    Fact("unit", "string", "", "its unit"),
    Fact("setting", "string", "", "the setting that all runs share, in words"),
    _UNTIL,
    Fact("own", "number", "by quantity", "value of the scene itself", at="span.own"),
    Fact("analytic", "number | null", "1/s", "limit by theory; null where there is none"),
    Fact(
        "methods",
        "map of object",
        "",
        "by method: its limits and all runs",
        fields=(
            Fact(
                "limits",
                "array of object",
                "",
                "the limits",
                at="changes",
                fields=(
                    Fact("value", "number", "by quantity", "value at the limit"),
                    Fact("below", "string", "", f"state below it: {_STATES}", at="below.state"),
                    Fact("above", "string", "", "state above it", at="above.state"),
                ),
            ),
            Fact(
                "points",
                "array of object",
                "",
                "the runs",
                fields=(
                    Fact("value", "number", "by quantity", "value of the quantity"),
                    Fact("state", "string", "", _STATES),
                    Fact("closure", "number | null", "1 or rad", "largest opening of a joint, in mechanism lengths"),
                    Fact("energy", "number | null", "1", "largest relative error of the energy balance"),
                    Fact("time", "number | null", "s", "time at which it first exceeded a limit; null where it holds"),
                    Fact("joint", "string | null", "", "joint that was open then"),
                    Fact("cause", "string", "", 'why it does not hold; "" where it does'),
                    Fact("ended", "boolean", "", "whether it came to its end"),
                ),
            ),
        ),
    ),
)
_MEASURED = (
    Fact("setting", "object", "", "the setting", fields=SETTING),
    Fact("point", "string", "", "point with the largest error"),
    replace(_ERROR, words="its error; null where it failed"),
    Fact("time", "number | null", "s", "time of this error"),
    Fact("evaluations", "number | null", "1", "evaluations of the accelerations"),
    Fact("seconds", "number | null", "s", "processor time of its steps"),
)
#: What `recommend` says.
RECOMMEND = (
    Fact("command", "string", "", "the command line that runs it"),
    Fact("goal", "number", "m", "error that was asked for"),
    Fact("points", "array of string", "", "markers or bodies whose error counts"),
    Fact("reached", "boolean", "", "whether the error is kept to the end"),
    Fact("until", "number", "s", "time until which it is kept"),
    Fact("wanted", "number", "s", "time until which it was to be kept"),
    Fact("best", "object", "", "the cheapest setting", fields=_MEASURED),
    Fact("contenders", "array of object", "", "settings of similar cost, the best one first", fields=_MEASURED),
    Fact("own", "object | null", "", "the scene's own setting; null where it was not measured", fields=_MEASURED),
    Fact("uncertain", "number", "m", "uncertainty of the reference"),
    Fact("reference", "string", "", "method of the reference", at="method"),
    Fact("check", "string", "", "method that it was checked by"),
    Fact("why", "string | null", "", "why the error is not kept to the end; null where it is"),
)


# --- The facts of designs and families --------------------------------------------------------------------------------
# `fit`, `optimise`, `sensitivity`, `sweep`, `batch`, `verify`.


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
#: What `sensitivity` says.
SENSITIVITY = (
    Fact(
        "slopes",
        "array of object",
        "",
        "each measure by each number",
        fields=(
            Fact("measure", "string", "", "what the scene expects, by name"),
            Fact("number", "string", "", "the number of the scene"),
            Fact("value", "number | null", "by measure", "value of the measure"),
            Fact("slope", "number | null", "by `unit`", "derivative by the number; null where it was left out"),
            Fact("uncertainty", "number | null", "by `unit`", "its error"),
            Fact("elasticity", "number | null", "1", "change of the measure in percent for one percent of the number"),
            Fact("unit", "string", "", "unit of the slope"),
            Fact("by", "string", "", "how the slope was found, or that it was left out"),
            Fact("because", "string", "", 'why not by dual numbers; "" where by these'),
        ),
    ),
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
