"""The forces `maxwell` and `torsion_maxwell`: a spring and a damper in series, a model of rubber, oil and seals.

type: maxwell, points: {ground: [0, 0, 1], arm: [0.2, 0, 0]}, stiffness: 2e4 N/m, damping: 300 N*s/m
type: torsion_maxwell, joint: B, stiffness: 40, damping: 2
"""

from __future__ import annotations

from functools import partial

from mbproj.elements import Element, Force, State, called
from mbproj.scene.blocks.elements.element_type import ElementType
from mbproj.scene.fields.quantities import Number


def _maxwell(name: str, s: str, stiffness: float, damping: float, unit: str) -> Element:
    """The element F = -k e with the stretch e of the spring, 0 at the start. c (s' - e') = k e gives e'."""
    rate, stretch = f"{s}_dot", f"{name}.stretch"
    e = called(stretch)
    return Element(
        name,
        reads=(rate, stretch),
        states=(State("stretch", f"{called(rate)} - {stiffness / damping!r}*{e}", unit=unit),),
        forces=(Force(s, f"-{stiffness!r}*{e}", loses=True),),
        stores=f"{0.5 * stiffness!r}*{e}*{e}",
    )


MAXWELL_ELEMENTS = {
    "maxwell": ElementType(
        "m",
        {"stiffness": Number("N/m", above=0.0), "damping": Number("N*s/m", above=0.0)},
        partial(_maxwell, unit="m"),
        ("stiffness", "damping"),
        states={"stretch": "m"},
    ),
    "torsion_maxwell": ElementType(
        "rad",
        {"stiffness": Number("N*m/rad", above=0.0), "damping": Number("N*m*s/rad", above=0.0)},
        partial(_maxwell, unit="rad"),
        ("stiffness", "damping"),
        states={"stretch": "rad"},
    ),
}
