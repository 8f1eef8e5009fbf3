"""How each mechanism of the gallery is drawn: its view, and the shapes of bodies that are not bars between joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mbproj.arrays import Array

Point = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Shape:
    """Part of a body: corners (k, 3) of a bar or plate in body axes, m; `width` of a bar in points, None: a plate."""

    corners: Array
    width: float | None = 6.0


def disc(centre: Point, radius: float, axis: int) -> Shape:
    """A round plate normal to a body axis (0, 1 or 2)."""
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    return Shape(np.array(centre) + radius * np.roll(np.stack([0 * turn, np.cos(turn), np.sin(turn)]), axis, 0).T, None)


def box(x: float, y: float, z: float) -> tuple[Shape, ...]:
    """The faces of a box with these half sides about the centre of mass."""
    corners = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
    faces = [side * np.roll(corners, axis, axis=1) * [x, y, z] for axis in range(3) for side in (1.0, -1.0)]
    return tuple(Shape(face, None) for face in faces)


def bar(*corners: Point, width: float | None = 6.0) -> Shape:
    """A bar through these points, or a plate where `width` is None."""
    return Shape(np.array(corners, dtype=float), width)


@dataclass(frozen=True)
class Sketch:
    """How a mechanism is shown: the view from (azimuth, elevation) in degrees, the time that the paths cover, times at
    which it is drawn once more, faintly, bodies that are not bars between their joints (by a pattern of names; the
    ground's are global), which markers leave a path (all, where None), and whether it hangs from the ground."""

    view: tuple[float, float] = (-60.0, 20.0)
    duration: float = 2.0
    ghosts: tuple[float, ...] = ()
    shapes: Mapping[str, tuple[Shape, ...]] = field(default_factory=dict)
    markers: tuple[str, ...] | None = None
    hangs: bool = False


FLAT = (-90.0, 0.0)
SKETCHES: Mapping[str, Sketch] = {
    "bouncing_ball": Sketch(
        FLAT,
        2.0,
        (0.35, 0.68, 1.35),
        {"ball": (disc((0, 0, 0), 0.1, 1),), "ground": (bar((-0.2, 0, -0.01), (1.5, 0, -0.01), width=4),)},
    ),
    "bump_stop": Sketch(
        FLAT,
        1.2,
        (0.33,),
        {
            "body": (*box(0.35, 0.08, 0.1), bar((-0.08, 0, -0.1), (-0.08, 0, -0.26), width=12)),
            "hub": (disc((0, 0, 0), 0.3, 1), bar((0, 0, 0), (0, 0, 0.4), width=6)),
            "ground": (bar((-0.6, 0, -0.01), (0.6, 0, -0.01), width=4),),
        },
    ),
    "door_with_stop": Sketch(
        (-65.0, 28.0),
        1.2,
        (0.25, 0.56),
        {
            "leaf": box(0.45, 0.02, 1.0),
            "ground": (bar((0, 0, 0), (0, 0, 2.05), (0.93, 0, 2.05), (0.93, 0, 0), width=5),),
        },
    ),
    "drum_brake": Sketch(
        (-90.0, 90.0),
        0.03,
        (),
        {
            "drum": (disc((0, 0, 0), 0.15, 2), bar((0, 0, 0), (0.15, 0, 0), width=2)),
            "block": (bar((-0.02, -0.04, 0), (-0.01, 0, 0), (-0.02, 0.04, 0), width=9),),
            "lever": (bar((0.05, 0.19, 0), (-0.05, 0.07, 0), (-0.05, -0.07, 0)),),
        },
    ),
    "screw_press": Sketch(
        (-60.0, 15.0),
        1.0,
        (),
        {
            "ram": (disc((0, 0, 0), 0.25, 0), bar((-0.05, 0, 0), (0.2, 0, 0), width=8)),
            "ground": (
                bar((0.201, -0.06, -0.06), (0.201, -0.06, 0.06), (0.201, 0.06, 0.06), (0.201, 0.06, -0.06), width=None),
            ),
        },
    ),
    "rocking_cabinet": Sketch(
        FLAT,
        1.0,
        (0.48, 0.85),
        {"cabinet": box(0.3, 0.25, 1.0), "ground": (bar((-1.1, 0, -0.01), (0.5, 0, -0.01), width=4),)},
        ("top",),
    ),
    "stick_slip": Sketch(
        FLAT,
        1.5,
        (),
        {
            "block": box(0.03, 0.03, 0.03),
            "belt": (bar((-0.35, 0, 0), (0.15, 0, 0), width=5),),
            "ground": (
                bar((-0.25, 0, 0.015), (-0.25, 0, 0.055), width=5),
                bar(*((-0.25 + 0.22 * k / 12, 0, 0.035 + 0.01 * (-1) ** k) for k in range(13)), width=1.5),
            ),
        },
    ),
    "door_closer": Sketch(
        (-65.0, 28.0),
        6.0,
        (1.0, 2.0),
        {
            "leaf": box(0.45, 0.02, 1.0),
            "ground": (bar((0, 0, 0), (0, 0, 2.05), (0.93, 0, 2.05), (0.93, 0, 0), width=5),),
        },
    ),
    "newtons_cradle": Sketch(
        FLAT,
        0.9,
        (0.45,),
        {"ball_*": (bar((0, 0, 0.2), (0, 0, 0), width=1.5), disc((0, 0, 0), 0.025, 1))},
        hangs=True,
    ),
    "physical_pendulum": Sketch(FLAT, 1.4, (0.3, 0.5, 0.7), hangs=True),
    "double_pendulum": Sketch(FLAT, 3.0, (0.3, 0.45, 0.6), hangs=True),
    "five_bar": Sketch(FLAT, 2.0, (0.4, 0.7, 1.0), hangs=True),
    "spherical_pendulum": Sketch((-60.0, 25.0), 5.0, hangs=True),
    "free_body": Sketch(
        (-60.0, 20.0),
        4.9,
        (),
        {
            "handle": (
                bar((-0.08, -1 / 60, 0), (0.08, -1 / 60, 0), width=12),
                bar((0, 0, 0), (0, 1 / 12, 0), width=10),
            ),
        },
        ("tip",),
    ),
    "heavy_top": Sketch(
        (20.0, 20.0),
        4.1,
        (),
        {
            "top": (
                bar((0, 0, -1), (0, 0, 0), width=5),
                disc((0, 0, 0), 0.25, 2),
                bar((0, 0, 0), (0, 0, 0.15), width=5),
            ),
        },
    ),
    "planar_four_bar": Sketch(
        FLAT,
        1.0,
        (),
        {
            "coupler": (bar((-0.15, 0, 0), (0.15, 0, 0), (0, 0, 0.12), width=None), bar((-0.15, 0, 0), (0.15, 0, 0))),
        },
    ),
    "spatial_four_bar": Sketch((-25.0, 25.0), 0.5),
    "spatial_slider_crank": Sketch(
        (-60.0, 20.0),
        2.0,
        (),
        {
            "slider": box(0.025, 0.018, 0.018),
            "ground": (bar((0.1, 0, -0.02), (0.36, 0, -0.02), width=3),),
        },
    ),
    "hooke_shaft": Sketch(
        (-75.0, 32.0),
        0.7,
        (),
        {
            "driving": (
                bar((-0.25, 0, 0), (0.2, 0, 0), width=7),
                disc((0.2, 0, 0), 0.1, 0),
                bar((0.2, 0, 0), (0.2, 0.05, 0), (0.25, 0.05, 0), width=4),
                bar((0.2, 0, 0), (0.2, -0.05, 0), (0.25, -0.05, 0), width=4),
            ),
            "driven": (
                bar((-0.2, 0, 0), (0.25, 0, 0), width=7),
                disc((0.05, 0, 0), 0.1, 0),
                bar((-0.2, 0, 0), (-0.2, 0, 0.05), (-0.25, 0, 0.05), width=4),
                bar((-0.2, 0, 0), (-0.2, 0, -0.05), (-0.25, 0, -0.05), width=4),
            ),
            "block": box(0.03, 0.03, 0.03),
            "ground": (bar((0.346, 0.2, -0.035), (0.52, 0.3, -0.035), width=5),),
        },
    ),
    "stewart_platform": Sketch(
        (-65.0, 18.0),
        0.5,
        (),
        {
            "cylinder*": (bar((0, 0, -0.25), (0, 0, 0.22), width=9),),
            "piston*": (bar((0, 0, -0.25), (0, 0, 0.25), width=4),),
            "ground": (disc((0, 0, 0), 0.66, 2),),
        },
    ),
    "inline_four": Sketch(
        (-55.0, 15.0),
        0.04,
        (),
        {
            "crankshaft": (
                bar(
                    (-0.2, 0, 0),
                    (-0.15, 0, 0),
                    (-0.15, -0.0215, 0.037),
                    (-0.12, -0.0215, 0.037),
                    (-0.12, 0, 0),
                    (-0.06, 0, 0),
                    (-0.06, 0.0215, -0.037),
                    (-0.03, 0.0215, -0.037),
                    (-0.03, 0, 0),
                    (0.03, 0, 0),
                    (0.03, 0.0215, -0.037),
                    (0.06, 0.0215, -0.037),
                    (0.06, 0, 0),
                    (0.12, 0, 0),
                    (0.12, -0.0215, 0.037),
                    (0.15, -0.0215, 0.037),
                    (0.15, 0, 0),
                    (0.2, 0, 0),
                ),
                disc((0.2, 0, 0), 0.1, 0),
            ),
            "rod*": (bar((0, 0, -0.04), (0, 0, 0.1), width=5),),
            "piston*": box(0.03, 0.03, 0.02),
        },
        ("rod_centre",),
    ),
    "bennett": Sketch(
        (-50.0, 30.0),
        1.0,
        (),
        {
            "crank": (bar((-0.05, 0, 0), (0.05, 0, 0)), bar((-0.05, 0, -0.02), (-0.05, 0, 0.02), width=4)),
            "coupler": (bar((-0.0731, 0, 0), (0.0731, 0, 0)), bar((-0.0731, 0, -0.02), (-0.0731, 0, 0.02), width=4)),
            "rocker": (
                bar((-0.05, 0, 0), (0.05, 0, 0)),
                bar((0.05, 0, -0.02), (0.05, 0, 0.02), width=4),
                bar((-0.05, -0.013, -0.015), (-0.05, 0.013, 0.015), width=4),
            ),
        },
    ),
    "bricard": Sketch(
        (25.0, 25.0),
        0.8,
        (),
        {
            "bar1": (bar((0.1, 0, 0), (-0.1, 0, 0)), bar((0.1, 0, -0.03), (0.1, 0, 0.03), width=4)),
            "bar2": (bar((0, 0, -0.1), (0, 0, 0.1)), bar((0, -0.03, -0.1), (0, 0.03, -0.1), width=4)),
            "bar3": (bar((0, 0.1, 0), (0, -0.1, 0)), bar((-0.03, 0.1, 0), (0.03, 0.1, 0), width=4)),
            "bar4": (bar((-0.1, 0, 0), (0.1, 0, 0)), bar((-0.1, 0, -0.03), (-0.1, 0, 0.03), width=4)),
            "bar5": (bar((0, 0, 0.1), (0, 0, -0.1)), bar((0, -0.03, 0.1), (0, 0.03, 0.1), width=4)),
            "ground": (bar((0.2, 0, 0), (0.2, 0.2, 0)), bar((0.17, 0, 0), (0.23, 0, 0), width=4)),
        },
    ),
    "n_four_bar": Sketch(FLAT, 2.2, (0.55, 0.8)),
    "massless_coupler": Sketch(
        FLAT,
        0.5,
        (),
        {
            "crank": (bar((-0.02, 0, 0), (0.08, 0, 0), width=9),),
            "rod": (bar((-0.15, 0, 0), (0.15, 0, 0), width=3),),
            "piston": box(0.035, 0.03, 0.03),
            "ground": (bar((0.16, 0, -0.035), (0.44, 0, -0.035), width=3),),
        },
    ),
    "split_coupler": Sketch(
        FLAT,
        0.6,
        (),
        {
            "near_half": (bar((-0.075, 0, 0), (0.068, 0, 0)), bar((0.068, 0, -0.02), (0.068, 0, 0.02), width=3)),
            "far_half": (
                bar((-0.068, 0, 0), (0.075, 0, 0)),
                bar((-0.068, 0, -0.02), (-0.068, 0, 0.02), width=3),
                bar((-0.075, 0, -0.012), (-0.075, 0, 0.012), width=14),
            ),
        },
    ),
    "governor": Sketch(
        (-90.0, 12.0),
        0.6,
        (),
        {
            "spindle": (bar((0, 0, 0.14), (0, 0, -0.12), width=5), bar((-0.03, 0, 0.1), (0.03, 0, 0.1), width=5)),
            "right": (bar((0, 0, 0.2), (0, 0, 0), width=5), disc((0, 0, 0), 0.03, 0), disc((0, 0, 0), 0.03, 1)),
            "left": (bar((0, 0, 0.2), (0, 0, 0), width=5), disc((0, 0, 0), 0.03, 0), disc((0, 0, 0), 0.03, 1)),
            "collar": (
                *box(0.03, 0.03, 0.012),
                *(bar((side * 0.03, 0, 0), (side * 0.0723, 0, 0.0906), width=3) for side in (1, -1)),
            ),
        },
    ),
    "quarter_car": Sketch(
        (35.0, 14.0),
        0.8,
        (),
        {
            "body": (
                bar((0.15, 0.3, -0.335), (-0.15, 0.3, -0.33), width=4),
                bar((0.12, 0.355, -0.05), (-0.12, 0.345, -0.065), width=4),
                bar((0, 0.3, -0.3325), (0, 0.35, -0.0575), (0, 0.38, 0.13), width=5),
            ),
            "lower_arm": (
                bar((0.15, -0.12, 0.008), (0.005, 0.18, -0.012), (-0.15, -0.12, 0.003)),
                bar(*((0.02 * (-1) ** k, 0.08 - 0.015 * k, 0.059 * k) for k in range(9)), width=2),
            ),
            "upper_arm": (bar((0.125, -0.085, 0.013), (-0.005, 0.12, -0.007), (-0.115, -0.095, -0.002)),),
            "upright": (
                bar((0.005, -0.05, -0.1), (0, 0, 0), (-0.01, -0.09, 0.18)),
                bar((0.125, -0.07, -0.065), (0, -0.03, -0.05)),
                disc((0, 0, 0), 0.3, 1),
            ),
            "ground": (bar((-0.3, 0.5, 0), (0.3, 0.5, 0), (0.3, 1, 0), (-0.3, 1, 0), width=None),),
        },
    ),
    "locomotive": Sketch(
        (-70.0, 20.0),
        1.1,
        (),
        {
            "rear": (
                disc((0, -0.6, 0), 0.6, 1),
                disc((0, 0.6, 0), 0.6, 1),
                bar((0, -0.6, 0), (0, 0.6, 0), width=8),
                bar((0.3, -0.6, 0), (0.3, -0.7175, 0), width=5),
                bar((0, 0.6, 0.3), (0, 0.7175, 0.3), width=5),
            ),
            "front": (
                disc((0, -0.6, 0), 0.6, 1),
                disc((0, 0.6, 0), 0.6, 1),
                bar((0, -0.6, 0), (0, 0.6, 0), width=8),
                bar((0.3, -0.6, 0), (0.3, -0.7175, 0), width=5),
                bar((0, 0.6, 0.3), (0, 0.7175, 0.3), width=5),
            ),
        },
    ),
    "delta_robot": Sketch(
        (-50.0, 18.0),
        0.6,
        (),
        {
            "arm*": (bar((-0.15, 0, 0), (0.15, 0, 0), width=9), bar((0.15, -0.05, 0), (0.15, 0.05, 0), width=5)),
            "rod*": (bar((-0.35, 0, 0), (0.35, 0, 0), width=3),),
            "ground": (disc((0, 0, 0), 0.2, 2),),
        },
    ),
}
