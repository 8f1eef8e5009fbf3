"""Mechanisms of every shape from the joint table, closed at the scene's pose, states of them with open joints, and
runs."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.joints.table import JOINTS
from mbproj.kernel import build_info, core
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.system import System
from mbproj.motion.formulations.reduced import Reduced
from mbproj.motion.report import Report
from mbproj.motion.simulate import simulate
from mbproj.scene.records import Body, Joint, Marker, Pair
from mbproj.scene.scene import read_scene
from tests.support import (
    MASSLESS,
    MECHANISMS,
    REDUNDANT,
    Recorder,
    assembled,
    random_body,
    random_chain,
    random_coupling,
    random_joint,
    scene_of,
    with_flywheels,
)

# Mechanisms of every shape from the joint table, closed at the scene's pose, and states of them with open joints.

needs_kernel = pytest.mark.skipif(core() is None, reason=f"needs the compiled kernel: {build_info()}")

ARM_KINDS = ("spherical", "universal", "cylindrical", "revolute")
TREE_KINDS = ("revolute", "spherical", "universal", "prismatic", "cylindrical", "planar", "distance")


def grown(seed: int, count: int, parent: Callable[[int, np.random.Generator], int], extra: list[Joint]) -> Scene:
    """`count` bodies, each on a random joint from the body that `parent` names (-1: the ground), and further joints."""
    rng = np.random.default_rng(seed)
    bodies = [random_body(rng, f"b{number}") for number in range(count)]
    names = [*(body.name for body in bodies), "ground"]
    joints = [
        random_joint(rng, f"J{number}", str(rng.choice(TREE_KINDS)), (names[parent(number, rng)], names[number]))
        for number in range(count)
    ]
    return scene_of(bodies, [*joints, *extra])


def tree(seed: int, count: int = 8) -> Scene:
    """A tree, floating at one root and on the ground at others."""
    return grown(seed, count, lambda number, rng: int(rng.integers(-1, number)) if number else -1, [])


def loops(seed: int, count: int = 5) -> Scene:
    """A chain of joints that leave much free, closed three times over by further ones."""
    rng = np.random.default_rng(seed)
    kinds = rng.choice(["spherical", "universal", "cylindrical", "revolute_spherical", "planar"], size=count)
    scene = random_chain(seed, [str(kind) for kind in kinds])
    ends = [("ground", f"body{count - 1}"), ("body0", f"body{count - 2}"), ("body1", "ground")]
    closing = [
        random_joint(rng, f"L{number}", str(rng.choice(["spherical", "distance", "point_in_plane"])), pair)
        for number, pair in enumerate(ends)
    ]
    return scene_of(list(scene.bodies), [*scene.joints, *closing], list(scene.markers))


def star(seed: int, arms: int = 8) -> Scene:
    """Arms on one hub, every second of them held to the ground too, so that the hub has many joints in loops."""
    rng = np.random.default_rng(seed)
    held = [random_joint(rng, f"H{arm}", "distance", ("ground", f"b{arm}")) for arm in range(1, arms + 1, 2)]
    return grown(seed, arms + 1, lambda number, _: 0 if number else -1, held)


def shaft(seed: int, arms: int = 8, kinds: Sequence[str] = ARM_KINDS) -> Scene:
    """A shaft on the ground with arms, each held to the ground too: all joints in loops, most of them on the shaft."""
    rng = np.random.default_rng(seed)
    bodies = [random_body(rng, name) for name in ("shaft", *(f"b{arm}" for arm in range(arms)))]
    joints = [random_joint(rng, "S", "revolute", ("ground", "shaft"))]
    for arm in range(arms):
        joints.append(random_joint(rng, f"A{arm}", kinds[arm % len(kinds)], ("shaft", f"b{arm}")))
        joints.append(random_joint(rng, f"H{arm}", "distance", ("ground", f"b{arm}")))
    return scene_of(bodies, joints)


def ladder(seed: int, rungs: int) -> Scene:
    """Two chains of balls from the ground, side by side, and a rod between each pair of their bodies."""
    rng = np.random.default_rng(seed)
    bodies, joints, below = [], [], ["ground", "ground"]
    for rung in range(rungs):
        pair = [random_body(rng, f"{side}{rung}") for side in ("left", "right")]
        joints += [
            random_joint(rng, f"J{body.name}", "spherical", (under, body.name))
            for under, body in zip(below, pair, strict=True)
        ]
        below = [body.name for body in pair]
        joints.append(random_joint(rng, f"R{rung}", "distance", (below[0], below[1])))
        bodies += pair
    return scene_of(bodies, joints)


def rails(seed: int, rungs: int) -> Scene:
    """A frame that floats, and two rails and a rung that hang on it or on the rung before; of each loop 16 rows. A leaf
    hangs on every left rail. At the end a triangle: two bodies on the last rung, with a rod between them."""
    rng = np.random.default_rng(seed)
    bodies, joints = [random_body(rng, "rung")], []

    def join(kind: str, first: str, second: str) -> None:
        joints.append(random_joint(rng, f"J{len(joints)}", kind, (first, second)))

    for number in range(rungs):
        frame, left, right, rung, leaf = (
            bodies[-2].name if number else "rung", *(f"{name}{number}" for name in ("left", "right", "rung", "leaf"))
        )  # fmt: skip
        bodies += [random_body(rng, name) for name in (left, right, rung, leaf)]
        for kind, first, second in (
            ("revolute", frame, left), ("universal", right, frame), ("spherical", left, rung),
            ("universal", rung, right), ("cylindrical", left, leaf),
        ):  # fmt: skip
            join(kind, first, second)
    bodies += [random_body(rng, name) for name in ("one", "other")]
    for kind, first, second in (
        ("revolute", f"rung{rungs - 1}", "one"),
        ("cylindrical", "other", f"rung{rungs - 1}"),
        ("distance", "one", "other"),
    ):
        join(kind, first, second)
    return scene_of(bodies, joints)


def parallelogram(angle: float = 0.5, *, regular: bool = False) -> Scene:
    """Crank and rocker of 1 m at `angle` from the vertical, a coupler of 2 m, in the plane normal to y, no gravity: the
    crank turns evenly. Dead where all lie in one line. Of revolutes alone, unless `regular`: then nothing is
    redundant in space."""
    up, y = (float(np.sin(angle)), 0.0, float(np.cos(angle))), (0.0, 1.0, 0.0)
    moments = ((0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))
    corners = [(0.0, 0.0, 0.0), up, (2.0 + up[0], 0.0, up[2]), (2.0, 0.0, 0.0)]
    middles = {
        name: (0.5 * (a[0] + b[0]), 0.0, 0.5 * (a[2] + b[2]))
        for name, a, b in zip(("crank", "coupler", "rocker"), corners[:3], corners[1:], strict=True)
    }
    ends = [("ground", "crank"), ("crank", "coupler"), ("coupler", "rocker"), ("ground", "rocker")]
    kinds = ["revolute", "spherical", "universal", "revolute"] if regular else ["revolute"] * 4
    axes = {"revolute": Pair(y, y), "spherical": None, "universal": Pair((0.0, 0.0, 1.0), y)}
    joints = [
        Joint(name, kind, pair, Pair(at, at), axes[kind], speed={"angle": 2.0} if name == "A" else {})
        for name, kind, pair, at in zip("ABCD", kinds, ends, corners, strict=True)
    ]
    return scene_of([Body(name, 1.0, moments, at) for name, at in middles.items()], joints, gravity=(0.0, 0.0, 0.0))


#: Every mechanism to hold the formulations against each other on, by name.
SCENES: dict[str, Callable[[], Scene]] = {
    # What motions drive is in test_loads.py; what the full formulation refuses in tests/mechanisms.
    **{
        path.stem: lambda path=path: read_scene(path)
        for path in MECHANISMS
        if path.stem not in ("cam", "crane", "inline_four", "stick_slip", "turntable", *REDUNDANT, *MASSLESS)
    },
    **{f"three of {kind}": lambda kind=kind: random_chain(3, [kind] * 3) for kind in JOINTS},
    **{f"tree {seed}": lambda seed=seed: tree(seed) for seed in range(4)},
    **{f"loops {seed}": lambda seed=seed: loops(seed) for seed in range(6)},
    **{f"star {seed}": lambda seed=seed: star(seed) for seed in range(3)},
    "ladder": lambda: ladder(1, 4),
    "shaft with eight arms": lambda: shaft(1),
    "two loops of rails": lambda: rails(1, 2),
    "gears in a star": lambda: _geared_star(),
    **{
        f"three of {kind}, with flywheels": lambda kind=kind: with_flywheels(random_chain(3, [kind] * 3))
        for kind, joint in JOINTS.items()
        if joint.coordinates
    },
    **{f"tree {seed}, with flywheels": lambda seed=seed: with_flywheels(tree(seed)) for seed in range(4)},
    **{f"loops {seed}, with flywheels": lambda seed=seed: with_flywheels(loops(seed)) for seed in range(3)},
    "star, with flywheels": lambda: with_flywheels(star(0)),
    "shaft with eight arms, with flywheels": lambda: with_flywheels(shaft(1)),
    "two loops of rails, with flywheels": lambda: with_flywheels(rails(1, 2)),
    "gears in a star, with flywheels": lambda: with_flywheels(_geared_star()),
}


def _geared_star() -> Scene:
    """Three wheels on one carrier, geared to each other in a row."""
    rng = np.random.default_rng(7)
    bodies = [random_body(rng, name) for name in ("carrier", "a", "b", "c")]
    joints = [random_joint(rng, "C", "universal", ("ground", "carrier"))]
    joints += [random_joint(rng, name.upper() * 2, "revolute", ("carrier", name)) for name in "abc"]
    joints += [
        random_coupling("G1", "gear", ("AA", "BB"), ("a", "b")),
        random_coupling("G2", "gear", ("BB", "CC"), ("b", "c")),
    ]
    return scene_of(bodies, joints)


class Case(NamedTuple):
    """A system, the kernel's view of it, and a state (q, v) with unit Λ and ΛᵀΛ' = 0, but open joints."""

    system: System
    reduced: Reduced
    q: np.ndarray
    v: np.ndarray

    @property
    def y(self) -> np.ndarray:
        return self.reduced.state(self.q, self.v)


def opened(scene: Scene, seed: int = 1, size: float = 0.03) -> Case:
    """Every body moved by `size` of the mechanism's length and by so many radians, and thrown about."""
    system = compile_system(scene)
    guess = initial_guess(scene, system)
    state = guess if scene.path is None else assemble(system, guess)  # what is generated here is closed
    rng = np.random.default_rng(seed)
    weights = np.array([system.length] * 3 + [1.0] * 4)
    q = state.q.reshape(-1, 7) + size * weights * rng.normal(size=(system.bodies, 7))
    q[:, 3:] /= np.linalg.norm(q[:, 3:], axis=1, keepdims=True)
    v = state.v.reshape(-1, 7) + weights * rng.normal(size=q.shape)
    v[:, 3:] -= np.sum(v[:, 3:] * q[:, 3:], axis=1, keepdims=True) * q[:, 3:]
    return Case(system, Reduced(core(), system), q.ravel(), v.ravel())


