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

from mbproj.base.version import __version__

#: The public names by the module that defines them; `__init__.pyi` says the same to editors and type checkers.
HOMES: Mapping[str, str] = MappingProxyType(
    {
        "mbproj.base.errors": "InputError SimulationError",
        "mbproj.commands.python.check": "SceneCheck branches check",
        "mbproj.commands.python.files": "compare_results export largest_loads",
        "mbproj.commands.python.linear": "equilibria equilibrium linearize loads modes traces",
        "mbproj.commands.python.models": "Exported Imported export_model import_model new schema",
        "mbproj.commands.python.pictures": "paper",
        "mbproj.commands.python.results": "Results open_results",
        "mbproj.commands.python.run": "continue_run rerun run start",
        "mbproj.commands.python.studies": "Batch SweepTable batch compare fit optimise recommend sensitivity stability sweep threshold tradeoff verify",
        "mbproj.equations.assembly.assemble": "State assemble",
        "mbproj.equations.assembly.compiled": "compile_system",
        "mbproj.equations.rank.mobility": "mobility",
        "mbproj.equations.rank.uniqueness": "unique_components",
        "mbproj.model.compile.mechanism": "initial_guess",
        "mbproj.model.system": "System",
        "mbproj.motion.projection": "Projection register_projection",
        "mbproj.motion.report": "Report",
        "mbproj.motion.simulate": "simulate",
        "mbproj.motion.steppers.plugin": "register_integrator",
        "mbproj.results.notes": "Note",
        "mbproj.results.trust": "Trust",
        "mbproj.results.verification": "Verification",
        "mbproj.results.views": "Table",
        "mbproj.results.writer": "ResultsWriter",
        "mbproj.scene.blocks.plugin_forces": "register_element register_force",
        "mbproj.scene.parts": "Belt Body Bushing Cam CamContact Coupler Curve CurveContact CurveOnCurve Cylindrical DcMotor Differential Distance Expectation Fixed FlatContact FlatFollower Force Friction Gear Geneva HydraulicCylinder KnifeEdge LinearServo LinearSpringDamper Marker Maxwell Motion Planar PneumaticSpring PointInPlane PointOnLine Prismatic Rack Revolute RevoluteSpherical RollingBall RollingEllipsoid RollingOnCurve RollingOnLine RollingWheel Rope Screw Servo Simulation Slot SpaceSlot SpeedTorque Spherical SpringDamper Stop Telescope Torque TorsionMaxwell TorsionSpringDamper Universal",
        "mbproj.scene.scene": "Scene read_scene read_scene_text",
        "mbproj.scene.settings": "settings_to_run",
        "mbproj.show.figures.style": "figure_style",
        "mbproj.studies.certify": "simulate_certified",
        "mbproj.studies.compare": "Comparison",
        "mbproj.studies.measure.reference": "Reference reference",
        "mbproj.studies.measure.setting": "Setting",
        "mbproj.studies.measure.solve": "Mechanism Solution sample_times solve",
        "mbproj.studies.recommend": "Recommendation",
        "mbproj.studies.record": "Run record_run",
        "mbproj.studies.stability": "StabilityMap",
        "mbproj.studies.threshold": "ThresholdStudy threshold_study",
        "mbproj.studies.tradeoff": "Tradeoff",
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
