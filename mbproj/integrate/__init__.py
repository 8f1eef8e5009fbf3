"""Integrates the equations of motion by one-step methods, with projection after the steps: `simulate`."""

from mbproj.integrate.reporting.report import Report, Worst
from mbproj.integrate.simulate import Recorder, simulate
from mbproj.registry import lazily

__all__ = ["Recorder", "Report", "Worst", "simulate"]

__getattr__ = lazily(
    __name__,
    {
        "events.leg": "kernel_tableau",
        "formulations.choice": "Choice choose",
        "formulations.compiled": "Compiled",
        "formulations.full": "FullFormulation",
        "formulations.invariants": "momenta_of",
        "formulations.planar": "InPlane",
        "formulations.reduced": "Reduced space_acceleration",
        "formulations.redundant_rows": "count_redundant settle_rows",
        "kernel_run": "FollowedSteps",
        "reporting.marks": "Keeping Mark Marks START",
        "reporting.report": "EnergyWatch",
        "steppers.order_conditions": "holds_up_to",
        "steppers.stability_region": "real_axis_limit",
        "steppers.tableau": "load_tableau tableau_of",
        "stops.start": "gaps_at_start refuse_penetration",
        "tangents": "numbers_of",
    },
)
