"""The facts of scenes and models beside their runs: `branches`, `curve`, `import`, `export`."""

from __future__ import annotations

from mbproj.report_schema import Fact

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
