"""The facts of a run: what `mbproj run`, `rerun` and `continue` say, and what a results file keeps as attributes."""

from __future__ import annotations

from dataclasses import replace

from mbproj.base.settings import HOW, SettingEntry
from mbproj.base.settings import SETTINGS as ENTRIES
from mbproj.results.report_schema.facts import COMPLETE, Fact

#: The counts of a run's work, which the results file also has over time.
COUNTS = (
    Fact("steps", "integer", "1", "accepted steps", COMPLETE),
    Fact("rejected_steps", "integer", "1", "rejected steps", COMPLETE),
    Fact("evaluations", "integer", "1", "evaluations of the accelerations", COMPLETE),
    Fact("projections", "integer", "1", "projections", COMPLETE),
    Fact("projection_iterations", "integer", "1", "iterations on the position", COMPLETE),
    Fact("velocity_iterations", "integer", "1", "iterations on the velocity", COMPLETE),
    Fact("projection_failures", "integer", "1", "projections that failed", COMPLETE),
    Fact("projection_fallbacks", "integer", "1", "projections that took the fallback's metric", COMPLETE),
    Fact("factorisations", "integer", "1", "factorisations", COMPLETE),
)
LENGTHS, RATES = "m or rad", "m/s or rad/s"
#: What every run writes into its results file.
RECORDED = (
    Fact("scene", "string", "", "the scene file, as it was named"),
    Fact("output", "string", "", "the results file"),
    Fact("formulation", "string", "", "coordinates that were computed in: full, reduced or planar", COMPLETE),
    Fact("formulation_why", "string", "", "the reason for this formulation", COMPLETE, "why"),
    Fact("projection", "string", "", "projection method", COMPLETE, "settings.projection.method"),
    Fact("integrator", "string", "", "integration method", COMPLETE, "settings.integrator"),
    Fact("degrees_of_freedom", "integer", "1", "number of degrees of freedom", COMPLETE),
    Fact("kinematic", "boolean", "", "whether motions drive it all, so that nothing is integrated", COMPLETE),
    Fact("redundant_rows", "integer", "1", "constraints in space that follow from the others", COMPLETE),
    *COUNTS,
    Fact("integration_seconds", "number", "s", "time that the steps took", COMPLETE),
    Fact("recording_seconds", "number", "s", "time that observing and writing samples took", COMPLETE),
    Fact("total_seconds", "number", "s", "time of the run from its compiled scene to its file", COMPLETE),
    Fact(
        "position_violation_max", "number", LENGTHS, "largest |C| over all steps", COMPLETE, "position_violation.value"
    ),
    Fact(
        "velocity_violation_max",
        "number",
        RATES,
        "largest |dC/dt| over all steps",
        COMPLETE,
        "velocity_violation.value",
    ),
    Fact("position_violation_floor", "number", LENGTHS, "|C| by round-off alone", COMPLETE, "position_floor"),
    Fact("velocity_violation_floor", "number", RATES, "|dC/dt| by round-off alone", COMPLETE, "velocity_floor"),
    Fact("worst_joint", "string | null", "", "joint that was open most; null without joints", COMPLETE),
    Fact("energy_drift", "number", "J", "largest error of the energy balance", COMPLETE),
    Fact("energy_drift_relative", "number", "1", "this over the largest kinetic energy + |ΔV|", COMPLETE),
    Fact("energy_put_in", "number", "J", "work of forces and motions", COMPLETE, "energy.work"),
    Fact(
        "energy_dissipated",
        "number",
        "J",
        "energy that dampers, friction and impacts took",
        COMPLETE,
        "energy.dissipation",
    ),
    Fact(
        "energy_numerical",
        "number",
        "J",
        "energy that integrator and projection put in; negative where they took some",
        COMPLETE,
        "energy.numerical",
    ),
    Fact("stiffness", "string", "", 'which force is too stiff for the step, and what to do; "" for none', COMPLETE),
    Fact("events", "integer", "1", "times at which a step ended at an event", COMPLETE),
    Fact("passed_over", "string", "", 'edges of laws that fixed steps passed over; "" for none', COMPLETE, "passed"),
    Fact("halved", "string", "", 'why fixed steps were halved; "" where none was', COMPLETE),
    Fact(
        "shared_at_contacts",
        "string",
        "",
        'contacts that shared a force arbitrarily, since when; "" for none',
        COMPLETE,
        "shared",
    ),
    Fact("decided_by_shares", "string", "", 'stops whose arbitrary shares decide the motion; "" for none', COMPLETE),
    Fact("methods", "string", "", 'methods that `integrator: auto` took, and when; "" for others', COMPLETE),
    Fact("status", "string", "", '"complete", "interrupted", or "failed: " and why'),
)
_KEPT = "with --energy-row or --momentum-row"
#: What a run with rows for energy or momenta writes besides.
ROWS = (
    Fact("rows_steps", "integer", "1", "steps at which these rows were closed", _KEPT, "rows.steps"),
    Fact("rows_left_near_rest", "integer", "1", "steps that were left alone near rest", _KEPT, "rows.rest"),
    Fact("rows_refused", "integer", "1", "steps at which the rows asked for too much", _KEPT, "rows.refused"),
    Fact("rows_momenta", "integer", "1", "momenta that are kept", _KEPT, "rows.momenta"),
    Fact("energy_row_given", "number", "J", "energy that the rows added in sum", _KEPT, "rows.added"),
    Fact("energy_row_furthest", "number", "J", "largest absolute value of that sum", _KEPT, "rows.furthest"),
    Fact("energy_row_moved", "number", "J", "sum of the absolute values of what they added", _KEPT, "rows.moved"),
    Fact(
        "rows_largest_correction",
        "number",
        "1",
        "largest change of the velocities, as a part of these",
        _KEPT,
        "rows.largest",
    ),
)
_CHOSEN = "with --accuracy"
#: What `run --accuracy` writes besides.
ACCURACY = (
    Fact("accuracy", "number", "m", "error that was asked for", _CHOSEN),
    Fact("accuracy_error", "number", "m", "error of the setting that was chosen", _CHOSEN),
    Fact("accuracy_uncertainty", "number", "m", "uncertainty of that error", _CHOSEN),
)
_RUBS = "where the scene has dry friction"
_HORIZON = "array of number or null"
TRUST = Fact(
    "trust",
    "object",
    "",
    "trust horizons",
    "with --certify",
    fields=(
        Fact("solution", "string", "", "the solution that the run was compared with"),
        Fact("remark", "string | null", "", "a remark on it; null for none"),
        Fact("limits", "array of number", "m", "the errors that are asked for"),
        Fact(
            "points",
            "map of object",
            "",
            "by marker or body",
            fields=(
                Fact("horizon", _HORIZON, "s", "by limit: when the error exceeds it; null for never"),
                Fact("horizon_low", _HORIZON, "s", "by limit: earliest time of it"),
                Fact("horizon_high", _HORIZON, "s", "by limit: latest time of it"),
                Fact("growth_rate", "number | null", "1/s", "rate of an error that grows exponentially"),
                Fact("growth_power", "number | null", "1", "power of an error that grows as one of t"),
                Fact("growth_law", "string | null", "", '"exponential" or "power"; null where unknown'),
                Fact("largest_error", "number", "m", "largest error"),
                Fact("largest_uncertainty", "number", "m", "largest uncertainty of it"),
            ),
        ),
    ),
)
_RESISTS = Fact("unit", "string", "", "unit of the motion that it resists")
FRICTIONS = Fact(
    "frictions",
    "map of object",
    "",
    "by dry friction: what it did",
    _RUBS,
    fields=(
        _RESISTS,
        Fact("sticks", "integer", "1", "times that it began to stick"),
        Fact("slips", "integer", "1", "times that it slipped"),
        Fact("turns", "integer", "1", "times that sliding turned"),
        Fact("sticking_seconds", "number | null", "s", "time that it stuck"),
        Fact("sticking_part", "number | null", "1", "part of the time that it stuck"),
        Fact("largest_force", "number | null", "N or N m", "largest force"),
        Fact("energy", "number | null", "J", "energy that it took"),
    ),
)
CREEP = Fact(
    "creep",
    "map of object",
    "",
    "by regularised friction: how far it crept",
    _RUBS,
    fields=(
        _RESISTS,
        Fact("width", "number", "m/s or rad/s", "width of the regularisation"),
        Fact("seconds", "number", "s", "time that it crept"),
        Fact("creep", "number", LENGTHS, "how far it crept"),
    ),
)
NOTES = Fact(
    "notes",
    "array of object",
    "",
    "what its reader should know of the run",
    COMPLETE,
    fields=(
        Fact("text", "string", "", "the note"),
        Fact("place", "string", "", 'place in the scene, file:line:column; "" where it has none'),
        Fact("doubts_motion", "boolean", "", "whether the motion may be wrong"),
    ),
)
_BOUND = "null where it is a value"
_OVER, _BETWEEN = "where it is a ratio", "where it is a transmission angle"
_VALUES = "number | array of number | null"
EXPECTATIONS = Fact(
    "expectations",
    "array of object",
    "",
    "what the scene expects, and what was measured",
    COMPLETE,
    fields=(
        Fact("name", "string", "", "name of the expectation", at="expectation.name"),
        Fact("of", "string", "", "kind of what is measured", at="expectation.of"),
        Fact("item", "string", "", "name of what is measured", at="expectation.item"),
        Fact("quantity", "string", "", "quantity that is measured", at="expectation.quantity"),
        Fact("component", "string | null", "", "component of it; null for all"),
        Fact("unit", "string", "", "unit of the measured values", at="expectation.unit"),
        Fact(
            "at",
            "number | string | object",
            "s",
            'time, "end" or another moment, or a coordinate and its value',
            at="expectation.at",
            fields=(
                Fact("coordinate", "string", "", "joint coordinate"),
                Fact("value", "number", "by unit", "value that it passes"),
                Fact("unit", "string", "", "unit of this value"),
            ),
        ),
        Fact("over", "string", "", "input of the ratio", _OVER),
        Fact("between", "array of string", "", "markers of the angle", _BETWEEN),
        Fact("time", "number | null", "s", "time of the sample; null where there is none"),
        Fact("measured", _VALUES, "by unit", "what was measured"),
        Fact("value", _VALUES, "by unit", "what is expected; null where it is a bound"),
        Fact("error", "number | null", "by unit", "difference of both"),
        Fact("tolerance", "number | null", "by unit", "what is allowed of it", at="expectation.tolerance"),
        Fact("below", "number | null", "by unit", f"upper bound; {_BOUND}", at="expectation.below"),
        Fact("above", "number | null", "by unit", f"lower bound; {_BOUND}", at="expectation.above"),
        Fact("checked", "boolean", "", "whether it could be checked"),
        Fact("unique", "boolean", "", "false where joints or contacts can share it in any proportion"),
        Fact("holds", "boolean", "", "whether it holds"),
        Fact("source", "string", "", "where the expected value comes from", at="expectation.source"),
    ),
)
#: All that a run says.
RUN = (
    *RECORDED,
    *ROWS,
    *ACCURACY,
    NOTES,
    TRUST,
    FRICTIONS,
    CREEP,
    Fact(
        "ropes_that_push",
        "map of object",
        "",
        "by rope: its largest push",
        "where a rope pushes",
        fields=(Fact("push", "number", "N", "largest push"), Fact("time", "number", "s", "time of it")),
    ),
    EXPECTATIONS,
)


