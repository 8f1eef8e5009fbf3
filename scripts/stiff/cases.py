"""The mechanisms: each a scene from its dial k, in N/m where it says nothing else."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from mbproj.base.arrays import Array
from mbproj.scene.scene import Scene, read_scene, read_scene_text

MECHANISMS = Path(__file__).parents[2] / "mechanisms"


def four_bar(k: float) -> Scene:
    """A four-bar in the plane whose coupler a bushing holds together; of 1e5 N/m as it is written."""
    return read_scene(MECHANISMS / "split_coupler.yaml", {"softness": str(1e5 / k)})


def ringing(k: float) -> Scene:
    """The same without its damping."""
    text = (MECHANISMS / "split_coupler.yaml").read_text(encoding="utf-8")
    before, _, after = text.partition("    damping:\n")
    return read_scene_text(f"{before}markers:{after.partition('markers:')[2]}", parameters={"softness": str(1e5 / k)})


def rsup(k: float) -> Scene:
    """The spatial slider-crank (R-S-U-P) of `mechanisms`, its rod of 0.3 m in two halves, which a bushing of k, and of
    k/100 N m/rad, holds together: as the rigid rod moves, to begin with."""
    crank_end, slider, omega = np.array([0.0, 0.1, 0.2]), np.array([0.2, 0.0, 0.0]), np.array([6.0, 0.0, 0.0])
    along, pin = slider - crank_end, np.array([0.0, -2.0, 1.0])
    frame = np.column_stack([along / 0.3, pin / np.sqrt(5.0), np.cross(along / 0.3, pin / np.sqrt(5.0))])
    end_velocity = np.cross(omega, [0.0, 0.0, 0.08])
    slides = float(end_velocity @ along / along[0])
    # ω x along = the velocity of the slider less that of the crank's end; the pin stays square to the slider's x axis.
    equations = np.vstack([np.cross(np.eye(3), along).T, np.cross(pin, [1.0, 0.0, 0.0])])
    turn = np.linalg.lstsq(equations, np.append([slides, 0.0, 0.0] - end_velocity, 0.0), rcond=None)[0]
    halves = []
    for name, part in (("near", 0.25), ("far", 0.75)):
        keys = {
            "mass": "0.25",
            "inertia": "[2.0e-4, 5.9e-4, 5.9e-4]",
            "position": _vector(crank_end + part * along),
            "orientation": f"{{matrix: [{', '.join(_vector(row) for row in frame)}]}}",
            "velocity": _vector(end_velocity + np.cross(turn, part * along)),
            "angular_velocity": _vector(frame.T @ turn),
        }
        halves.append(f"  {name}: {_mapping(keys)}")
    middle = _vector(crank_end + 0.5 * along)
    return read_scene_text(
        "\n".join(
            [
                "mbproj: 1\ngravity: [0, 0, -9.8]\nbodies:",
                "  crank: {mass: 0.12, inertia: [1.0e-4, 1.0e-4, 1.0e-5], position: [0, 0.1, 0.12]}",
                *halves,
                "  slider: {mass: 2, inertia: [1.0e-4, 1.0e-4, 1.0e-4], position: [0.2, 0, 0], "
                f"velocity: [{slides!r}, 0, 0]}}",
                "joints:",
                "  A: {type: revolute, bodies: [ground, crank], location: [0, 0.1, 0.12], axis: [1, 0, 0], speed: 6}",
                "  B: {type: spherical, bodies: [crank, near], location: [0, 0.1, 0.2]}",
                "  C: {type: universal, bodies: [far, slider], location: [0.2, 0, 0], axes: [[0, -2, 1], [1, 0, 0]]}",
                "  D: {type: prismatic, bodies: [ground, slider], location: [0.2, 0, 0], axis: [1, 0, 0]}",
                "forces:",
                f"  rubber: {_bushing('near', 'far', middle, k, 1e-2 * k, 1e-4)}",
            ]
        )
        + "\n"
    )


def governor(k: float) -> Scene:
    """With a damper in proportion."""
    return read_scene(MECHANISMS / "governor.yaml", {"stiffness": str(k), "damping": str(1e-3 * k)})


def chain(k: float, links: int = 4) -> Scene:
    """Links of 0.2 m and 0.1 kg from a pin, with torsion springs of k N m/rad and dampers of k/1000 between them."""
    inertia = "[1.0e-5, 3.4e-4, 3.4e-4]"
    bodies = [f"  b{i}: {{mass: 0.1, inertia: {inertia}, position: [{0.2 * i + 0.1}, 0, 0]}}" for i in range(links)]
    pin = "type: revolute, location: [{x}, 0, 0], axis: [0, 1, 0]"
    names = ["ground", *(f"b{i}" for i in range(links))]
    joints = [f"  J{i}: {{{pin.format(x=0.2 * i)}, bodies: [{names[i]}, b{i}]}}" for i in range(links)]
    law = f"type: torsion_spring_damper, stiffness: {k}, damping: {1e-3 * k}"
    forces = [f"  k{i}: {{{law}, joint: J{i}}}" for i in range(1, links)]
    parts = ["mbproj: 1\ngravity: [0, 0, -9.81]\nbodies:", *bodies, "joints:", *joints, "forces:", *forces]
    return read_scene_text("\n".join(parts) + "\n")


def elastic_rod(k: float, pieces: int = 10) -> Scene:
    """A slider-crank of 0.15 m and 0.6 m in the x-z plane, from its dead centre at 10 rad/s. Its rod is in pieces that
    bushings of k and of k/10,000 N m/rad hold together."""
    crank, rod, speed = 0.15, 0.6, 10.0
    piece, mass, rate = rod / pieces, 0.5 / pieces, -speed * crank / rod
    moment = mass * piece**2 / 12.0
    names = [f"p{i}" for i in range(pieces)]
    bodies = ["  crank: {mass: 1, inertia: [1.0e-3, 5.0e-3, 5.0e-3], position: [0.075, 0, 0]}"]
    for i, name in enumerate(names):
        at = (i + 0.5) * piece
        bodies.append(
            f"  {name}: {{mass: {mass!r}, inertia: [1.0e-5, {moment!r}, {moment!r}], position: [{crank + at!r}, 0, 0], "
            f"velocity: [0, 0, {-speed * crank * (1.0 - at / rod)!r}], angular_velocity: [0, {rate!r}, 0]}}"
        )
    bodies.append(f"  slider: {{mass: 0.5, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [{crank + rod!r}, 0, 0]}}")
    pin, end = "axis: [0, 1, 0]", crank + rod
    joints = [
        f"  A: {{type: revolute, bodies: [ground, crank], location: [0, 0, 0], {pin}, speed: {speed}}}",
        f"  B: {{type: revolute, bodies: [crank, p0], location: [{crank}, 0, 0], {pin}}}",
        f"  C: {{type: revolute, bodies: [{names[-1]}, slider], location: [{end!r}, 0, 0], {pin}}}",
        f"  D: {{type: prismatic, bodies: [ground, slider], location: [{end!r}, 0, 0], axis: [1, 0, 0]}}",
    ]
    forces = [
        f"  f{i}: {_bushing(before, after, f'[{crank + (i + 1) * piece!r}, 0, 0]', k, 1e-4 * k, 1e-4)}"
        for i, (before, after) in enumerate(pairwise(names))
    ]
    parts = ["mbproj: 1\ngravity: [0, 0, -9.81]\nbodies:", *bodies, "joints:", *joints, "forces:", *forces]
    return read_scene_text("\n".join(parts) + "\n")


def belt(k: float) -> Scene:
    """A mass of 1 kg on a spring of 100 N/m, which a belt of 0.1 m/s carries away; k, in N s/m, is the slope of the law
    of friction."""
    law = f"-100*displacement - 5*tanh((displacement_dot - 0.1)*{k / 5.0})"
    return read_scene_text(
        "mbproj: 1\ngravity: [0, 0, 0]\n"
        "bodies: {mass: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}\n"
        "joints: {rail: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0]}}\n"
        f'forces: {{friction: {{type: linear_spring_damper, joint: rail, force: "{law}"}}}}\n'
    )


def _vector(numbers: Array) -> str:
    return f"[{', '.join(repr(float(number)) for number in numbers)}]"


def _mapping(keys: dict[str, str]) -> str:
    return f"{{{', '.join(f'{key}: {value}' for key, value in keys.items())}}}"


def _bushing(before: str, after: str, location: str, k: float, bends: float, loses: float) -> str:
    """Of k along each axis and of `bends` about it, with dampers of `loses` seconds times that."""
    both = {"stiffness": 1.0, "damping": loses}
    parts = {
        name: f"{{translation: {_vector(np.full(3, part * k))}, rotation: {_vector(np.full(3, part * bends))}}}"
        for name, part in both.items()
    }
    return _mapping({"type": "bushing", "bodies": f"[{before}, {after}]", "location": location} | parts)


CASES: dict[str, Callable[[float], Scene]] = {
    "four-bar": four_bar,
    "ringing": ringing,
    "rsup": rsup,
    "governor": governor,
    "chain": chain,
    "chain-100": partial(chain, links=100),
    "elastic-rod": elastic_rod,
    "belt": belt,
}