def shared_four_bars(loops: int) -> str:
    """Parallelograms in a row, each of three redundant rows, which share their rockers."""
    body = "{mass: 1, inertia: [0.1, 0.1, 0.1], position: [%g, 0, %g], velocity: [1, 0, 0]}"
    bodies = [f"rocker{k}: {body % (k, 0.5)}" for k in range(loops + 1)]
    bodies += [f"coupler{k}: {body % (k + 0.5, 1)}" for k in range(loops)]
    pairs = [("ground", f"rocker{k}", k, 0) for k in range(loops + 1)]
    pairs += [(f"rocker{k}", f"coupler{k}", k, 1) for k in range(loops)]
    pairs += [(f"coupler{k}", f"rocker{k + 1}", k + 1, 1) for k in range(loops)]
    joints = [
        f"j{k}: {{type: revolute, bodies: [{one}, {other}], location: [{x}, 0, {z}], axis: [0, 1, 0]}}"
        for k, (one, other, x, z) in enumerate(pairs)
    ]
    return "\n  ".join(["mbproj: 1\ngravity: [3, 2, -9.8]\nbodies:", *bodies]) + "\njoints:\n  " + "\n  ".join(joints)


# Runs of the shipped mechanisms in memory, and their bits.

PATHS = {path.stem: path for path in MECHANISMS}


