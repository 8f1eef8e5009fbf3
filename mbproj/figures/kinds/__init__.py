"""The kinds of pictures, each a module with `draw(results, labels) -> Figure`. Importing this package is cheap."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING

from mbproj.dataclass import dataclass
from mbproj.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.results import Results


@dataclass(frozen=True)
class PictureKind:
    """A kind of picture: its module in this folder and a summary. `needs` is the kind of names that the results must
    have.

    `usual`: most results have these names, so a note tells where they are missing. `of_motion`: it shows the motion, so
    untrusted parts are marked. `function` draws it. `by_default`: it is drawn where no kind is asked for. `takes` is
    its further argument, "times" or "corners". `over`: it can be drawn over a coordinate instead of time."""

    module: str
    summary: str
    needs: str | None = None
    usual: bool = True
    of_motion: bool = True
    function: str = "draw"
    by_default: bool = True
    takes: str = ""
    over: bool = False


KINDS: Mapping[str, PictureKind] = MappingProxyType(
    {
        "markers": PictureKind("markers", "position and velocity of each marker", "markers", over=True),
        "paths": PictureKind("paths", "path of each marker in a plane", "markers"),
        "coordinates": PictureKind("coordinates", "joint coordinates and their speeds", "coordinates", over=True),
        "violation": PictureKind(
            "violation", "violation of the constraints, position and velocity", of_motion=False, over=True
        ),
        "joints": PictureKind(
            "violation",
            "violation of each joint, lengths and angles",
            "joints",
            of_motion=False,
            function="draw_joints",
            over=True,
        ),
        "reactions": PictureKind("reactions", "reaction force and torque of each joint", "joints", over=True),
        "loads": PictureKind(
            "polar",
            "polar diagram of each joint's force, forces of motions over the cycle",
            "joints",
            of_motion=False,
            by_default=False,
        ),
        "forces": PictureKind(
            "driven",
            "the coordinate or length of each force, and the force",
            "forces",
            usual=False,
            function="draw_forces",
            over=True,
        ),
        "motions": PictureKind(
            "driven",
            "coordinate and driving force of each motion",
            "motions",
            usual=False,
            function="draw_motions",
            over=True,
        ),
        "stops": PictureKind(
            "driven", "gap and force of each stop", "stops", usual=False, function="draw_stops", over=True
        ),
        "ropes": PictureKind(
            "driven", "length and tensions of each rope", "tensions", usual=False, function="draw_ropes", over=True
        ),
        "friction": PictureKind(
            "driven",
            "rate, force and lost energy of each dry friction",
            "frictions",
            usual=False,
            function="draw_friction",
            over=True,
        ),
        "contacts": PictureKind(
            "paths",
            "path of each place where a curve is touched",
            "touching",
            of_motion=False,
            function="draw_contacts",
            by_default=False,
        ),
        "energy": PictureKind(
            "energy", "kinetic, potential and total energy, and the energy balance", of_motion=False, over=True
        ),
        "steps": PictureKind("steps", "step size and iterations of the projection", of_motion=False),
        "mechanism": PictureKind(
            "mechanism",
            "the mechanism at its start, or at the times of --at",
            "scene",
            of_motion=False,
            by_default=False,
            takes="times",
        ),
        "ratios": PictureKind(
            "ratios",
            "velocity ratios and mechanical advantages to --over",
            "over",
            of_motion=False,
            function="draw_ratios",
            by_default=False,
            over=True,
        ),
        "transmission": PictureKind(
            "ratios",
            "the angles of --transmission",
            "markers",
            of_motion=False,
            function="draw_transmission",
            by_default=False,
            takes="corners",
            over=True,
        ),
        "trust": PictureKind("trust", "error of each marker, of certified runs", "trust", usual=False, of_motion=False),
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
    scene_of = import_module("mbproj.pages.appearance.recorded").scene_of
    try:
        for result in results:
            scene_of(result)
    except InputError as error:
        return f"the scene in the results cannot be read: {error.problems[0].message}"
    return None


def nothing_to_see(kind: str, results: Sequence[Results]) -> str | None:
    """The reason why a picture of a `kind` that applies shows nothing of interest; None where it does. Such a picture
    is drawn only on request."""
    module = import_module(f"mbproj.figures.kinds.{KINDS[kind].module}")
    judge: Callable[[Sequence[Results]], str | None] = getattr(module, "nothing_to_see", lambda _: None)
    return judge(results)


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
    module = import_module(f"mbproj.figures.kinds.{KINDS[kind].module}")
    given: Mapping[str, Sequence[object]] = {"times": times, "corners": corners}
    takes, over = KINDS[kind].takes, next((each.shown_over for each in results if each.shown_over), None)
    options = {takes: given[takes]} if takes else {}
    figure: Figure = getattr(module, KINDS[kind].function)(results, labels, **options)
    if over is not None:
        import_module("mbproj.figures.panels").relabel(figure, over.name, over.unit, modulo=over.modulo)
    import_module("mbproj.figures.events").mark(figure, results)
    if over is None and KINDS[kind].of_motion and any(result.trust for result in results):
        untrusted = import_module("mbproj.figures.untrusted")
        mark = getattr(module, "mark_untrusted", untrusted.mark)
        untrusted.explain(
            figure, mark(figure, results, limit or import_module("mbproj.analysis.trust").usual_limit(results))
        )
    import_module("mbproj.figures.margins").small_print(figure, caption(results))
    import_module("mbproj.figures.panels").thin(figure)
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
