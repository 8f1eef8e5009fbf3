"""The templates of `mbproj new`, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.templates import bars, cam, geneva, hoist, ladder, linkages, pendulum, star, winch
from mbproj.templates.values import OPTIONS, Values, values_of


@dataclass(frozen=True)
class Template:
    """A template: a summary, its options with their defaults, and the function that yields the lines of its scene.
    `spatial` ones come in a plane or in space."""

    summary: str
    defaults: Mapping[str, str]
    lines: Callable[..., Iterator[str]]
    spatial: bool = False


TEMPLATES: Mapping[str, Template] = {
    "pendulum": Template("a bar on a pin, with its exact period", pendulum.DEFAULTS, pendulum.pendulum),
    "chain": Template("bars in a row", bars.CHAIN, bars.chain, spatial=True),
    "ladder": Template("parallelograms one below the other", ladder.DEFAULTS, ladder.ladder),
    "tree": Template("two bars on the end of each", bars.TREE, bars.tree, spatial=True),
    "star": Template("bars on the rim of a hub that turns", star.DEFAULTS, star.star),
    "slider-crank": Template("driven, in a plane", linkages.SLIDER_CRANK, linkages.slider_crank),
    "four-bar": Template("a driven crank-rocker", linkages.FOUR_BAR, linkages.four_bar),
    "cam": Template("a cam, its roller follower and a spring", cam.DEFAULTS, cam.cam),
    "geneva": Template("a pin that turns a slotted wheel step by step", geneva.DEFAULTS, geneva.geneva),
    "hoist": Template("a drum, a rope and a moving block", hoist.DEFAULTS, hoist.hoist),
    "winch": Template("a drum and its load, coupled by a row", winch.DEFAULTS, winch.winch),
}


def scene_text(name: str, given: Mapping[str, str], spatial: bool = False) -> str:
    """The text of the scene file of the template `name`; `given` are numbers by option, as texts with their units.

    Raises InputError for an option that the template does not have, a number that its option does not take, or lengths
    that make no mechanism.
    """
    template = TEMPLATES[name]
    if spatial and not template.spatial:
        able = ", ".join(other for other, entry in TEMPLATES.items() if entry.spatial)
        raise InputError(Problem(f"a {name} has no --spatial", Place("--spatial"), f"these have: {able}"))
    values: Values = values_of(given, template.defaults, name)
    lines = template.lines(values, spatial) if template.spatial else template.lines(values)
    return "\n".join(lines) + "\n"


__all__ = ["OPTIONS", "TEMPLATES", "Template", "scene_text"]
