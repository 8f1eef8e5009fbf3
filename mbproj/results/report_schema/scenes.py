"""The facts of `mbproj check`: what it says of a scene at its assembled start."""

from __future__ import annotations

from mbproj.results.report_schema.facts import Fact, facts_of
from mbproj.results.report_schema.runs import LENGTHS, RATES

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


# --- The facts of scenes and models beside their runs -----------------------------------------------------------------
# `branches`, `curve`, `import`, `export`.


#: What has no counterpart in the scene or in the model.
SAID = Fact(
    "said",
    "array of object",
    "",
    "what has no counterpart",
    fields=(
        Fact("element", "string", "", "the element"),
        Fact("place", "string", "", 'file and line; "" where there is none'),
        Fact("what", "string", "", "what becomes of it"),
        Fact(
            "same_motion", "string", "", 'whether the motion is the same: "yes", "until then" or "no"', at="same.value"
        ),
    ),
)
#: How far a scene is from its model in the program that reads that.
AGREEMENT = Fact(
    "agreement",
    "object | null",
    "",
    "how far the scene is from MuJoCo's model, the largest of a body; null for URDF and SDF, and where it has no start",
    fields=(
        Fact("position", "number", "m", "at the start: distance of centres of mass"),
        Fact("angle", "number", "rad", "at the start: angle between orientations"),
        Fact("velocity", "number", "m/s", "at the start: difference of velocities of centres of mass"),
        Fact("angular_velocity", "number", "rad/s", "at the start: difference of angular velocities"),
        Fact("velocity_relative", "number", "1", "these as a part of the largest"),
        Fact("acceleration", "number", "m/s^2", "at all states: difference of accelerations"),
        Fact("angular_acceleration", "number", "rad/s^2", "at all states: difference of angular accelerations"),
        Fact("acceleration_relative", "number", "1", "these as a part of the largest"),
        Fact("states", "integer", "1", "states: the start, and random ones beside it"),
        Fact("without", "array of string", "", "what is left out on both sides"),
    ),
)
#: What `import` says.
IMPORT = (Fact("scene", "string | null", "", "the scene that was written; null on stdout"), AGREEMENT, SAID)
#: What `export` says of a scene as a model.
EXPORT = (Fact("files", "array of string", "", "files that were written"), SAID)
#: What `branches` says.
BRANCHES = (
    Fact("scene", "string", "", "the scene file, as it was named"),
    Fact(
        "assemblies",
        "array of object",
        "",
        "the assemblies, that of the start first",
        fields=(
            Fact("coordinates", "map of number", "m or rad", "joint coordinates by name"),
            Fact(
                "bodies",
                "map of object",
                "",
                "poses by body",
                fields=(
                    Fact("position", "array of number", "m", "centre of mass"),
                    Fact("orientation", "array of number", "1", "Euler parameters, scalar first"),
                ),
            ),
            Fact("found", "integer", "1", "random starts that led there"),
            Fact("distance_to_singular", "number", "1", "distance to a singular pose"),
            Fact("singular", "boolean", "", "whether assemblies meet here"),
            Fact("at_start", "boolean", "", "whether it is that of the start"),
        ),
    ),
    Fact("units", "map of string", "", "units of the joint coordinates by name"),
    Fact("starts", "integer", "1", "random starts"),
    Fact("closed", "integer", "1", "starts that led to an assembly"),
    Fact("share", "number", "1", "the share of the starts that an assembly draws which may have been missed"),
    Fact("missed", "number", "1", "probability that one was missed which draws a larger share"),
    Fact("written", "array of string", "", "scenes that were written"),
    Fact("picture", "string | null", "", "the picture; null without --picture"),
)
#: What `curve` says.
CURVE = (
    Fact("curve", "string", "", "name of the curve", at="name"),
    Fact("closed", "boolean", "", "whether it is closed"),
    Fact("length", "number", "m", "its length"),
    Fact("roller", "number", "m", "radius of the roller on it; 0 for none"),
    Fact("largest_pressure_angle", "number | null", "rad", "largest pressure angle; null for an open curve"),
    Fact("largest_roller", "map of number or null", "m", "by side: radius of the largest roller; null for any"),
    Fact("table", "map of array of number", "", "by heading with its unit: a column of the profile"),
)


# --- The facts of what rests and of small motions ---------------------------------------------------------------------
# `equilibrium`, `modes`, `linearize`.


