"""The settings of a run: each is declared once, as a field of `Settings` or `ProjectionSettings`.

The `simulation` block of a scene, the options of the command line and the arguments of functions come from this table.
So do what a results file holds, the facts of reports, the tables of the guide, and the keys of stored studies.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import field, fields
from types import MappingProxyType
from typing import Any

from mbproj.base import registry
from mbproj.base.dataclass import dataclass

#: What a setting decides, which says where it stands in the key of a stored study. HOW: accuracy and cost, which
#: studies of settings vary. MECHANISM: the motion that is computed. SPAN: the times of the samples.
HOW, MECHANISM, SPAN = "how", "mechanism", "span"
#: The unit of violations, whose texts have none.
SIZE = "m or rad"


def _setting(usual: Any, takes: str, help: str, **more: Any) -> Any:
    """A field with its default. `takes`, `help` and `more` are attributes of the `SettingEntry`."""
    return field(default=usual, metadata={"takes": takes, "help": help, **more})


# fmt: off
@dataclass(frozen=True)
class ProjectionSettings:
    """How the constraints are enforced."""

    method: str = _setting("gpopm", "PROJECTIONS", "How the constraints are enforced.", name="projection",
        label="{}")
    tolerance: float | None = _setting(None, SIZE, "Largest violation at which a position counts as closed.",
        name="projection_tolerance", null="1e-13, or 4 ε × the largest coordinate; with test: paper 1e-12")
    test: str = _setting("violation", "STOP_TESTS", name="projection_test",
        help="What the projection tolerance limits: the violation, or the paper's norm.")
    every: int = _setting(1, "K", "Project after every K-th step only.", label="every {} steps")
    threshold: float | None = _setting(None, SIZE, "Project only when the violation exceeds this.", null="none")
    position: bool = _setting(True, "", "Whether positions are projected.", name="project_position")
    velocity: bool = _setting(True, "", "Whether velocities are projected.", name="project_velocity")
    max_iterations: int = _setting(25, "N", "Largest number of iterations of one projection.",
        label="at most {} iterations")
    alpha: float | None = _setting(None, "1", "Penalty factor of mass-orthogonal and mmopm.",
        null="none", where_taken=1e7, label="α = {}")
    gains: tuple[float, float] | None = _setting(None, "1/s", "Gains α and β of Baumgarte's method in 1/s.",
        null="none", where_taken=(25.0, 25.0), metavar="A[,B]")
    fallback: str = _setting("none", "FALLBACKS", "Method to try when a position projection does not converge.",
        name="projection_fallback")
    energy: bool = _setting(False, "", "Whether velocities also keep the energy balance: for long runs.",
        name="energy_row")
    momentum: bool = _setting(False, "", "Whether velocities also keep the momenta that nothing changes.",
        name="momentum_row")


@dataclass(frozen=True)
class Settings:
    """The `simulation` block with defaults resolved. Exactly one of `step` and `tolerance` is set in a run; `duration`
    and both may be None in a scene that leaves them to the command line."""

    duration: float | None = _setting(None, "s", "How long to simulate.", null="it has to be given", decides=SPAN)
    step: float | None = _setting(None, "s", "Fixed step of the integrator, in place of a tolerance.",
        null="by the tolerance", label="h = {} s")
    tolerance: float | None = _setting(None, "1", null="fixed steps", maximum=0.1,
        help="Error tolerance in place of a step, for integrators with an error estimate.")
    integrator: str = _setting("rk4", "integrator_choices",
        "Method of integration; esdirk4 and radau5 are implicit, for stiff scenes; auto chooses during the run.",
        label="{}")
    formulation: str = _setting("auto", "FORMULATIONS", "Coordinates to compute in; auto takes the fewest that fit.",
        label="{}")
    kinematic: bool | None = _setting(None, "", null="not integrated where nothing is free", decides=MECHANISM,
        help="true: the scene must have no degree of freedom, and is not integrated; "
        "false: it is integrated in any case.")
    acceleration: str = _setting("bordered", "ACCELERATIONS", "Solve Eq. 14, or Eqs. 80-81 without multipliers.",
        label="{}")
    impact_law: str = _setting(registry.USUAL_IMPACT_LAW, "IMPACT_LAWS", decides=MECHANISM,
        help="Impact law that the restitution of rigid stops belongs to.")
    output_step: float | None = _setting(None, "s", "Time between recorded samples, a multiple of the step.",
        null="each step; with a tolerance 1/1000 of the duration", decides=SPAN)
    break_times: tuple[float, ...] = _setting((), "s", "Times at which steps end besides those that the scene has.",
        above=None, metavar="T[,T..]", decides=MECHANISM)
    start: str = _setting("scene", "STARTS", "Begin at the scene's pose, or where it rests downhill from there.",
        decides=MECHANISM)
    adjust_joints: float | None = _setting(None, "m", null="none", decides=MECHANISM,
        help="Most by which joints may move to close loops of rounded numbers.")
    projection: ProjectionSettings = field(default_factory=ProjectionSettings)
# fmt: on


@dataclass(frozen=True)
class SettingEntry:
    """A setting of a run.

    `name` is its argument and, with hyphens, its option; `path` leads to its key in the `simulation` block. `type` and
    `usual` are the type of its value in Python and its default; `null` says what None means. `takes` is the unit of a
    number ("1" for none), the name of the words in `mbproj.base.registry`, or the placeholder of a count. Numbers lie
    `above` one and are at most `maximum`. `where_taken` is the default where only some projection methods have it.
    `label` is its text in a legend.
    """

    name: str
    path: tuple[str, ...]
    type: str
    usual: Any
    takes: str
    help: str
    null: str = ""
    above: float | None = 0.0
    maximum: float | None = None
    where_taken: Any = None
    decides: str = HOW
    metavar: str = ""
    label: str = ""

    @property
    def key(self) -> str:
        """Its key in the block where it stands."""
        return self.path[-1]

    @property
    def kind(self) -> str:
        """The type of its values that are not None."""
        return self.type.removesuffix(" | None")

    @property
    def words(self) -> Collection[str]:
        """The words that it may be; () for other values."""
        choices: Any = getattr(registry, self.takes) if self.kind == "str" else ()
        return choices() if callable(choices) else choices

    def of(self, settings: Settings) -> Any:
        """Its value in these settings."""
        return getattr(settings if len(self.path) == 1 else settings.projection, self.key)


def option_name(name: str) -> str:
    """The option of the command line with this name in Python, as "--output-step"."""
    return "--" + name.replace("_", "-")


def _entries(record: type, *way: str) -> Iterator[SettingEntry]:
    for each in fields(record):
        if each.metadata:
            kinds = {"name": each.name, "path": (*way, each.name), "type": str(each.type), "usual": each.default}
            yield SettingEntry(**{**kinds, **each.metadata})
        else:
            yield from _entries(ProjectionSettings, each.name)


#: Every setting by its name in Python.
SETTINGS: Mapping[str, SettingEntry] = MappingProxyType({each.name: each for each in _entries(Settings)})
#: The settings that a study chooses itself, by its name: it takes no option and no argument for them.
_CHOSEN_BY: Mapping[str, tuple[str, ...]] = {
    "stability": ("projection", "output_step"),
    "threshold": ("every", "threshold", "output_step"),
    "verify": ("output_step",),
}


def settings_taken(command: str) -> dict[str, SettingEntry]:
    """The settings that a command on a scene takes, and the function of its name."""
    return {name: entry for name, entry in SETTINGS.items() if name not in _CHOSEN_BY.get(command, ())}
