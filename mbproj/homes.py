"""The modules that define the public names of the package."""

from collections.abc import Mapping
from types import MappingProxyType

#: The public names by the module that defines them, without the parts of a scene, which `mbproj.parts` defines.
HOMES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "mbproj.calls.again": ("continue_run", "rerun"),
        "mbproj.calls.batch": ("Batch", "batch"),
        "mbproj.calls.check.assemblies": ("branches",),
        "mbproj.calls.check.checked": ("SceneCheck", "check"),
        "mbproj.calls.files": ("compare_results", "export", "largest_loads"),
        "mbproj.calls.linear": ("equilibria", "equilibrium", "linearize", "modes", "traces"),
        "mbproj.calls.loads": ("loads",),
        "mbproj.calls.models": ("Exported", "Imported", "export_model", "import_model", "new", "schema"),
        "mbproj.calls.pictures": ("paper",),
        "mbproj.calls.run": ("run", "start"),
        "mbproj.calls.studies": ("compare", "recommend", "stability", "threshold", "tradeoff", "verify"),
        "mbproj.calls.sweep": ("SweepTable", "fit", "optimise", "sensitivity", "sweep"),
        "mbproj.dynamics": ("State", "assemble", "mobility", "unique_components"),
        "mbproj.errors": ("InputError", "SimulationError"),
        "mbproj.figures.style": ("figure_style",),
        "mbproj.integrate": ("Report", "simulate"),
        "mbproj.integrate.steppers.plugin": ("register_integrator",),
        "mbproj.model": ("System", "compile_system", "initial_guess"),
        "mbproj.projection": ("Projection",),
        "mbproj.projection.plugin": ("register_projection",),
        "mbproj.results": ("Results", "ResultsWriter", "Trust", "Verification", "open_results"),
        "mbproj.results.views.table": ("Table",),
        "mbproj.scene": ("Scene", "read_scene", "read_scene_text", "settings_to_run"),
        "mbproj.scene.blocks.forces.plugin": ("register_element", "register_force"),
        "mbproj.studies.certify.certified": ("simulate_certified",),
        "mbproj.studies.compare.comparison": ("Comparison",),
        "mbproj.studies.measure.mechanism": ("Mechanism",),
        "mbproj.studies.measure.reference": ("Reference", "reference"),
        "mbproj.studies.measure.setting": ("Setting",),
        "mbproj.studies.measure.solve": ("Solution", "sample_times", "solve"),
        "mbproj.studies.recommend.recommendation": ("Recommendation",),
        "mbproj.studies.stability": ("StabilityMap",),
        "mbproj.studies.threshold.violation": ("ThresholdStudy", "threshold_study"),
        "mbproj.studies.tradeoff.front": ("Tradeoff",),
    }
)
