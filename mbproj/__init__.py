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
from typing import TYPE_CHECKING

from mbproj.base.version import __version__

if TYPE_CHECKING:
    from mbproj.base.errors import InputError as InputError, SimulationError as SimulationError
    from mbproj.commands.batch import Batch as Batch, batch as batch
    from mbproj.commands.branches import branches as branches
    from mbproj.commands.check import check as check
    from mbproj.commands.compare import compare as compare
    from mbproj.commands.compare_results import compare_results as compare_results
    from mbproj.commands.continue_run import continue_run as continue_run
    from mbproj.commands.curve import curve as curve
    from mbproj.commands.equilibrium import equilibria as equilibria, equilibrium as equilibrium
    from mbproj.commands.export import Exported as Exported, export as export, export_model as export_model
    from mbproj.commands.fit import fit as fit
    from mbproj.commands.import_model import Imported as Imported, import_model as import_model
    from mbproj.commands.info import largest_loads as largest_loads
    from mbproj.commands.linearize import linearize as linearize
    from mbproj.commands.loads import loads as loads
    from mbproj.commands.modes import modes as modes, traces as traces
    from mbproj.commands.new import new as new
    from mbproj.commands.optimise import optimise as optimise
    from mbproj.commands.paper import paper as paper
    from mbproj.commands.recommend import recommend as recommend
    from mbproj.commands.report.scene import SceneCheck as SceneCheck
    from mbproj.commands.rerun import rerun as rerun
    from mbproj.commands.results import Results as Results, open_results as open_results
    from mbproj.commands.run import run as run, start as start
    from mbproj.commands.schema import schema as schema
    from mbproj.commands.sensitivity import sensitivity as sensitivity
    from mbproj.commands.stability import stability as stability
    from mbproj.commands.sweep import SweepTable as SweepTable, sweep as sweep
    from mbproj.commands.threshold import threshold as threshold
    from mbproj.commands.tradeoff import tradeoff as tradeoff
    from mbproj.commands.verify import verify as verify
    from mbproj.equations.assembly.assemble import State as State, assemble as assemble
    from mbproj.equations.assembly.compiled import compile_system as compile_system
    from mbproj.equations.rank.mobility import mobility as mobility
    from mbproj.equations.rank.uniqueness import unique_components as unique_components
    from mbproj.model.compile.mechanism import initial_guess as initial_guess
    from mbproj.model.system import System as System
    from mbproj.motion.projection import Projection as Projection, register_projection as register_projection
    from mbproj.motion.report import Report as Report
    from mbproj.motion.simulate import simulate as simulate
    from mbproj.motion.steppers.plugin import register_integrator as register_integrator
    from mbproj.results.notes import Note as Note
    from mbproj.results.trust import Trust as Trust
    from mbproj.results.verification import Verification as Verification
    from mbproj.results.views import Table as Table
    from mbproj.results.writer import ResultsWriter as ResultsWriter
    from mbproj.scene.blocks.plugin_forces import register_element as register_element, register_force as register_force
    from mbproj.scene.parts import *  # noqa: F403  the classes of a scene's parts, one for each type
    from mbproj.scene.scene import Scene as Scene, read_scene as read_scene, read_scene_text as read_scene_text
    from mbproj.scene.settings import settings_to_run as settings_to_run
    from mbproj.show.figures.style import figure_style as figure_style
    from mbproj.studies.certify import simulate_certified as simulate_certified
    from mbproj.studies.compare import Comparison as Comparison
    from mbproj.studies.measure.reference import Reference as Reference, reference as reference
    from mbproj.studies.measure.setting import Setting as Setting
    from mbproj.studies.measure.solve import (
        Mechanism as Mechanism,
        Solution as Solution,
        sample_times as sample_times,
        solve as solve,
    )
    from mbproj.studies.recommend import Recommendation as Recommendation
    from mbproj.studies.record import Run as Run, record_run as record_run
    from mbproj.studies.stability import StabilityMap as StabilityMap
    from mbproj.studies.threshold import ThresholdStudy as ThresholdStudy, threshold_study as threshold_study
    from mbproj.studies.tradeoff import Tradeoff as Tradeoff

#: The public names by the module that defines them; the imports above say the same to editors and type checkers. The
#: classes of a scene's parts, such as `Body` and `Revolute`, are public, too.
HOMES: Mapping[str, str] = MappingProxyType(
    {
        "mbproj.base.errors": "InputError SimulationError",
        "mbproj.commands.batch": "Batch batch",
        "mbproj.commands.branches": "branches",
        "mbproj.commands.check": "check",
        "mbproj.commands.compare": "compare",
        "mbproj.commands.compare_results": "compare_results",
        "mbproj.commands.continue_run": "continue_run",
        "mbproj.commands.curve": "curve",
        "mbproj.commands.equilibrium": "equilibria equilibrium",
        "mbproj.commands.export": "Exported export export_model",
        "mbproj.commands.fit": "fit",
        "mbproj.commands.import_model": "Imported import_model",
        "mbproj.commands.info": "largest_loads",
        "mbproj.commands.linearize": "linearize",
        "mbproj.commands.loads": "loads",
        "mbproj.commands.modes": "modes traces",
        "mbproj.commands.new": "new",
        "mbproj.commands.optimise": "optimise",
        "mbproj.commands.paper": "paper",
        "mbproj.commands.recommend": "recommend",
        "mbproj.commands.report.scene": "SceneCheck",
        "mbproj.commands.rerun": "rerun",
        "mbproj.commands.results": "Results open_results",
        "mbproj.commands.run": "run start",
        "mbproj.commands.schema": "schema",
        "mbproj.commands.sensitivity": "sensitivity",
        "mbproj.commands.stability": "stability",
        "mbproj.commands.sweep": "SweepTable sweep",
        "mbproj.commands.threshold": "threshold",
        "mbproj.commands.tradeoff": "tradeoff",
        "mbproj.commands.verify": "verify",
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
_PARTS = "mbproj.scene.parts"
__all__: list[str]


def _public() -> list[str]:
    return ["__version__", *sorted({*_HOME_OF, *import_module(_PARTS).__all__})]


def __getattr__(name: str) -> object:
    if name == "__all__":
        return _public()
    is_part = name[:1].isupper() and name not in _HOME_OF and name in import_module(_PARTS).__all__
    if not is_part and name not in _HOME_OF:
        raise AttributeError(f"module 'mbproj' has no attribute '{name}'")
    collects = gc.isenabled()
    gc.disable()  # imported modules stay: a search for garbage among them would take 7 % of the time
    try:
        return getattr(import_module(_PARTS if is_part else _HOME_OF[name]), name)
    finally:
        if collects:
            gc.enable()


def __dir__() -> list[str]:
    return sorted([*globals(), *_public()])
