"""Random scenes with contacts and dry friction, each with an independent solution of its motion."""

from __future__ import annotations

from collections.abc import Callable

from .beams import beam
from .blocks import block, plate
from .cranks import slider_crank, yoke
from .rolling import ball, wheel
from .scene import Case
from .stages import stage

#: Each family draws a case from a seed.
FAMILIES: dict[str, Callable[[int], Case]] = {
    "stage": stage,
    "yoke": yoke,
    "slider_crank": slider_crank,
    "block": block,
    "plate": plate,
    "ball": ball,
    "wheel": wheel,
    "beam": beam,
}
