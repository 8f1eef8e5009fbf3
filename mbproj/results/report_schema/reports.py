"""The reports that commands print with --json, each with its facts."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from mbproj.dataclass import dataclass
from mbproj.report_schema import Fact
from mbproj.report_schema.check import CHECK
from mbproj.report_schema.designs import BATCH, DESIGN, SENSITIVITY, SWEEP, TOPOLOGIES, VERIFY
from mbproj.report_schema.info import BUILD, INFO
from mbproj.report_schema.linear import EQUILIBRIUM, LINEAR, MODES
from mbproj.report_schema.loads import ACTUATORS, LARGEST_LOADS
from mbproj.report_schema.models import BRANCHES, CURVE, EXPORT, IMPORT
from mbproj.report_schema.results import COMPARISON, ENERGY, SOUNDNESS, STEPS, THRESHOLD_ROWS
from mbproj.report_schema.run import RUN
from mbproj.report_schema.studies import COMPARE, EVERY_STUDY, RECOMMEND, STABILITY, THRESHOLD, TRADEOFF


@dataclass(frozen=True)
class JsonReport:
    """The facts that `commands` print, an option of a command included, and what the report is of, in `words`. It is of
    the `kind` "object", or else has many objects."""

    words: str
    facts: tuple[Fact, ...]
    commands: tuple[str, ...]
    kind: str = "object"


#: The reports by their name, which is that of the first command, with the option that asks for another report.
REPORTS: Mapping[str, JsonReport] = MappingProxyType(
    {
        "run": JsonReport(
            "A run. One that fails or is interrupted has what is said always.", RUN, ("run", "rerun", "continue")
        ),
        "check": JsonReport("A scene at its assembled start.", CHECK, ("check",)),
        "branches": JsonReport("The assemblies of a scene.", BRANCHES, ("branches",)),
        "curve": JsonReport("A curve of a scene.", CURVE, ("curve",)),
        "equilibrium": JsonReport("Where a scene rests.", EQUILIBRIUM, ("equilibrium",)),
        "modes": JsonReport("The modes of small motions.", MODES, ("modes",)),
        "linearize": JsonReport("A linear model: x' = A x + B u, y = C x + D u.", LINEAR, ("linearize",)),
        "info": JsonReport("A results file.", INFO, ("info",)),
        "info-loads": JsonReport("The largest loads of a run.", LARGEST_LOADS, ("info --loads",)),
        "info-steps": JsonReport("What limits the steps of a run.", STEPS, ("info --steps",)),
        "info-energy": JsonReport("The energy of a run.", ENERGY, ("info --energy",)),
        "info-check": JsonReport("A check of a results file or a sweep.", SOUNDNESS, ("info --check",)),
        "info-thresholds": JsonReport(
            "Every threshold, by name.", THRESHOLD_ROWS, ("info --thresholds",), "map of object"
        ),
        "build": JsonReport("mbproj itself.", BUILD, ("info --build",)),
        "compare-results": JsonReport("Two results files.", COMPARISON, ("compare-results",)),
        "loads": JsonReport("The forces of actuators along a motion.", ACTUATORS, ("loads",)),
        "compare": JsonReport("A comparison of methods.", (*COMPARE, *EVERY_STUDY), ("compare",)),
        "tradeoff": JsonReport("Accuracy against cost.", (*TRADEOFF, *EVERY_STUDY), ("tradeoff",)),
        "recommend": JsonReport("The cheapest setting for an error.", (*RECOMMEND, *EVERY_STUDY), ("recommend",)),
        "threshold": JsonReport("Thresholds of the projection.", (*THRESHOLD, *EVERY_STUDY), ("threshold",)),
        "stability": JsonReport("Where methods hold, degrade and fail.", (*STABILITY, *EVERY_STUDY), ("stability",)),
        "verify": JsonReport("A verification.", (*VERIFY, *EVERY_STUDY), ("verify",)),
        "sensitivity": JsonReport("Sensitivities, an array.", SENSITIVITY, ("sensitivity",), "array of object"),
        "fit": JsonReport("A design.", (*DESIGN, *EVERY_STUDY), ("fit", "optimise")),
        "optimise-topologies": JsonReport(
            "The topologies of a design.", (*TOPOLOGIES, *EVERY_STUDY), ("optimise --topologies",)
        ),
        "sweep": JsonReport("The cases of a sweep.", (*SWEEP, *EVERY_STUDY), ("sweep",)),
        "batch": JsonReport("A batch of scenes.", (*BATCH, *EVERY_STUDY), ("batch",)),
        "import": JsonReport("What becomes of a model as a scene.", IMPORT, ("import",)),
        "export": JsonReport("What becomes of a scene as a model.", EXPORT, ("export",)),
    }
)
