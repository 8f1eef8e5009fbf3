"""Variants with uneven masses or moments of inertia: every second body, counted from the ground, is heavier."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace

from mbproj.errors import InputError, Problem
from mbproj.scene.read import Scene
from mbproj.scene.records import GROUND, Body
from mbproj.studies.variants.rescaled import scaled_matrix


def with_mass_ratio(scene: Scene, r: float) -> Scene:
    """Multiply mass and inertia by √r for bodies at an odd number of joints from the ground, and by 1/√r for the
    others."""
    return _alternating(
        scene,
        r,
        "mass",
        lambda body, factor: replace(body, mass=factor * body.mass, inertia=scaled_matrix(factor, body.inertia)),
    )


def with_inertia_ratio(scene: Scene, r: float) -> Scene:
    """Multiply only the inertia by √r for bodies at an odd number of joints from the ground, and by 1/√r for the
    others."""
    return _alternating(
        scene, r, "inertia", lambda body, factor: replace(body, inertia=scaled_matrix(factor, body.inertia))
    )


def _alternating(scene: Scene, r: float, what: str, changed: Callable[[Body, float], Body]) -> Scene:
    distance = joints_from_ground(scene)
    if len({number % 2 for number in distance.values()}) < 2:
        said = f"no two bodies are joined to each other: there is no {what} ratio between neighbours"
        raise InputError(Problem(said, hint="vary something else, 'step' for example"))
    factors = {name: r**0.5 if number % 2 else r**-0.5 for name, number in distance.items()}
    return replace(scene, bodies=tuple(changed(body, factors[body.name]) for body in scene.bodies))


def joints_from_ground(scene: Scene) -> dict[str, int]:
    """The number of joints on the shortest path from the ground to each body. In a group of bodies that is not joined
    to the ground, the first body counts as one joint away."""
    ways: dict[str, list[str]] = {name: [] for name in (GROUND, *(body.name for body in scene.bodies))}
    for joint in scene.joints:
        first, second = joint.bodies
        ways[first].append(second)
        ways[second].append(first)
    distance = {GROUND: 0}
    for start in (GROUND, *ways):
        waiting = deque([start])
        distance.setdefault(start, 1)
        while waiting:
            name = waiting.popleft()
            for other in ways[name]:
                if other not in distance:
                    distance[other] = distance[name] + 1
                    waiting.append(other)
    return {name: number for name, number in distance.items() if name != GROUND}