def run(scene: Scene, **keys) -> tuple[Recorder, Report]:
    projection = ProjectionSettings(**keys.pop("projection", {}))
    recorder = Recorder()
    return recorder, simulate(*assembled(scene), Settings(projection=projection, **keys), recorder)


def mechanism(name: str) -> Scene:
    return read_scene(PATHS[name])


def bits(blocks: list[Mapping[str, np.ndarray]]) -> str:
    digest = hashlib.sha256()
    for path in sorted(blocks[0]):
        digest.update(np.concatenate([block[path] for block in blocks]).tobytes())
    return digest.hexdigest()


def print_bits() -> None:
    """For a process of its own."""
    print(*(bits(run(mechanism(name), duration=0.3, **keys)[0].blocks) for name, keys in REPEATED))


REPEATED = [
    ("five_bar", {"step": 0.01}),
    ("five_bar", {"step": 0.01, "formulation": "reduced"}),
    ("stewart_platform", {"tolerance": 1e-8, "integrator": "dopri5", "output_step": 0.01}),
]


# A wheel about a fixed axle, which turns evenly.

ROUND = ((0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01))


def spinner(speed: float):
    """A wheel about z without gravity."""
    wheel = Body("wheel", 1.0, ROUND, (0.0, 0.0, 0.0))
    axis = Pair((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    joint = Joint("axle", "revolute", ("ground", "wheel"), Pair((0.0,) * 3, (0.0,) * 3), axis, speed={"angle": speed})
    return scene_of([wheel], [joint], [Marker("rim", "wheel", (1.0, 0.0, 0.0))], gravity=(0.0, 0.0, 0.0))
