"""The kinds of pictures of results, each with a function `draw(results, labels) -> Figure`. Importing this is cheap."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError
from mbproj.base.registry import SAMPLED, load

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.results.record import Results
    from mbproj.show.figures.sweep_axes import Chosen


@dataclass(frozen=True)
class PictureKind:
    """A kind of picture: the function that draws it, as "module:name", and a summary. `needs` is the kind of names that
    the results must have.

    `usual`: most results have these names, so a note tells where they are missing. `of_motion`: it shows the motion, so
    untrusted parts are marked, by the function `mark`. `empty` is the function that tells why a picture that applies
    shows nothing of interest. `by_default`: it is drawn where no kind is asked for. `takes` is its further argument,
    "times" or "corners". `over`: it can be drawn over a coordinate instead of time."""

    draws: str
    summary: str
    needs: str | None = None
    usual: bool = True
    of_motion: bool = True
    by_default: bool = True
    takes: str = ""
    over: bool = False
    mark: str = "mbproj.show.figures.panels:mark_untrusted"
    empty: str = ""


KINDS: Mapping[str, PictureKind] = MappingProxyType(
    {
        "markers": PictureKind(
            "mbproj.show.figures.over_time:draw_markers",
            "position and velocity of each marker",
            "markers",
            over=True,
            mark="mbproj.show.figures.over_time:mark_untrusted",
        ),
        "paths": PictureKind(
            "mbproj.show.figures.mechanism:draw_paths",
            "path of each marker in a plane",
            "markers",
            mark="mbproj.show.figures.mechanism:mark_untrusted",
            empty="mbproj.show.figures.mechanism:nothing_to_see",
        ),
        "coordinates": PictureKind(
            "mbproj.show.figures.over_time:draw_coordinates",
            "joint coordinates and their speeds",
            "coordinates",
            over=True,
        ),
        "violation": PictureKind(
            "mbproj.show.figures.over_time:draw_violation",
            "violation of the constraints, position and velocity",
            of_motion=False,
            over=True,
        ),
        "joints": PictureKind(
            "mbproj.show.figures.over_time:draw_joints",
            "violation of each joint, lengths and angles",
            "joints",
            of_motion=False,
            over=True,
        ),
        "reactions": PictureKind(
            "mbproj.show.figures.loads:draw_reactions", "reaction force and torque of each joint", "joints", over=True
        ),
        "loads": PictureKind(
            "mbproj.show.figures.loads:draw_loads",
            "polar diagram of each joint's force, forces of motions over the cycle",
            "joints",
            of_motion=False,
            by_default=False,
        ),
        "forces": PictureKind(
            "mbproj.show.figures.loads:draw_forces",
            "the coordinate or length of each force, and the force",
            "forces",
            usual=False,
            over=True,
        ),
        "motions": PictureKind(
            "mbproj.show.figures.loads:draw_motions",
            "coordinate and driving force of each motion",
            "motions",
            usual=False,
            over=True,
        ),
        "stops": PictureKind(
            "mbproj.show.figures.loads:draw_stops", "gap and force of each stop", "stops", usual=False, over=True
        ),
        "ropes": PictureKind(
            "mbproj.show.figures.loads:draw_ropes",
            "length and tensions of each rope",
            "tensions",
            usual=False,
            over=True,
        ),
        "friction": PictureKind(
            "mbproj.show.figures.loads:draw_friction",
            "rate, force and lost energy of each dry friction",
            "frictions",
            usual=False,
            over=True,
        ),
        "contacts": PictureKind(
            "mbproj.show.figures.mechanism:draw_contacts",
            "path of each place where a curve is touched",
            "touching",
            of_motion=False,
            by_default=False,
            empty="mbproj.show.figures.mechanism:nothing_to_see",
            mark="mbproj.show.figures.mechanism:mark_untrusted",
        ),
        "energy": PictureKind(
            "mbproj.show.figures.over_time:draw_energy",
            "kinetic, potential and total energy, and the energy balance",
            of_motion=False,
            over=True,
        ),
        "steps": PictureKind(
            "mbproj.show.figures.over_time:draw_steps", "step size and iterations of the projection", of_motion=False
        ),
        "mechanism": PictureKind(
            "mbproj.show.figures.mechanism:draw_mechanism",
            "the mechanism at its start, or at the times of --at",
            "scene",
            of_motion=False,
            by_default=False,
            takes="times",
        ),
        "ratios": PictureKind(
            "mbproj.show.figures.over_time:draw_ratios",
            "velocity ratios and mechanical advantages to --over",
            "over",
            of_motion=False,
            by_default=False,
            over=True,
        ),
        "transmission": PictureKind(
            "mbproj.show.figures.over_time:draw_transmission",
            "the angles of --transmission",
            "markers",
            of_motion=False,
            by_default=False,
            takes="corners",
            over=True,
        ),
        "trust": PictureKind(
            "mbproj.show.figures.over_time:draw_trust",
            "error of each marker, of certified runs",
            "trust",
            usual=False,
            of_motion=False,
        ),
    }
)

#: The needed names as words in a sentence.
NEEDED = {
    "markers": "markers",
    "joints": "joints",
    "coordinates": "joint coordinates",
    "forces": "forces",
    "motions": "motions",
    "stops": "stops",
    "frictions": "dry friction that can stick",
    "tensions": "ropes whose length is held or limited",
    "touching": "joints that follow curves",
}


def why_not(kind: str, results: Sequence[Results]) -> str | None:
    """The reason why a kind does not apply to `results`; None where it does."""
    needs = KINDS[kind].needs
    if not KINDS[kind].over and any(result.shown_over for result in results):
        return "it is not over time, and not over a coordinate"
    if needs == "over":
        return None if any(result.shown_over for result in results) else "name the input: --over JOINT.COORDINATE"
    if needs == "trust":
        return None if any(result.trust for result in results) else "no result is certified: mbproj run --certify"
    if needs == "scene":
        return _unreadable(results)
    if needs is None or any(result.names(needs) for result in results):
        return None
    return f"the results have no {NEEDED[needs]}"


def _unreadable(results: Sequence[Results]) -> str | None:
    """The reason why the scene in one of the results cannot be read; None where all can."""
    try:
        for result in results:
            _ = result.scene
    except InputError as error:
        return f"the scene in the results cannot be read: {error.problems[0].message}"
    return None


def nothing_to_see(kind: str, results: Sequence[Results]) -> str | None:
    """The reason why a picture of a `kind` that applies shows nothing of interest; None where it does. Such a picture
    is drawn only on request."""
    judge: Callable[[Sequence[Results]], str | None] | None = load(KINDS[kind].empty) if KINDS[kind].empty else None
    return judge(results) if judge else None


def draw(
    kind: str,
    results: Sequence[Results],
    labels: Sequence[str],
    limit: float | None = None,
    times: Sequence[float] = (),
    corners: Sequence[tuple[str, str, str]] = (),
) -> Figure:
    """Draws one or several overlaid `results`, each with at least one sample; `labels` name them.

    Parts of a certified run whose error may exceed `limit` (m) are marked. By default the limit is a power of ten below
    a thousandth of the markers' travel. `times` (s) and `corners` (three markers each) are for the kinds that take
    them. Over a coordinate, nothing that belongs to a time is marked."""
    from mbproj.results.analysis.trust import usual_limit
    from mbproj.show.figures import panels

    entry = KINDS[kind]
    inputs: Mapping[str, Sequence[object]] = {"times": times, "corners": corners}
    over = next((each.shown_over for each in results if each.shown_over), None)
    options = {entry.takes: inputs[entry.takes]} if entry.takes else {}
    figure: Figure = load(entry.draws)(results, labels, **options)
    if over is not None:
        panels.relabel(figure, over.name, over.unit, modulo=over.modulo)
    panels.mark_events(figure, results)
    if over is None and entry.of_motion and any(result.trust for result in results):
        panels.explain(figure, load(entry.mark)(figure, results, limit or usual_limit(results)))
    panels.small_print(figure, caption(results))
    panels.thin(figure)
    return figure


def caption(results: Sequence[Results]) -> str:
    """The title of the results where they share one, and the settings of a single run."""
    titles = {result.title for result in results}
    parts = [titles.pop()] if len(titles) == 1 else []
    if len(results) == 1:
        settings = results[0].settings
        if results[0].attributes.get("kinematic"):
            parts.append("kinematic")
        else:
            step = f"step {settings.step:g} s" if settings.step is not None else f"tolerance {settings.tolerance:g}"
            parts.append(f"{settings.projection.method}, {settings.integrator}, {step}")
    return "; ".join(part for part in parts if part)


# --- The kinds of pictures of sweeps, each with `why_not(chosen)` and `draw(chosen) -> Figure` ------------------------
# Importing it is cheap.


#: The designs whose values are samples of distributions, and those whose values are listed.
LISTED = frozenset({"grid", "zip"})


@dataclass(frozen=True)
class SweepPicture:
    """A kind of picture: a summary, and the designs for which it is drawn by default. `draws` and `refuses` name the
    functions that draw it and that tell why it does not apply, as "module:name"."""

    draws: str
    refuses: str
    summary: str
    designs: frozenset[str]


SWEEP_PICTURES: Mapping[str, SweepPicture] = MappingProxyType(
    {
        "lines": SweepPicture(
            "mbproj.show.figures.sweeps:draw_lines",
            "mbproj.show.figures.sweeps:no_lines",
            "measures over one quantity, a line for each value of a second",
            LISTED,
        ),
        "map": SweepPicture(
            "mbproj.show.figures.sweeps:draw_map",
            "mbproj.show.figures.sweeps:no_map",
            "measures over two quantities as heat maps with contours",
            LISTED,
        ),
        "distribution": SweepPicture(
            "mbproj.show.figures.sweeps:draw_distribution",
            "mbproj.show.figures.sweeps:no_distribution",
            "how each measure is distributed, with its quantiles",
            SAMPLED,
        ),
        "scatter": SweepPicture(
            "mbproj.show.figures.sweeps:draw_scatter",
            "mbproj.show.figures.sweeps:no_scatter",
            "scatter plots of all varied quantities and measures",
            SAMPLED,
        ),
        "ranks": SweepPicture(
            "mbproj.show.figures.sweeps:draw_ranks",
            "mbproj.show.figures.sweeps:no_ranks",
            "rank correlations as a tornado chart",
            SAMPLED,
        ),
        "sobol": SweepPicture(
            "mbproj.show.figures.sweeps:draw_sobol",
            "mbproj.show.figures.sweeps:no_sobol",
            "Sobol' indices with their confidence",
            SAMPLED,
        ),
    }
)


def why_no_sweep(kind: str, chosen: Chosen) -> str | None:
    """The reason why the picture does not apply; None where it does."""
    reason: str | None = load(SWEEP_PICTURES[kind].refuses)(chosen)
    return reason


def draw_sweep(kind: str, chosen: Chosen) -> Figure:
    """Draw the picture of a sweep to which it applies."""
    figure: Figure = load(SWEEP_PICTURES[kind].draws)(chosen)
    return figure