_SCENE = Fact("scene", "string", "", "the scene file, as it was named")
_AT = Fact("at", "string", "", 'where it is: "start", "equilibrium", "steady", or a time', at="reference.where")
_TIME = Fact("time", "number", "s", "time of this state", at="reference.motion.t")
_BALANCED = Fact("balanced", "boolean", "", "whether forces balance there")
_LEFT = (
    Fact("force", "number", "N", "largest force on a body that nothing balances", at="force"),
    Fact("torque", "number", "N m", "largest torque on a body that nothing balances", at="torque"),
    Fact("relative", "number", "1", "the larger of both over the largest torque that acts"),
)
_RESTS, _FALLS = "where it rests", "where no equilibrium was found"
_COORDINATES = Fact("coordinates", "map of number", "m or rad", "joint coordinates by name", _RESTS, "coordinates")
_STABLE = Fact("stable", "boolean | null", "", "whether it is stable; null where this cannot be told", _RESTS, "stable")
#: What `equilibrium` says.
EQUILIBRIUM = (
    _SCENE,
    Fact("output", "string", "", "the results file with the pose", _RESTS),
    Fact("converged", "boolean", "", "whether an equilibrium was found"),
    *facts_of((_AT, _TIME), "at", "time", when=_RESTS),
    Fact(
        "residual",
        "object",
        "",
        "forces that are left",
        at="reference.imbalance",
        fields=(*facts_of(_LEFT, "force", "torque", when=_RESTS), *facts_of(_LEFT, "relative")),
    ),
    Fact("why", "string", "", "why there is none", _FALLS),
    Fact("steps", "integer", "1", "steps of the search", _RESTS, "steps"),
    _STABLE,
    Fact("unstable_along", "string | null", "", "motion along which it is not stable; null for none", _RESTS),
    Fact("neutral", "array of string", "", "motions along which it may rest anywhere", _RESTS, "neutral"),
    Fact("family", "integer", "1", "dimension of the family of equilibria that rolling leaves", _RESTS, "family"),
    _COORDINATES,
    Fact("states", "map of number", "by state", "states of elements by name", _RESTS, "states"),
    Fact(
        "reactions",
        "map of object",
        "",
        "by joint: its reaction on body 2, global axes",
        _RESTS,
        fields=(
            Fact("force", "array of number", "N", "force"),
            Fact("torque", "array of number", "N m", "torque"),
        ),
    ),
    Fact(
        "frictions",
        "map of object",
        "",
        "by dry friction: whether it sticks, its rate and force",
        _RESTS,
        "frictions",
        fields=FRICTION_AT_START,
    ),
    Fact("drive", "array of number", "N m", "torque that keeps a steady turn; empty at rest", _RESTS, "drive"),
    Fact(
        "others",
        "array of object",
        "",
        "other equilibria",
        _RESTS,
        fields=facts_of((_STABLE, _COORDINATES), "stable", "coordinates"),
    ),
    Fact("written", "string | null", "", "scene into which the pose was written; null without --write", _RESTS),
)
_GROWTH = "growth rates Re λ"
_ANGULAR = "angular frequencies Im λ"
_PHASORS = "[real, imaginary] part in the shape"
#: What `modes` says.
MODES = (
    _SCENE,
    Fact("output", "string", "", "the file of modes"),
    _AT,
    _TIME,
    Fact("degrees_of_freedom", "integer", "1", "number of degrees of freedom", at="freedom"),
    _BALANCED,
    Fact("imbalance", "object", "", "forces that are left", at="reference.imbalance", fields=_LEFT),
    Fact("frequencies_hz", "array of number", "Hz", "frequencies, the slowest first", at="frequencies"),
    Fact("damping_ratios", "array of number or null", "1", "damping ratios; null for λ = 0"),
    Fact("growth_rates", "array of number", "1/s", _GROWTH, at="eigenvalues.real"),
    Fact("angular_frequencies", "array of number", "rad/s", _ANGULAR, at="eigenvalues.imag"),
    Fact(
        "modes",
        "array of object",
        "",
        "the shapes",
        fields=(
            Fact("name", "string", "", "what takes most part in it"),
            Fact("kinetic_energy", "map of number or null", "1", "by body: its part of the kinetic energy"),
            Fact("potential_energy", "map of number or null", "1", "by force: its part of the potential energy"),
            Fact("coordinates", "map of array of number", "m or rad", f"by joint coordinate: {_PHASORS}"),
            Fact("states", "map of array of number", "by state", f"by state of an element: {_PHASORS}"),
        ),
    ),
    Fact("notes", "array of string", "", "notes"),
    Fact(
        "vary",
        "object",
        "",
        "the modes over a parameter, a row for each value",
        "with --vary",
        fields=(
            Fact("parameter", "string", "", "the parameter", at="name"),
            Fact("values", "array of number", "by parameter", "its values"),
            Fact("growth_rates", "array of array of number or null", "1/s", _GROWTH, at="eigenvalues.real"),
            Fact("angular_frequencies", "array of array of number or null", "rad/s", _ANGULAR, at="eigenvalues.imag"),
        ),
    ),
)
#: What `linearize` says.
LINEAR = (
    _SCENE,
    Fact("output", "string", "", "the file of the linear model"),
    _AT,
    _TIME,
    _BALANCED,
    *(Fact(name, "array of array of number", "by row and column", f"matrix {name}, row by row") for name in "ABCD"),
    *(
        fact
        for name in ("states", "inputs", "outputs")
        for fact in (
            Fact(name, "array of string", "", f"names of the {name}"),
            Fact(f"{name[:-1]}_units", "array of string", "", "their units"),
        )
    ),
)
