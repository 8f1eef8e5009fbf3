"""What hypothesis draws: trees of bodies with loops and forces, by topology and types; numbers follow from the seed."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

from mbproj.joints.table import JOINTS

#: Types of joints that make the tree and those that close its loops, in space and where all stay in a plane. Those that
#: need a curve, a plane or a path have tests of their own.
FRAMES = ("point", "axis", "axes", "normal")
TREE = tuple(
    name
    for name, joint in JOINTS.items()
    if joint.frame in FRAMES and joint.x_axis != "required" and "curve" not in joint.parameters
)
LOOP = (*(name for name in TREE if name != "fixed"), "gear")
FLAT_TREE = ("revolute", "prismatic", "planar", "fixed")
FLAT_LOOP = (
    "revolute",
    "prismatic",
    "spherical",
    "universal",
    "cylindrical",
    "distance",
    "revolute_spherical",
    "point_in_plane",
    "point_on_line",
    "gear",
)
BETWEEN = ("spring_damper", "torsion_spring_damper", "linear_spring_damper", "friction")
FORCES = (*BETWEEN, "force", "torque")
MOST_BODIES, MOST_LOOPS, MOST_FORCES = 6, 3, 3
#: Masses are 1 to 10 times these powers of ten, kg.
DECADES = (-3, 2)


@dataclass(frozen=True)
class Limb:
    """A body on a joint of a type: `parent` picks one of the bodies before it or the ground; `decade` of its mass."""

    kind: str
    parent: int
    decade: int


@dataclass(frozen=True)
class Link:
    """A joint that closes a loop, or a force; the numbers pick bodies or joints."""

    kind: str
    first: int
    second: int


@dataclass(frozen=True)
class Plan:
    """A mechanism but for its numbers. `flat`: in a plane; `floating`: without a joint or a force to the ground."""

    flat: bool
    floating: bool
    gravity: bool
    limbs: tuple[Limb, ...]
    loops: tuple[Link, ...]
    forces: tuple[Link, ...]
    seed: int


@st.composite
def plans(draw: st.DrawFn) -> Plan:
    """Any plan, the simplest a single pinned or free body."""
    flat = draw(st.integers(0, 2)) == 2
    floating = not flat and draw(st.integers(0, 3)) == 3
    number, pick = st.integers(0, MOST_BODIES), st.sampled_from
    limb = st.builds(Limb, pick(FLAT_TREE if flat else TREE), number, st.integers(*DECADES))
    loop = st.builds(Link, pick(FLAT_LOOP if flat else LOOP), number, number)
    force = st.builds(Link, pick(BETWEEN if floating else FORCES), number, number)
    bodies, loops, forces = (draw(st.integers(*span)) for span in ((1, MOST_BODIES), (0, MOST_LOOPS), (0, MOST_FORCES)))
    return Plan(
        flat,
        floating,
        draw(st.booleans()),
        draw(st.tuples(*[limb] * bodies)),
        draw(st.tuples(*[loop] * loops)),
        draw(st.tuples(*[force] * forces)),
        draw(st.integers(0, 10**6)),
    )
