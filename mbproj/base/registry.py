"""The choices of a user, by name: projection methods, integrators, formulations. Names only, so importing it is cheap.

A new projection method is one class in `mbproj/motion/projection.py` and one entry here; a new integrator is one
tableau under `mbproj/motion/steppers`, in `tableaus` or `implicit_tableaus`. Plug-ins add theirs by a call. The
reader, the command line, did-you-mean and the tests ask here.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, final

from mbproj.base.dataclass import dataclass
from mbproj.base.plugins import Registry


def load(where: str) -> Any:
    """The object that `where` names as "module:name". Its module is imported at the first use."""
    module, _, name = where.partition(":")
    return getattr(import_module(module), name)


def calling(where: str) -> Callable[..., Any]:
    """A function that calls the one that `where` names as "module:name". Its module is imported at the first call."""
    return lambda *arguments, **options: load(where)(*arguments, **options)


@dataclass(frozen=True)
class ProjectionEntry:
    """A projection method: its class in `mbproj.motion.projection`, its equations in the paper, a summary, and the
    names of its own options. `corrects` says whether it corrects the state after a step. `correction` names the same
    correction in the kernel; a method without one runs in the full formulation alone. `factory` makes the method of a
    plug-in, which has no class there."""

    name: str
    equations: str
    summary: str
    options: tuple[str, ...] = ()
    corrects: bool = True
    correction: str = ""
    factory: Callable[..., Any] | None = None

    @property
    def compiled(self) -> bool:
        """Whether the kernel has this method too."""
        return bool(self.correction)


#: In the kernel POPM and GPOPM share one correction: they are equal where M is positive definite (Eq. 75).
PROJECTIONS: Registry[ProjectionEntry] = Registry(
    "projection method",
    {
        "none": ProjectionEntry(
            "Unprojected", "14", "no correction: shows the drift", corrects=False, correction="none"
        ),
        "baumgarte": ProjectionEntry(
            "Baumgarte",
            "ref. 9",
            "stabilised accelerations, C̈ + 2αĊ + β²C = 0; no correction",
            ("gains",),
            corrects=False,
            correction="baumgarte",
        ),
        "gopm": ProjectionEntry(
            "Gopm", "39, 41", "geometric: the smallest correction of the coordinates", correction="coordinates"
        ),
        "popm": ProjectionEntry(
            "Popm", "44, 45", "physical: weighted by M, which must be positive definite", correction="mass"
        ),
        "mass-orthogonal": ProjectionEntry(
            "MassOrthogonal", "52, 55", "penalty α on the violation, iterated", ("alpha",), correction="penalty"
        ),
        "mmopm": ProjectionEntry("Mmopm", "60, 61", "weighted by M + α C_qᵀC_q with a large α", ("alpha",)),
        "gpopm": ProjectionEntry(
            "Gpopm", "73, 74", "physical for singular M: the smallest correction in energy", correction="mass"
        ),
        "gpopm-pinv": ProjectionEntry("GpopmPinv", "62-66", "GPOPM by a rank-revealing pseudo-inverse"),
    },
)

#: Which coordinates a run integrates; `auto` takes the planar ones where the joints allow, else the reduced ones.
FORMULATIONS = ("auto", "full", "reduced", "planar")
#: How the accelerations are solved for: the bordered system, Eq. 14, or without multipliers, Eqs. 80-81.
ACCELERATIONS = ("bordered", "eliminated")
#: The law of impact at rigid stops: restitution relates speeds (Newton), impulses (Poisson), or energies (Stronge).
IMPACT_LAWS = ("newton", "poisson", "energetic")
#: The one that a scene has where it gives none: it never creates energy.
USUAL_IMPACT_LAW = "energetic"
#: The fallback for a position correction that does not converge: none, or a second correction with GOPM's metric.
FALLBACKS = ("none", "gopm")
#: When a position correction is accepted: |C|∞ <= tolerance, or the paper's ΔqᵀMΔq <= tolerance.
STOP_TESTS = ("violation", "paper")


#: The designs of a sweep whose values are samples of distributions.
SAMPLED = frozenset({"montecarlo", "lhs", "sobol", "saltelli"})
#: Where a run begins: at the pose of the scene, or in the equilibrium that is reached from there downhill.
EQUILIBRIUM = "equilibrium"
STARTS = ("scene", EQUILIBRIUM)
#: Where a mechanism is linearised: at its start, where it rests, where it turns steadily; or at a time.
SCENE_START, STEADY = "start", "steady"
LINEARISED_AT = (SCENE_START, EQUILIBRIUM, STEADY)


@dataclass(frozen=True, eq=False)
class IntegratorEntry:
    """An integrator: its order, a summary, and its tableau as plain data or the file with it. An `embedded` pair
    estimates its error. Its stages are `implicit` where it is for stiff scenes."""

    order: int
    embedded: bool
    summary: str
    tableau: Path | Mapping[str, Any]
    implicit: bool = False

    def data(self) -> Mapping[str, Any]:
        """The tableau as plain data."""
        return read_json(self.tableau) if isinstance(self.tableau, Path) else self.tableau


def read_json(path: Path) -> dict[str, Any]:
    """The object in a JSON file of the package."""
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


@cache
def integrators() -> Registry[IntegratorEntry]:
    """Every integrator by name: the explicit ones of the tableaus on disk, by order, then the implicit ones, by order;
    last those of plug-ins."""
    entries = {}
    steppers = Path(__file__).parents[1] / "motion" / "steppers"
    for path in (*steppers.glob("tableaus/*.json"), *steppers.glob("implicit_tableaus/*.json")):
        data, implicit = read_json(path), path.parent.name.startswith("implicit")
        entries[path.stem] = IntegratorEntry(data["order"], "error" in data, data["summary"], path, implicit)
    ordered = sorted(entries.items(), key=lambda item: (item[1].implicit, item[1].order))
    return Registry("integrator", dict(ordered))


#: The run itself chooses: an explicit method where nothing is stiff, and an implicit one where a force is.
AUTOMATIC = "auto"
WHERE_SMOOTH, WHERE_STIFF = "dop853", "esdirk4"


@final
class IntegratorChoices(Collection[str]):
    """The names that a scene may give: those of all integrators, and `auto`, by which the run itself chooses."""

    def __contains__(self, name: object) -> bool:
        return name == AUTOMATIC or name in integrators()

    def __iter__(self) -> Iterator[str]:
        yield from (*integrators(), AUTOMATIC)

    def __len__(self) -> int:
        return len(integrators()) + 1


def integrator_choices() -> IntegratorChoices:
    """The names that a scene may give as its integrator. Names of mbproj's own are found without loading plug-ins."""
    return IntegratorChoices()


def is_embedded(integrator: str) -> bool:
    """Whether the integrator estimates its error, so that a tolerance can control its steps."""
    return integrator == AUTOMATIC or integrators()[integrator].embedded


def with_fixed_steps(integrator: str) -> str:
    """Return `integrator`; for `auto`, which takes no fixed steps, its explicit method."""
    return WHERE_SMOOTH if integrator == AUTOMATIC else integrator


def is_explicit(integrator: str) -> bool:
    """Whether the integrator is an explicit one; false for `auto`."""
    return integrator in integrators() and not integrators()[integrator].implicit


def explicit_integrators() -> tuple[str, ...]:
    """The names of the explicit integrators, sorted by their order."""
    explicit = {name: entry.order for name, entry in integrators().items() if not entry.implicit}
    return tuple(sorted(explicit, key=lambda name: explicit[name]))


def implicit_integrators() -> tuple[str, ...]:
    """The names of the implicit integrators, for stiff scenes."""
    return tuple(name for name, entry in integrators().items() if entry.implicit)
