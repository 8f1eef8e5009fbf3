"""The paths of tendons over sites, pulleys, spheres and cylinders, as a rope of a scene runs: points and circles.

A scene's rope has a plane, MuJoCo's tendon has none. They are the same where all bodies that the tendon touches next to
a circle move in that plane."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.formats.chains import EXACT
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.formats.mjcf.joints import HINGE, SLIDE
from mbproj.formats.mjcf.parts import Called

#: Two places of a path on one body are the same where they are nearer to each other than this, in m.
ONE_PLACE = 1e-12


class Spot(NamedTuple):
    """A place of a path on the body `number` of the model: a global point, or the centre of a circle that the path
    bends around. `shape` is the number of the circle's geom."""

    number: int
    point: Array
    radius: float = 0.0
    left: bool = True
    shape: int = -1


@dataclass(frozen=True, eq=False)
class TendonBranch:
    """A part of a tendon between pulleys, whose length counts with a weight. It has its spots and its `length` at the
    start, the normal (3,) of its circles, and the body that carries them. `wrong` is the reason why no rope can run so.
    `passed` are the shapes that it does not touch."""

    weight: float
    spots: Sequence[Spot]
    length: float
    normal: Array | None = None
    carrier: int = 0
    wrong: str = ""
    passed: Sequence[str] = ()


def is_path(compiled: CompiledMjcf, number: int) -> bool:
    """Whether a tendon goes over sites, and is no sum of joint coordinates."""
    import mujoco

    first = int(compiled.model.tendon_adr[number])
    return int(compiled.model.wrap_type[first]) != int(mujoco.mjtWrap.mjWRAP_JOINT)


def branches_of(compiled: CompiledMjcf, called: Called, number: int) -> list[TendonBranch]:
    """The branches of a tendon over sites at the pose of the start."""
    divided = _divided(compiled, number)
    return [_branch(compiled, called, weight, items) for weight, items in divided if len(items) > 1]


class _Item(NamedTuple):
    """A site, or a shape with its side site (-1: none) and the points (2, 3) at which the tendon meets and leaves it;
    None where it does not."""

    site: int
    shape: int
    side: int
    touches: Array | None


def _divided(compiled: CompiledMjcf, number: int) -> Iterator[tuple[float, list[_Item]]]:
    """Yield the weight of each branch, and the sites and shapes over which it runs."""
    import mujoco

    model, data, of = compiled.model, compiled.data, mujoco.mjtWrap
    first = int(model.tendon_adr[number])
    at = int(data.ten_wrapadr[number])
    objects, points = data.wrap_obj.ravel(), data.wrap_xpos.reshape(-1, 3)
    weight, items = 1.0, list[_Item]()
    for each in range(first, first + int(model.tendon_num[number])):
        kind, what = int(model.wrap_type[each]), int(model.wrap_objid[each])
        if kind == int(of.mjWRAP_PULLEY):
            yield weight, items
            weight, items, at = 1.0 / float(model.wrap_prm[each]), [], at + 1
        elif kind == int(of.mjWRAP_SITE):
            items.append(_Item(what, -1, -1, None))
            at += 1
        else:
            met = int(objects[at]) == what
            side = round(float(model.wrap_prm[each]))
            items.append(_Item(-1, what, side, np.array(points[at : at + 2]) if met else None))
            at += 2 if met else 0
    yield weight, items


def _branch(compiled: CompiledMjcf, called: Called, weight: float, items: list[_Item]) -> TendonBranch:
    model, data = compiled.model, compiled.data
    passed = [_called(compiled, each) for each in items if each.shape >= 0 and each.touches is None]
    kept = [each for each in items if each.shape < 0 or each.touches is not None]
    sites = [Spot(int(model.site_bodyid[each.site]), np.array(data.site_xpos[each.site])) for each in kept]
    circles = [at for at, each in enumerate(kept) if each.shape >= 0]
    if not circles:
        length = sum(float(np.linalg.norm(end.point - start.point)) for start, end in pairwise(sites))
        return TendonBranch(weight, _without_repeats(called, sites), length, passed=passed)
    axes = [_axis(compiled, kept[at], sites[at - 1].point, sites[at + 1].point) for at in circles]
    normal = axes[0]
    carrier = int(model.geom_bodyid[kept[circles[0]].shape])
    for at, axis in zip(circles, axes, strict=True):
        circle, beside = kept[at], (sites[at - 1], sites[at + 1])
        wrong = _inside(compiled, circle) or _out_of_plane(compiled, circle, beside, normal, axis, carrier)
        if wrong:
            return TendonBranch(weight, sites, 0.0, wrong=wrong, passed=passed)
        sites[at] = _circle(compiled, circle, beside, normal)
    length = _length(kept, sites, normal)
    return TendonBranch(weight, _without_repeats(called, sites), length, normal, carrier, passed=passed)


def _called(compiled: CompiledMjcf, item: _Item) -> str:
    return compiled.name("geom", item.shape) or f"geom {item.shape}"


