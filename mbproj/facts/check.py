"""The facts of `mbproj check`: what it says of a scene at its assembled start."""

from __future__ import annotations

from mbproj.facts import Fact
from mbproj.facts.run import LENGTHS, RATES

_NONE_RUNS = "; null where none can run"
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
    Fact("elimination", "object | null", "1", "size of the equations and their fill; null where it is not known"),
    Fact("position_violation", "number", LENGTHS, "largest |C| at the start"),
    Fact("velocity_violation", "number", RATES, "largest |dC/dt| at the start"),
    Fact("moved_by", "array", "m, rad", "largest shift and turn of a body from the scene to the assembled start"),
    Fact("coordinates_at_start", "object", "m or rad", "by joint coordinate: value, speed and unit"),
    Fact("stops_at_start", "object", "m or rad", "by stop: gap, rate, unit, and whether it touches"),
    Fact("frictions_at_start", "object", "N or N m", "by dry friction: whether it sticks, its rate and force"),
    Fact("ropes_at_start", "object", "m, rad", "by rope: length and angles of wrap"),
    Fact("redundancy", "object", "", "sets of rows that depend on others, and what freedom they leave"),
    Fact("reactions_not_unique", "object", "", "by joint: reaction components that redundant joints can share at will"),
    Fact("massless_motions", "array", "", "motions without mass, each by body"),
    Fact("conditioning", "object", "1", "condition numbers, and the distance to a singular pose with a verdict"),
    Fact("fast_modes", "array", "Hz, 1/s, s", "fastest motions by forces and states, at the start"),
    Fact("stable_steps", "object", "s", "by integrator: largest stable step"),
    Fact("expectations", "array", "", "names of what the scene expects"),
    Fact("can_run", "boolean", "", "whether no problem keeps the scene from running"),
    Fact("problems", "array", "", "problems that do: message, hint and place"),
    Fact("adjusted_joints", "object", "m, rad", "by joint: shift and tilt that closed it"),
    Fact("notes", "array", "", "what may be a mistake: message, hint and place"),
)
