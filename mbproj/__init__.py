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
from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType

from mbproj.version import __version__

#: The public names by the module that defines them; `__init__.pyi` says the same to editors and type checkers.
HOMES: Mapping[str, str] = MappingProxyType(
    {
        "mbproj.api.again": "continue_run rerun",
        "mbproj.api.batch": "Batch batch",
        "mbproj.api.check.assemblies": "branches",
        "mbproj.api.check.checked": "SceneCheck check",
        "mbproj.api.files": "compare_results export largest_loads",
        "mbproj.api.linear": "equilibria equilibrium linearize modes traces",
        "mbproj.api.loads": "loads",
        "mbproj.api.models": "Exported Imported export_model import_model new schema",
        "mbproj.api.pictures": "paper",
        "mbproj.api.run": "run start",
        "mbproj.api.studies": "compare recommend stability threshold tradeoff verify",
        "mbproj.api.sweep": "SweepTable fit optimise sensitivity sweep",
        "mbproj.dynamics": "State assemble mobility unique_components",
        "mbproj.errors": "InputError SimulationError",
        "mbproj.figures.style": "figure_style",
        "mbproj.integrate": "Report simulate",
        "mbproj.integrate.steppers.plugin": "register_integrator",
        "mbproj.dynamics.assembly.adjust": "compile_system",
        "mbproj.model": "System initial_guess",
        "mbproj.parts": "Belt Body Bushing Cam CamContact Coupler Curve CurveContact CurveOnCurve Cylindrical DcMotor "
        "Differential Distance Expectation Fixed FlatContact FlatFollower Force Friction Gear Geneva "
        "HydraulicCylinder KnifeEdge LinearServo LinearSpringDamper Marker Maxwell Motion Planar PneumaticSpring "
        "PointInPlane PointOnLine Prismatic Rack Revolute RevoluteSpherical RollingBall RollingEllipsoid "
        "RollingOnCurve RollingOnLine RollingWheel Rope Screw Servo Simulation Slot SpaceSlot SpeedTorque "
        "Spherical SpringDamper Stop Telescope Torque TorsionMaxwell TorsionSpringDamper Universal",
        "mbproj.projection": "Projection",
        "mbproj.projection.plugin": "register_projection",
        "mbproj.api.results": "Results open_results",
        "mbproj.results": "ResultsWriter Trust Verification",
        "mbproj.results.notes": "Note",
        "mbproj.results.views.table": "Table",
        "mbproj.runs.record": "Run record_run",
        "mbproj.scene": "Scene read_scene read_scene_text settings_to_run",
        "mbproj.scene.blocks.forces.plugin": "register_element register_force",
        "mbproj.studies.certify.certified": "simulate_certified",
        "mbproj.studies.compare.comparison": "Comparison",
        "mbproj.studies.measure.mechanism": "Mechanism",
        "mbproj.studies.measure.reference": "Reference reference",
        "mbproj.studies.measure.setting": "Setting",
        "mbproj.studies.measure.solve": "Solution sample_times solve",
        "mbproj.studies.recommend.recommendation": "Recommendation",
        "mbproj.studies.stability": "StabilityMap",
        "mbproj.studies.threshold": "ThresholdStudy threshold_study",
        "mbproj.studies.tradeoff.result": "Tradeoff",
    }
)
_HOME_OF = {name: home for home, names in HOMES.items() for name in names.split()}
__all__ = ["__version__", *sorted(_HOME_OF)]


def __getattr__(name: str) -> object:
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