def _length(kept: list[_Item], spots: list[Spot], normal: Array) -> float:
    """The length of a path in m, with the arcs on its circles, each less than a turn."""
    total, last = 0.0, spots[0].point
    for item, spot in zip(kept, spots, strict=True):
        first, second = (spot.point, spot.point) if item.touches is None else item.touches
        total += float(np.linalg.norm(first - last))
        if item.touches is not None:
            start, end = first - spot.point, second - spot.point
            angle = float(np.arctan2(np.cross(start, end) @ normal, start @ end))
            total += spot.radius * (angle if spot.left else -angle) % (2.0 * np.pi * spot.radius)
        last = second
    return total


def _without_repeats(called: Called, spots: list[Spot]) -> list[Spot]:
    """The spots without points that are at the place of the point before, on the same body."""
    distinct = spots[:1]
    for spot in spots[1:]:
        last = distinct[-1]
        same = called[spot.number] == called[last.number] and not (spot.radius or last.radius)
        if not (same and np.linalg.norm(spot.point - last.point) < ONE_PLACE):
            distinct.append(spot)
    return distinct


def _axis(compiled: CompiledMjcf, item: _Item, before: Array, after: Array) -> Array:
    """The unit normal of the plane in which the tendon bends around a shape."""
    if _is_cylinder(compiled, item):
        return np.array(compiled.data.geom_xmat[item.shape].reshape(3, 3)[:, 2])
    assert item.touches is not None
    centre = compiled.data.geom_xpos[item.shape]
    arms = [before - centre, after - centre, *(point - centre for point in item.touches)]
    normals = [np.cross(one, other) for at, one in enumerate(arms) for other in arms[at + 1 :]]
    best = max(normals, key=lambda each: float(np.linalg.norm(each)))
    return np.asarray(best / np.linalg.norm(best))


def _inside(compiled: CompiledMjcf, item: _Item) -> str:
    """The reason why no rope runs so, where the side site is inside of a shape, which keeps the tendon inside; else
    ""."""
    if item.side < 0:
        return ""
    data, model = compiled.data, compiled.model
    arm = data.geom_xmat[item.shape].reshape(3, 3).T @ (data.site_xpos[item.side] - data.geom_xpos[item.shape])
    arm = arm[:2] if _is_cylinder(compiled, item) else arm
    return (
        f"it runs inside of '{_called(compiled, item)}'" if np.linalg.norm(arm) < model.geom_size[item.shape][0] else ""
    )


def _out_of_plane(
    compiled: CompiledMjcf, item: _Item, beside: tuple[Spot, Spot], normal: Array, axis: Array, carrier: int
) -> str:
    """The reason why no rope runs so, where the tendon, or the motion of a body that it touches, leaves the plane with
    this normal; else ""."""
    model, data = compiled.model, compiled.data
    name = _called(compiled, item)
    if np.linalg.norm(np.cross(normal, axis)) > EXACT:
        return f"its shapes lie in several planes, that of '{name}' too"
    heights = [float(normal @ spot.point) for spot in beside]
    if not _is_cylinder(compiled, item):
        heights.append(float(normal @ data.geom_xpos[item.shape]))
    if max(heights) - min(heights) > EXACT:
        return f"it runs around '{name}' along a helix, and a rope in a plane"
    for number in (int(model.geom_bodyid[item.shape]), *(spot.number for spot in beside)):
        if not _stays(model, data, number, carrier, normal):
            return f"what it touches moves out of the plane of '{name}', and a rope stays in it"
    return ""


def _is_cylinder(compiled: CompiledMjcf, item: _Item) -> bool:
    import mujoco

    return int(compiled.model.geom_type[item.shape]) == int(mujoco.mjtGeom.mjGEOM_CYLINDER)


def _stays(model: Any, data: Any, one: int, other: int, normal: Array) -> bool:
    """Whether the relative motion of two bodies is in the plane: turns about its normal, and slides normal to that."""
    for joint in above(model, one) ^ above(model, other):
        kind, axis = int(model.jnt_type[joint]), data.xaxis[joint]
        if kind not in (HINGE, SLIDE):
            return False
        if (np.linalg.norm(np.cross(axis, normal)) if kind == HINGE else abs(axis @ normal)) > EXACT:
            return False
    return True


def above(model: Any, number: int) -> set[int]:
    """The numbers of the joints between a body and the ground."""
    joints: set[int] = set()
    while number:
        first = int(model.body_jntadr[number])
        joints |= set(range(first, first + int(model.body_jntnum[number])))
        number = int(model.body_parentid[number])
    return joints


def _circle(compiled: CompiledMjcf, item: _Item, beside: tuple[Spot, Spot], normal: Array) -> Spot:
    """The circle of a shape in the plane of the tendon, with the side to which the tendon bends."""
    model, data = compiled.model, compiled.data
    assert item.touches is not None
    centre = np.array(data.geom_xpos[item.shape])
    centre += normal * (normal @ (beside[0].point - centre))
    first = item.touches[0]
    left = float(np.cross(first - centre, first - beside[0].point) @ normal) > 0.0
    return Spot(int(model.geom_bodyid[item.shape]), centre, float(model.geom_size[item.shape][0]), left, item.shape)
