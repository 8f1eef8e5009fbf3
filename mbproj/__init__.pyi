"""The public names, for editors and type checkers: those of `HOMES`."""

from collections.abc import Mapping

from mbproj.api.again import continue_run as continue_run, rerun as rerun
from mbproj.api.batch import Batch as Batch, batch as batch
from mbproj.api.check.assemblies import branches as branches
from mbproj.api.check.checked import SceneCheck as SceneCheck, check as check
from mbproj.api.files import compare_results as compare_results, export as export, largest_loads as largest_loads
from mbproj.api.linear import (
    equilibria as equilibria,
    equilibrium as equilibrium,
    linearize as linearize,
    modes as modes,
    traces as traces,
)
from mbproj.api.loads import loads as loads
from mbproj.api.models import (
    Exported as Exported,
    Imported as Imported,
    export_model as export_model,
    import_model as import_model,
    new as new,
    schema as schema,
)
from mbproj.api.pictures import paper as paper
from mbproj.api.run import run as run, start as start
from mbproj.api.studies import (
    compare as compare,
    recommend as recommend,
    stability as stability,
    threshold as threshold,
    tradeoff as tradeoff,
    verify as verify,
)
from mbproj.api.sweep import (
    SweepTable as SweepTable,
    fit as fit,
    optimise as optimise,
    sensitivity as sensitivity,
    sweep as sweep,
)
from mbproj.dynamics import (
    State as State,
    assemble as assemble,
    mobility as mobility,
    unique_components as unique_components,
)
from mbproj.errors import InputError as InputError, SimulationError as SimulationError
from mbproj.figures.style import figure_style as figure_style
from mbproj.integrate import Report as Report, simulate as simulate
from mbproj.integrate.steppers.plugin import register_integrator as register_integrator
from mbproj.model import System as System, initial_guess as initial_guess
from mbproj.dynamics.assembly.adjust import compile_system as compile_system
from mbproj.parts import *
from mbproj.projection import Projection as Projection
from mbproj.projection.plugin import register_projection as register_projection
from mbproj.results import (
    Results as Results,
    ResultsWriter as ResultsWriter,
    Trust as Trust,
    Verification as Verification,
    open_results as open_results,
)
from mbproj.results.notes import Note as Note
from mbproj.results.views.table import Table as Table
from mbproj.runs.record import Run as Run, record_run as record_run
from mbproj.scene import (
    Scene as Scene,
    read_scene as read_scene,
    read_scene_text as read_scene_text,
    settings_to_run as settings_to_run,
)
from mbproj.scene.blocks.forces.plugin import register_element as register_element, register_force as register_force
from mbproj.studies.certify.certified import simulate_certified as simulate_certified
from mbproj.studies.compare.comparison import Comparison as Comparison
from mbproj.studies.measure.mechanism import Mechanism as Mechanism
from mbproj.studies.measure.reference import Reference as Reference, reference as reference
from mbproj.studies.measure.setting import Setting as Setting
from mbproj.studies.measure.solve import Solution as Solution, sample_times as sample_times, solve as solve
from mbproj.studies.recommend.recommendation import Recommendation as Recommendation
from mbproj.studies.stability import StabilityMap as StabilityMap
from mbproj.studies.threshold import ThresholdStudy as ThresholdStudy, threshold_study as threshold_study
from mbproj.studies.tradeoff.result import Tradeoff as Tradeoff
from mbproj.version import __version__ as __version__

HOMES: Mapping[str, str]
