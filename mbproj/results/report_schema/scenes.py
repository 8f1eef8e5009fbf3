"""The facts of `mbproj check`: what it says of a scene at its assembled start."""

from __future__ import annotations

from mbproj.report_schema import Fact
from mbproj.report_schema.run import LENGTHS, RATES

FRICTION_AT_START = (
    Fact("rate", "number", RATES, "rate of what it resists"),
    Fact("unit", "string", "", "unit of this without the s"),
    Fact("sticks", "boolean", "", "whether it sticks"),
    Fact("direction", "integer", "1", "1 or -1 where it slides along a line, 0 while nothing touches"),
    Fact("force", "number", "N or N m", "its force"),
    Fact("static", "number", "N or N m", "largest force at rest"),
)
_PROBLEM = (
    Fact("message", "string", "", "what is wrong"),
    Fact("hint", "string | null", "", "what to do; null where there is none"),
    Fact("file", "string", "", "the file", "where it has a place"),
    Fact("line", "integer | null", "1", "line in it", "where it has a place"),
    Fact("column", "integer | null", "1", "column in it", "where it has a place"),
)
_NONE_RUNS = "; null where none can run"
#: The reactions that the motion does not determine.
NOT_UNIQUE = Fact(
    "reactions_not_unique", "map of string", "", "by joint: components that redundant joints can share at will"
)
#: All that `check` says.
CHECK = (
    Fact("scene", "string", "", "the scene file, as it was named"),
    Fact("title", "string", "", "title of the scene"),
    Fact("coordinates", "integer", "1", "number of coordinates: seven for each body"),
    Fact("constraints", "integer", "1", "number of constraints, norm rows included"),
    Fact("rank", "integer | null", "1", "number of independent constraints; null for a large loop"),
    Fact("degrees_of_freedom", "integer | null", "1", "number of degrees of freedom; null where unknown"),
    Fact("positions", "integer | null", "1", "number of freedoms of the pose, more where bodies roll"),
    Fact("kinematic", "boolean", "", "whether motions drive it all, so that nothing is integrated"),
    Fact("formulation", "string | null", "", "coordinates to compute in" + _NONE_RUNS),
    Fact("formulation_why", "string | null", "", "the reason for this formulation" + _NONE_RUNS),
    Fact(
        "elimination",
        "object | null",
        "1",
        "size of the equations and their fill; null where it is not known",
        fields=(
            Fact("eliminated_bodies", "integer", "1", "bodies that are eliminated from the leaves"),
            Fact("core_bodies", "integer", "1", "bodies of the loops"),
            Fact("core_joints", "integer", "1", "joints of the loops"),
            Fact("core_numbers", "integer", "1", "numbers in the matrix of the loops"),
            Fact("core_fill", "integer", "1", "those among them that elimination adds"),
        ),
    ),
    Fact("position_violation", "number", LENGTHS, "largest |C| at the start"),
    Fact("velocity_violation", "number", RATES, "largest |dC/dt| at the start"),
    Fact(
        "moved_by",
        "array of number",
        "m, rad",
        "largest shift and turn of a body from the scene to the assembled start",
    ),
    Fact(
        "coordinates_at_start",
        "map of object",
        "",
        "by joint coordinate",
        fields=(
            Fact("value", "number", LENGTHS, "its value"),
            Fact("speed", "number", RATES, "its speed"),
            Fact("unit", "string", "", "unit of the value"),
        ),
    ),
    Fact(
        "stops_at_start",
        "map of object",
        "",
        "by stop",
        fields=(
            Fact("gap", "number", LENGTHS, "its gap"),
            Fact("rate", "number", RATES, "rate of the gap"),
            Fact("unit", "string", "", "unit of the gap"),
            Fact("touches", "boolean", "", "whether it touches"),
        ),
    ),
    Fact("frictions_at_start", "map of object", "", "by dry friction", fields=FRICTION_AT_START),
    Fact(
        "ropes_at_start",
        "map of object",
        "",
        "by rope",
        fields=(
            Fact("length", "number", "m", "length without what is on the drums at its ends"),
            Fact(
                "wraps",
                "array of object",
                "",
                "wraps on the circles between its ends",
                fields=(
                    Fact("place", "integer", "1", "number of the place on the path, from 1"),
                    Fact("body", "string", "", "body with the circle"),
                    Fact("angle", "number", "rad", "angle of the wrap"),
                ),
            ),
        ),
    ),
    Fact(
        "redundancy",
        "object",
        "",
        "rows that depend on others",
        fields=(
            Fact(
                "sets",
                "array of object",
                "",
                "sets of such rows",
                fields=(
                    Fact(
                        "rows",
                        "array of object",
                        "",
                        "rows of the set",
                        fields=(
                            Fact("kind", "string", "", "kind of what has the row"),
                            Fact("name", "string", "", "its name"),
                            Fact("holds", "string", "", "what the row holds"),
                        ),
                    ),
                    Fact("permanent", "boolean | null", "", "whether along the whole motion; null where unknown"),
                    Fact("contradictory", "boolean", "", "whether they contradict each other"),
                    Fact("velocity_residual", "number", RATES, "contradiction of the velocities"),
                    Fact("acceleration_residual", "number", "m/s^2 or rad/s^2", "contradiction of the accelerations"),
                ),
            ),
            Fact("freedom", "integer | null", "1", "freedom that the joints leave; null where unknown"),
            Fact("moves", "boolean | null", "", "whether a motion away from the pose was found; null where unknown"),
            Fact("bodies_of_loop_left_out", "integer", "1", "bodies of a loop that is too large for this; 0 for none"),
        ),
    ),
    NOT_UNIQUE,
    Fact("massless_motions", "array of map of string", "", "motions without mass, each by body"),
    Fact(
        "conditioning",
        "object",
        "",
        "how near the pose is to a singular one",
        fields=(
            Fact("as_written", "number | null", "1", "condition number of C_q in SI units; null for many bodies"),
            Fact("scaled", "number | null", "1", "the same with rows of unit length; null for many bodies"),
            Fact("distance", "number | null", "1", "distance to a singular pose; null without a loop"),
            Fact("owner", "string | null", "", "what has the rows that change most on the way there"),
            Fact("verdict", "string", "", "how near it is, in words"),
        ),
    ),
    Fact(
        "fast_modes",
        "array of object",
        "",
        "fastest motions by forces and states, at the start",
        fields=(
            Fact("forces", "array of string", "", "forces that make it"),
            Fact("states", "array of string", "", "states that make it"),
            Fact("bodies", "array of string", "", "bodies that move"),
            Fact("frequency", "number", "Hz", "frequency"),
            Fact("growth", "number", "1/s", "growth rate"),
            Fact("time_constant", "number | null", "s", "time constant"),
        ),
    ),
    Fact("stable_steps", "map of number or null", "s", "by integrator: largest stable step"),
    Fact("expectations", "array of string", "", "names of what the scene expects"),
    Fact("can_run", "boolean", "", "whether no problem keeps the scene from running"),
    Fact("problems", "array of object", "", "problems that do", fields=_PROBLEM),
    Fact(
        "adjusted_joints",
        "map of object",
        "",
        "by joint: what closed it",
        fields=(Fact("shift", "number", "m", "shift"), Fact("tilt", "number", "rad", "tilt")),
    ),
    Fact("notes", "array of object", "", "what may be a mistake", fields=_PROBLEM),
)
