"""The facts of settings: those of a run, with all defaults, and those of the runs of a study."""

from __future__ import annotations

from dataclasses import replace

from mbproj.facts import Fact

_ROWS = (
    Fact("energy", "boolean", "", "whether velocities also keep the energy balance"),
    Fact("momentum", "boolean", "", "whether velocities also keep the momenta that nothing changes"),
)
#: The options of a projection.
_PROJECTION = (
    Fact("method", "string", "", "projection method"),
    Fact("tolerance", "number | null", "m or rad", "violation at which a position counts as closed; null: by size"),
    Fact("test", "string", "", "what this tolerance is compared with"),
    Fact("every", "integer", "1", "steps from one projection to the next"),
    Fact("threshold", "number | null", "m or rad", "violation above which it projects; null: always"),
    Fact("position", "boolean", "", "whether positions are projected"),
    Fact("velocity", "boolean", "", "whether velocities are projected"),
    Fact("max_iterations", "integer", "1", "largest number of iterations of one projection"),
    Fact("alpha", "number | null", "1", "penalty factor; null where the method has none"),
    Fact("gains", "array of number | null", "1/s", "Baumgarte's gains α and β; null where the method has none"),
    Fact("fallback", "string", "", "method where the iterations fail"),
    *_ROWS,
)
_STEPS = (
    Fact("step", "number | null", "s", "fixed step; null with a tolerance"),
    Fact("tolerance", "number | null", "1", "error tolerance; null with fixed steps"),
    Fact("integrator", "string", "", "integration method"),
    Fact("formulation", "string", "", "coordinates to compute in"),
    Fact("acceleration", "string", "", "how accelerations are solved for"),
)
#: The settings of a run.
SETTINGS = (
    Fact("duration", "number | null", "s", "time of the end"),
    *_STEPS,
    Fact("impact_law", "string", "", "impact law of rigid stops"),
    Fact("output_step", "number | null", "s", "time between samples; null: every step"),
    Fact("break_times", "array of number", "s", "times at which steps end besides"),
    Fact("start", "string", "", "where the run begins"),
    Fact("adjust_joints", "number | null", "m", "most by which joints may move where loops do not close"),
    Fact("kinematic", "boolean | null", "", "whether it must be kinematic; null: where it can be"),
    Fact("projection", "object", "", "options of the projection", fields=_PROJECTION),
)
APPLIES = "where it applies"
_OF_PROJECTION = {"method": "projection", "tolerance": "projection_tolerance", "test": "projection_test"}
_OF_PROJECTION |= {"position": "project_position", "velocity": "project_velocity", "fallback": "projection_fallback"}
_OF_PROJECTION |= {fact.key: f"{fact.key}_row" for fact in _ROWS}


def _option(fact: Fact) -> Fact:
    """The fact as an option of `mbproj run`, which is left out where it is null."""
    kind = fact.kind.removesuffix(" | null")
    return replace(fact, kind=kind, when=fact.when if kind == fact.kind else APPLIES)


#: The setting of a run of a study, by the options of `mbproj run`.
SETTING = (
    *map(_option, _STEPS),
    *(replace(_option(fact), key=_OF_PROJECTION.get(fact.key, fact.key)) for fact in _PROJECTION),
)
