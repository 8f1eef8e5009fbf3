"""The studies as functions: `mbproj.compare`, `recommend`, `tradeoff`, `threshold`, `stability`, `verify`.

Each takes the arguments of the command of its name, and a scene in any form. Each result is also a table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from mbproj.api.arguments import (
    Given,
    Quantity,
    amount,
    amounts,
    by_arguments,
    count_of,
    names_of,
    refuse_earlier_names,
    scene_of,
)
from mbproj.api.settings import RunSettings, options_of, with_settings
from mbproj.results import Verification
from mbproj.studies.compare.comparison import PROJECTIONS_COMPARED, Comparison
from mbproj.studies.compare.comparison import compare as compare_settings
from mbproj.studies.measure.timing import REPETITIONS
from mbproj.studies.parallel.client import Cluster, workplace
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.recommend.recommendation import Recommendation
from mbproj.studies.recommend.recommendation import recommend as cheapest_setting
from mbproj.studies.stability.bisection import POINTS, StabilityMap
from mbproj.studies.stability.bisection import stability as map_stability
from mbproj.studies.stability.judge import Limits
from mbproj.studies.stability.quantities import quantity_named
from mbproj.studies.threshold import ThresholdStudy, threshold_study
from mbproj.studies.tradeoff.ladders import PROJECTIONS_TRIED
from mbproj.studies.tradeoff.ladders import tradeoff as measure_tradeoff
from mbproj.studies.tradeoff.result import Tradeoff
from mbproj.studies.verify import checks

if TYPE_CHECKING:
    from typing_extensions import Unpack

_NOTHING: Mapping[str, object] = {}
Names: TypeAlias = "str | Sequence[str]"
Numbers: TypeAlias = "Sequence[Quantity] | Quantity | None"


@refuse_earlier_names
def compare(
    scene: Given,
    *,
    projections: Names = PROJECTIONS_COMPARED,
    integrators: Names | None = None,
    steps: Numbers = None,
    tolerances: Numbers = None,
    formulations: Names | None = None,
    energy_rows: Sequence[bool] | None = None,
    until: Quantity | None = None,
    repeat: int = REPETITIONS,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    fresh: bool = False,
    parameters: Mapping[str, object] = _NOTHING,
    progress: Tell = silent,
) -> Comparison:
    """Runs every projection with every integrator and every step (s) or tolerance over `until` s, without or with the
    energy row, as `energy_rows` tells.

    The scene's own settings complete the arguments. The work is done by `jobs` processes, or by the Dask cluster whose
    `scheduler` is named. Stored results are reused, unless `fresh`. Raises InputError for what cannot be run at all; a
    setting that fails is a row.
    """
    with by_arguments():
        return compare_settings(
            scene_of(scene, parameters, {}),
            projections=names_of(projections),
            integrators=_names(integrators),
            steps=amounts(steps, "steps", "s"),
            tolerances=amounts(tolerances, "tolerances", ""),
            formulations=_names(formulations),
            energy_rows=None if energy_rows is None else tuple(map(bool, energy_rows)),
            until=_time(until),
            repetitions=count_of(repeat, "repeat", least=1),
            processes=workplace(jobs, scheduler, scheduler_file),
            fresh=fresh,
            tell=progress,
        )


@refuse_earlier_names
def recommend(
    scene: Given,
    error: Quantity,
    at: Names = (),
    until: Quantity | None = None,
    timed: bool = True,
    progress: Tell = silent,
    *,
    output_step: Quantity | None = None,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    fresh: bool = False,
    parameters: Mapping[str, object] = _NOTHING,
) -> Recommendation:
    """The cheapest setting whose `error` (m) is kept at every sample up to `until` (s; the scene's duration), at the
    markers `at` (all; the bodies' centres where there are none).

    `found.settings` are the settings to run with. Without `timed` the fewest evaluations decide. The integrators are
    searched by `jobs` processes, or by the Dask cluster whose `scheduler` is named. An interrupted search resumes,
    unless `fresh`. Raises InputError for an unknown name or a missing duration. Raises
    `mbproj.studies.recommend.recommendation.Unreachable` where no setting keeps the error at all.
    """
    with by_arguments():
        what = scene_of(scene, parameters, {"output_step": output_step})
        goal = amount(error, "error", "m", above=0.0)
        where = workplace(jobs, scheduler, scheduler_file)
        return cheapest_setting(what, goal, names_of(at), _time(until), timed, fresh, progress, where)


@refuse_earlier_names
def tradeoff(
    scene: Given,
    *,
    projections: Names = PROJECTIONS_TRIED,
    integrators: Names | None = None,
    formulation: str | None = None,
    at: Names = (),
    until: Quantity | None = None,
    longest: Quantity = 0.5,
    repeat: int = REPETITIONS,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    fresh: bool = False,
    parameters: Mapping[str, object] = _NOTHING,
    progress: Tell = silent,
) -> Tradeoff:
    """Measures accuracy against cost over `projections`, `integrators` (by default the explicit ones), steps,
    tolerances and schedules.

    The error is the largest up to `until` s (the duration) at the markers `at` (all of them; the bodies' centres where
    the scene has none). A sweep ends with a run that takes more than `longest` s. An interrupted study resumes, and a
    finished one gives the same tables again, unless `fresh`. Raises InputError for what cannot be run at all.
    """
    with by_arguments():
        return measure_tradeoff(
            scene_of(scene, parameters, {}),
            projections=names_of(projections),
            integrators=_names(integrators),
            formulation=formulation,
            at=names_of(at),
            until=_time(until),
            longest=amount(longest, "longest", "s", above=0.0),
            repetitions=count_of(repeat, "repeat", least=1),
            processes=workplace(jobs, scheduler, scheduler_file),
            fresh=fresh,
            tell=progress,
        )


@with_settings
@refuse_earlier_names
def threshold(
    scene: Given,
    *,
    thresholds: Numbers = None,
    at: Names = (),
    until: Quantity | None = None,
    repeat: int = REPETITIONS,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    fresh: bool = False,
    parameters: Mapping[str, object] = _NOTHING,
    progress: Tell = silent,
    **settings: Unpack[RunSettings],
) -> ThresholdStudy:
    """Varies the threshold (m or rad, and per s) of a setting, and measures error, violation and cost.

    The setting is the scene's, changed by the `settings`, as in `run`. Raises InputError where it has no projection, or
    does not run.
    """
    with by_arguments():
        return threshold_study(
            scene_of(scene, parameters, options_of(settings, "threshold", "thresholds")),
            thresholds=amounts(thresholds, "thresholds", ""),
            at=names_of(at),
            until=_time(until),
            repetitions=count_of(repeat, "repeat", least=1),
            processes=workplace(jobs, scheduler, scheduler_file),
            fresh=fresh,
            tell=progress,
        )


@with_settings
@refuse_earlier_names
def stability(
    scene: Given,
    vary: str,
    *,
    projections: Names | None = None,
    low: Quantity | None = None,
    high: Quantity | None = None,
    points: int = POINTS,
    until: Quantity | None = None,
    closed: Quantity | None = None,
    energy: Quantity | None = None,
    limits: Limits | None = None,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    fresh: bool = False,
    parameters: Mapping[str, object] = _NOTHING,
    progress: Tell = silent,
    **settings: Unpack[RunSettings],
) -> StabilityMap:
    """Varies `vary` ("step", "mass-ratio", ...) from `low` to `high` for each projection method, and finds its limits.

    A run holds where its joints are `closed` to this (m or rad), and its relative `energy` error is at most this;
    `limits` has both. Other settings are as in `run`. Raises InputError where the scene does not have this quantity, or
    a method does not depend on it.
    """
    with by_arguments():
        unit = quantity_named(vary).unit
        bounds = {"closed": closed, "energy": energy}
        given = {name: amount(value, name, "", above=0.0) for name, value in bounds.items() if value is not None}
        return map_stability(
            scene_of(
                scene, parameters, options_of(settings, "stability", "vary", "projections", "points", "low", "high")
            ),
            vary,
            projections=_names(projections),
            low=None if low is None else amount(low, "low", unit, above=0.0),
            high=None if high is None else amount(high, "high", unit, above=0.0),
            points=count_of(points, "points", least=2),
            until=_time(until),
            limits=Limits(**given) if given else limits,
            processes=workplace(jobs, scheduler, scheduler_file),
            fresh=fresh,
            tell=progress,
        )


@with_settings
@refuse_earlier_names
def verify(
    scene: Given,
    progress: Tell = silent,
    *,
    parameters: Mapping[str, object] = _NOTHING,
    **settings: Unpack[RunSettings],
) -> Verification:
    """Runs every check of the paper's mathematics on a scene. `progress` is called with the phase, the number of checks
    done, and the number of all.

    Settings are as in `run`. Raises InputError where the mechanism cannot be assembled or run at all, SimulationError
    where a function of the scene has no value at the start.
    """
    with by_arguments():
        return checks.verify(scene_of(scene, parameters, options_of(settings, "verify")), progress)


def _names(given: Names | None) -> tuple[str, ...] | None:
    return None if given is None else names_of(given)


def _time(until: Quantity | None) -> float | None:
    return None if until is None else amount(until, "until", "s", above=0.0)
