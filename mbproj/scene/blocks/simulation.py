"""The `simulation` block: the field of each key, and the option of the command line that changes it."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from mbproj import registry
from mbproj.scene.fields.choices import Alternatives, NameChoice
from mbproj.scene.fields.containers import OneOf, Record
from mbproj.scene.fields.fields import Converted, Field, Flag, List
from mbproj.scene.fields.quantities import Integer, Number
from mbproj.scene.records import KeyPath

METHOD = NameChoice("projection method", lambda: registry.PROJECTIONS)
GAIN: Field[Any] = Number("1/s", above=0.0)

PROJECTION: Field[dict[str, Any]] = Alternatives(
    (
        Converted(METHOD, lambda method: {"method": method}),
        Record(
            "a projection",
            {
                "method": METHOD,
                "tolerance": Number(above=0.0),
                "test": NameChoice("test", lambda: registry.STOP_TESTS),
                "every": Integer(minimum=1),
                "threshold": Number(above=0.0),
                "position": Flag(),
                "velocity": Flag(),
                "max_iterations": Integer(minimum=1),
                "fallback": NameChoice("fallback", lambda: registry.FALLBACKS),
                "energy": Flag(),
                "momentum": Flag(),
                "alpha": Number(above=0.0),
                "gains": Alternatives((Converted(GAIN, lambda gain: (gain, gain)), List(GAIN, 2))),
            },
            dict,
        ),
    )
)

SIMULATION: Record[dict[str, Any]] = Record(
    "a simulation",
    {
        "duration": Number("s", above=0.0),
        "step": Number("s", above=0.0),
        "tolerance": Number(above=0.0, maximum=0.1),
        "integrator": NameChoice("integrator", registry.integrator_choices),
        "formulation": NameChoice("formulation", lambda: registry.FORMULATIONS),
        "kinematic": Flag(),
        "acceleration": NameChoice("acceleration", lambda: registry.ACCELERATIONS),
        "impact_law": NameChoice("impact law", lambda: registry.IMPACT_LAWS),
        "output_step": Number("s", above=0.0),
        "break_times": List(Number("s"), None, "times"),
        "start": NameChoice("start", lambda: registry.STARTS),
        "adjust_joints": Number("m", above=0.0),
        "projection": PROJECTION,
    },
    dict,
    choices=(OneOf(("step", "tolerance")),),
)

#: The options whose text may be a list, A,B.
LIST_OPTIONS = frozenset({"gains", "break_times"})
#: The path within the block of the value that an option changes, by the option's name in Python.
OPTIONS: Mapping[str, KeyPath] = MappingProxyType(
    {
        **{key: (key,) for key in SIMULATION.keys if key != "projection"},
        "projection": ("projection", "method"),
        "projection_tolerance": ("projection", "tolerance"),
        "projection_test": ("projection", "test"),
        "project_position": ("projection", "position"),
        "project_velocity": ("projection", "velocity"),
        "projection_fallback": ("projection", "fallback"),
        "energy_row": ("projection", "energy"),
        "momentum_row": ("projection", "momentum"),
        **{key: ("projection", key) for key in ("every", "threshold", "max_iterations", "alpha", "gains")},
    }
)
