"""Planar chains of five bars of 1 m whose masses alternate while their moments are alike, with open joints.

Heavy bars that turn easily leave closing the joints to turns about their centres. Where two of these are further apart
than the bars between them reach, turns alone cannot close them, and Newton's method without damping fails in one of
seven random poses from a mass ratio of 1e6 on.
"""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.assembly.compiled import compile_system
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.model.system import System
from mbproj.scene.records import Body, Joint, Pair
from tests.support import scene_of

#: mbproj.motion.projection's methods that have a penalty need one to suit the masses.
PENALISED = ("mass-orthogonal", "mmopm")
BARS = 5
AXIS = (0.0, 1.0, 0.0)


def uneven_chain(ratio: float, seed: int, open_by: float = 1e-2) -> tuple[System, Plane, Array]:
    """A chain in a random pose, its plane, and q (7n,) with the bars off by `open_by`, in m and rad."""
    rng = np.random.default_rng(seed)
    bodies, joints, end, below = [], [], np.zeros(3), "ground"
    for number, angle in enumerate(rng.uniform(0.0, 2.0 * np.pi, size=BARS)):
        along = np.array([np.sin(angle), 0.0, np.cos(angle)])
        at, centre = ((float(x), 0.0, float(z)) for x, _, z in (end, end + 0.5 * along))
        turn = (float(np.cos(0.5 * angle)), 0.0, float(np.sin(0.5 * angle)), 0.0)
        moments = ((1 / 12, 0.0, 0.0), (0.0, 1 / 12, 0.0), (0.0, 0.0, 1 / 12))
        bodies.append(Body(f"bar{number}", 1.0 if number % 2 else ratio, moments, centre, turn))
        joints.append(Joint(f"J{number}", "revolute", (below, f"bar{number}"), Pair(at, at), Pair(AXIS, AXIS)))
        end, below = end + along, f"bar{number}"
    system = compile_system(scene_of(bodies, joints))
    q = np.array([[*body.position, *body.orientation] for body in bodies]).ravel()
    plane = planar_reduction(system, q)
    assert isinstance(plane, Plane)
    p, u = plane.reduce(q, np.zeros_like(q))
    return system, plane, plane.expand(p + open_by * rng.normal(size=p.shape), u, np.zeros_like(u))[0]


def suited(method: str, ratio: float, **keys: object) -> ProjectionSettings:
    """A method's settings for masses up to `ratio` kg."""
    alpha = max(1e7, 1e2 * ratio) if method in PENALISED else None
    return ProjectionSettings(method=method, **{"alpha": alpha, **keys})
