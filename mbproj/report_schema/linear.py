"""The facts of what rests and of small motions: `equilibrium`, `modes`, `linearize`."""

from __future__ import annotations

from mbproj.report_schema import Fact, facts_of
from mbproj.report_schema.check import FRICTION_AT_START

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
