"""mbproj: constrained spatial mechanisms in absolute coordinates, with constraints enforced by projection.

    results = run("five_bar.yaml", duration=2)          # all of it in one call

    scene = read_scene("five_bar.yaml")                 # what the user wrote          (InputError)
    system = compile_system(scene)                      # names -> arrays
    state = assemble(system, initial_guess(scene, system))   # a consistent start      (InputError)
    unique = unique_components(system, state)           # which reactions joints do not share at will
    with ResultsWriter("results.h5", scene, system.names.as_mapping(), unique) as recorder:
        report = simulate(system, state, settings_to_run(scene), recorder)   #        (SimulationError)

Names are imported when they are first used, so that `import mbproj` is cheap.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mbproj.version import __version__

if TYPE_CHECKING:
    from mbproj.calls.linear import equilibrium, linearize, modes
    from mbproj.calls.run import run
    from mbproj.calls.sweep import sweep
    from mbproj.dynamics import State, assemble, mobility, unique_components
    from mbproj.errors import InputError, SimulationError
    from mbproj.integrate import Report, simulate
    from mbproj.model import System, compile_system, initial_guess
    from mbproj.projection import Projection
    from mbproj.projection.plugin import register_projection
    from mbproj.results import Results, ResultsWriter, Trust, Verification, open_results
    from mbproj.scene import Scene, read_scene, read_scene_text, settings_to_run
    from mbproj.studies.certify.certified import simulate_certified
    from mbproj.studies.compare.comparison import Comparison, compare
    from mbproj.studies.measure.mechanism import Mechanism
    from mbproj.studies.measure.reference import Reference, reference
    from mbproj.studies.measure.setting import Setting
    from mbproj.studies.measure.solve import Solution, sample_times, solve
    from mbproj.studies.recommend.recommendation import Recommendation, recommend
    from mbproj.studies.stability import StabilityMap, stability
    from mbproj.studies.threshold.violation import ThresholdStudy, threshold_study
    from mbproj.studies.tradeoff.front import Tradeoff, tradeoff
    from mbproj.studies.verify import verify

_HOMES = {
    "mbproj.calls.linear": ("equilibrium", "linearize", "modes"),
    "mbproj.calls.run": ("run",),
    "mbproj.calls.sweep": ("sweep",),
    "mbproj.dynamics": ("State", "assemble", "mobility", "unique_components"),
    "mbproj.errors": ("InputError", "SimulationError"),
    "mbproj.integrate": ("Report", "simulate"),
    "mbproj.model": ("System", "compile_system", "initial_guess"),
    "mbproj.projection": ("Projection",),
    "mbproj.projection.plugin": ("register_projection",),
    "mbproj.results": ("Results", "ResultsWriter", "Trust", "Verification", "open_results"),
    "mbproj.scene": ("Scene", "read_scene", "read_scene_text", "settings_to_run"),
    "mbproj.studies.certify.certified": ("simulate_certified",),
    "mbproj.studies.compare.comparison": ("Comparison", "compare"),
    "mbproj.studies.measure.mechanism": ("Mechanism",),
    "mbproj.studies.recommend.recommendation": ("Recommendation", "recommend"),
    "mbproj.studies.measure.reference": ("Reference", "reference"),
    "mbproj.studies.measure.setting": ("Setting",),
    "mbproj.studies.measure.solve": ("Solution", "sample_times", "solve"),
    "mbproj.studies.threshold.violation": ("ThresholdStudy", "threshold_study"),
    "mbproj.studies.stability": ("StabilityMap", "stability"),
    "mbproj.studies.tradeoff.front": ("Tradeoff", "tradeoff"),
    "mbproj.studies.verify": ("verify",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Comparison",
    "InputError",
    "Mechanism",
    "Projection",
    "Recommendation",
    "Reference",
    "Report",
    "Results",
    "ResultsWriter",
    "Scene",
    "Setting",
    "SimulationError",
    "Solution",
    "StabilityMap",
    "State",
    "System",
    "ThresholdStudy",
    "Tradeoff",
    "Trust",
    "Verification",
    "__version__",
    "assemble",
    "compare",
    "compile_system",
    "equilibrium",
    "initial_guess",
    "linearize",
    "mobility",
    "modes",
    "open_results",
    "read_scene",
    "read_scene_text",
    "recommend",
    "reference",
    "register_projection",
    "run",
    "sample_times",
    "settings_to_run",
    "simulate",
    "simulate_certified",
    "solve",
    "stability",
    "sweep",
    "threshold_study",
    "tradeoff",
    "unique_components",
    "verify",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mbproj' has no attribute '{name}'")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
