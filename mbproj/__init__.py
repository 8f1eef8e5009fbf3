"""mbproj: constrained spatial mechanisms in absolute coordinates, with constraints enforced by projection.

    results = run("five_bar.yaml", duration=2)          # all of it in one call

    scene = read_scene("five_bar.yaml")                 # what the user wrote          (InputError)
    system = compile_system(scene)                      # names -> arrays
    state = assemble(system, initial_guess(scene, system))   # a consistent start      (InputError)
    unique = unique_components(system, state)           # which components of reactions are unique
    with ResultsWriter("results.h5", scene, system.names.as_mapping(), unique) as recorder:
        report = simulate(system, state, settings_to_run(scene), recorder)   #        (SimulationError)

Names are imported when they are first used, so that `import mbproj` is cheap.
"""

from __future__ import annotations

import gc
from importlib import import_module
from typing import TYPE_CHECKING, Any

from mbproj.homes import HOMES
from mbproj.version import __version__

if TYPE_CHECKING:
    from mbproj.calls.again import continue_run, rerun
    from mbproj.calls.batch import Batch, batch
    from mbproj.calls.check.assemblies import branches
    from mbproj.calls.check.checked import SceneCheck, check
    from mbproj.calls.files import compare_results, export, largest_loads
    from mbproj.calls.linear import equilibria, equilibrium, linearize, modes, traces
    from mbproj.calls.loads import loads
    from mbproj.calls.models import Exported, Imported, export_model, import_model, new, schema
    from mbproj.calls.pictures import paper
    from mbproj.calls.run import run, start
    from mbproj.calls.studies import compare, recommend, stability, threshold, tradeoff, verify
    from mbproj.calls.sweep import SweepTable, fit, optimise, sensitivity, sweep
    from mbproj.dynamics import State, assemble, mobility, unique_components
    from mbproj.errors import InputError, SimulationError
    from mbproj.figures.style import figure_style
    from mbproj.integrate import Report, simulate
    from mbproj.integrate.steppers.plugin import register_integrator
    from mbproj.model import System, compile_system, initial_guess
    from mbproj.parts import (
        Belt,
        Body,
        Bushing,
        Cam,
        CamContact,
        Coupler,
        Curve,
        CurveContact,
        CurveOnCurve,
        Cylindrical,
        DcMotor,
        Differential,
        Distance,
        Expectation,
        Fixed,
        FlatContact,
        FlatFollower,
        Force,
        Friction,
        Gear,
        Geneva,
        HydraulicCylinder,
        KnifeEdge,
        LinearServo,
        LinearSpringDamper,
        Marker,
        Maxwell,
        Motion,
        Planar,
        PneumaticSpring,
        PointInPlane,
        PointOnLine,
        Prismatic,
        Rack,
        Revolute,
        RevoluteSpherical,
        RollingBall,
        RollingEllipsoid,
        RollingOnCurve,
        RollingOnLine,
        RollingWheel,
        Rope,
        Screw,
        Servo,
        Simulation,
        Slot,
        SpaceSlot,
        SpeedTorque,
        Spherical,
        SpringDamper,
        Stop,
        Telescope,
        Torque,
        TorsionMaxwell,
        TorsionSpringDamper,
        Universal,
    )
    from mbproj.projection import Projection
    from mbproj.projection.plugin import register_projection
    from mbproj.results import Results, ResultsWriter, Trust, Verification, open_results
    from mbproj.results.views.table import Table
    from mbproj.scene import Scene, read_scene, read_scene_text, settings_to_run
    from mbproj.scene.blocks.forces.plugin import register_element, register_force
    from mbproj.studies.certify.certified import simulate_certified
    from mbproj.studies.compare.comparison import Comparison
    from mbproj.studies.measure.mechanism import Mechanism
    from mbproj.studies.measure.reference import Reference, reference
    from mbproj.studies.measure.setting import Setting
    from mbproj.studies.measure.solve import Solution, sample_times, solve
    from mbproj.studies.recommend.recommendation import Recommendation
    from mbproj.studies.stability import StabilityMap
    from mbproj.studies.threshold.violation import ThresholdStudy, threshold_study
    from mbproj.studies.tradeoff.front import Tradeoff

__all__ = [
    "Batch",
    "Belt",
    "Body",
    "Bushing",
    "Cam",
    "CamContact",
    "Comparison",
    "Coupler",
    "Curve",
    "CurveContact",
    "CurveOnCurve",
    "Cylindrical",
    "DcMotor",
    "Differential",
    "Distance",
    "Expectation",
    "Exported",
    "Fixed",
    "FlatContact",
    "FlatFollower",
    "Force",
    "Friction",
    "Gear",
    "Geneva",
    "HydraulicCylinder",
    "Imported",
    "InputError",
    "KnifeEdge",
    "LinearServo",
    "LinearSpringDamper",
    "Marker",
    "Maxwell",
    "Mechanism",
    "Motion",
    "Planar",
    "PneumaticSpring",
    "PointInPlane",
    "PointOnLine",
    "Prismatic",
    "Projection",
    "Rack",
    "Recommendation",
    "Reference",
    "Report",
    "Results",
    "ResultsWriter",
    "Revolute",
    "RevoluteSpherical",
    "RollingBall",
    "RollingEllipsoid",
    "RollingOnCurve",
    "RollingOnLine",
    "RollingWheel",
    "Rope",
    "Scene",
    "SceneCheck",
    "Screw",
    "Servo",
    "Setting",
    "Simulation",
    "SimulationError",
    "Slot",
    "Solution",
    "SpaceSlot",
    "SpeedTorque",
    "Spherical",
    "SpringDamper",
    "StabilityMap",
    "State",
    "Stop",
    "SweepTable",
    "System",
    "Table",
    "Telescope",
    "ThresholdStudy",
    "Torque",
    "TorsionMaxwell",
    "TorsionSpringDamper",
    "Tradeoff",
    "Trust",
    "Universal",
    "Verification",
    "__version__",
    "assemble",
    "batch",
    "branches",
    "check",
    "compare",
    "compare_results",
    "compile_system",
    "continue_run",
    "equilibria",
    "equilibrium",
    "export",
    "export_model",
    "figure_style",
    "fit",
    "import_model",
    "initial_guess",
    "largest_loads",
    "linearize",
    "loads",
    "mobility",
    "modes",
    "new",
    "open_results",
    "optimise",
    "paper",
    "read_scene",
    "read_scene_text",
    "recommend",
    "reference",
    "register_element",
    "register_force",
    "register_integrator",
    "register_projection",
    "rerun",
    "run",
    "sample_times",
    "schema",
    "sensitivity",
    "settings_to_run",
    "simulate",
    "simulate_certified",
    "solve",
    "stability",
    "start",
    "sweep",
    "threshold",
    "threshold_study",
    "traces",
    "tradeoff",
    "unique_components",
    "verify",
]
#: The module of each public name. A name that `HOMES` does not list is a part of a scene.
_HOME_OF = dict.fromkeys(__all__, "mbproj.parts") | {name: home for home, names in HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mbproj' has no attribute '{name}'")
    collects = gc.isenabled()
    gc.disable()  # imported modules stay: a search for garbage among them would take 7 % of the time
    try:
        return getattr(import_module(_HOME_OF[name]), name)
    finally:
        if collects:
            gc.enable()


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