# --- The facts of settings --------------------------------------------------------------------------------------------
# Those of a run, with all defaults, and those of the runs of a study.


_KINDS = {"str": "string", "float": "number", "int": "integer", "bool": "boolean"}
APPLIES = "where it applies"


def _fact(entry: SettingEntry) -> Fact:
    """What a report of a run says of a setting."""
    kind = "array of number" if entry.kind.startswith("tuple") else _KINDS[entry.kind]
    words = entry.help[:1].lower() + entry.help[1:].rstrip(".")
    if entry.type != entry.kind:
        kind, words = f"{kind} | null", f"{words}; null: {entry.null}"
    unit = {"int": "1", "str": ""}.get(entry.kind, entry.takes)
    return Fact(entry.key, kind, unit, words)


def _option(entry: SettingEntry) -> Fact:
    """The setting as an option of `mbproj run`, which is left out where it is null."""
    fact = _fact(entry)
    kind = fact.kind.removesuffix(" | null")
    words = fact.words.partition("; null: ")[0]
    return replace(fact, key=entry.name, kind=kind, words=words, when=fact.when if kind == fact.kind else APPLIES)


_TOP, _PROJECTION = (tuple(_fact(each) for each in ENTRIES.values() if len(each.path) == depth) for depth in (1, 2))
#: The settings of a run.
SETTINGS = (*_TOP, Fact("projection", "object", "", "options of the projection", fields=_PROJECTION))
#: The setting of a run of a study, by the options of `mbproj run`.
SETTING = tuple(_option(each) for each in ENTRIES.values() if each.decides == HOW)
