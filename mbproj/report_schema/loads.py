"""The facts of loads: `loads`, of actuators along a motion, and `info --loads`, of a run."""

from __future__ import annotations

from mbproj.report_schema import Fact

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
