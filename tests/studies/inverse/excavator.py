"""An excavator: boom, arm and bucket in a vertical plane, each moved by a cylinder, and its forces by hand."""

from __future__ import annotations

import numpy as np

MASS = np.array([1200.0, 500.0, 400.0])
MOMENT = np.array([2500.0, 400.0, 90.0])
LENGTH = np.array([5.0, 2.5, 1.2])
CENTRE = np.array([2.4, 1.1, 0.6])
GRAVITY = 9.81
#: Of each cylinder: its end on the link before, in the axes of that link from its joint, and its end on its own link.
BASE = np.array([[0.6, -0.4], [3.2, 0.7], [0.8, 0.4]])
ROD = np.array([[2.2, 0.5], [-0.6, 0.4], [-0.3, 0.25]])
#: θ(t) = mean + swing sin(2π t / 4 s + phase): angles of the joints, the first from the horizontal.
MEAN, SWING, PHASE = np.array([0.7, -1.4, -0.8]), np.array([0.25, 0.35, 0.5]), np.array([0.3, 1.1, 2.0])
RATE = 2.0 * np.pi / 4.0
NAMES = ("boom", "arm", "bucket")


def motion(t):
    """Angles of the joints and their first and second derivatives, (3, T) each."""
    phase = RATE * t + PHASE[:, None]
    return (
        MEAN[:, None] + SWING[:, None] * np.sin(phase),
        RATE * SWING[:, None] * np.cos(phase),
        -(RATE**2) * SWING[:, None] * np.sin(phase),
    )


def coordinates(t):
    """The joints' coordinates (T, 3): they count from the pose that the scene gives."""
    return (motion(t)[0] - motion(np.zeros(1))[0]).T


def direction(angle):
    """Along a link, and across it, in the plane (x, z)."""
    return np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])


def cylinder_forces(t):
    """By hand, (T, 3), positive where a cylinder pushes: the moments of inertia and weight about each joint of all that
    it carries, over how a cylinder lengthens with its angle."""
    θ, rate, bend = (np.cumsum(part, axis=0) for part in motion(t))
    relative = motion(t)[0]
    place, pushed = np.zeros((2, len(t))), np.zeros((2, len(t)))
    joints, centres, inertias = [], [], []
    for k in range(3):
        along, across = direction(θ[k])
        swung = across * bend[k] - along * rate[k] ** 2
        joints.append(place)
        centres.append(place + CENTRE[k] * along)
        inertias.append(MASS[k] * (pushed + CENTRE[k] * swung + np.array([[0.0], [GRAVITY]])))
        place, pushed = place + LENGTH[k] * along, pushed + LENGTH[k] * swung
    forces = []
    for k in range(3):
        torque = np.zeros(len(t))
        for carried in range(k, 3):
            arm = centres[carried] - joints[k]
            torque += MOMENT[carried] * bend[carried] + arm[0] * inertias[carried][1] - arm[1] * inertias[carried][0]
        along, across = direction(relative[k])
        before = np.array([LENGTH[k - 1] if k else 0.0, 0.0])
        rod = before[:, None] + ROD[k][0] * along + ROD[k][1] * across
        apart = rod - BASE[k][:, None]
        turned = ROD[k][0] * across - ROD[k][1] * along
        lengthens = np.sum(apart * turned, axis=0) / np.linalg.norm(apart, axis=0)
        forces.append(torque / lengthens)
    return np.stack(forces, axis=1)


def scene(*, driven: bool):
    """The mechanism; `driven` by motions of its joints, else free, with the cylinders as forces of nothing."""
    θ = np.cumsum(motion(np.zeros(1))[0][:, 0])
    bodies, joints, forces, motions, place = {}, {}, {}, {}, np.zeros(2)
    before, before_place, before_angle = "ground", np.zeros(2), 0.0
    for k, name in enumerate(NAMES):
        along, across = direction(θ[k])
        bodies[name] = {
            "mass": float(MASS[k]),
            "inertia": [1.0, float(MOMENT[k]), 1.0 + float(MOMENT[k])],
            "position": _in_space(place + CENTRE[k] * along),
            "orientation": {"axis": [0, -1, 0], "angle": float(θ[k])},
        }
        joints[f"{name}_pin"] = {
            "type": "revolute",
            "bodies": [before, name],
            "location": _in_space(place),
            "axis": [0, -1, 0],
        }
        ahead, beside = direction(before_angle)
        forces[f"{name}_cylinder"] = {
            "type": "spring_damper",
            "points": {
                before: _in_space(before_place + BASE[k][0] * ahead + BASE[k][1] * beside),
                name: _in_space(place + ROD[k][0] * along + ROD[k][1] * across),
            },
            "stiffness": 0.0,
        }
        if driven:
            at, start = f"{RATE!r}*t + {float(PHASE[k])!r}", f"sin({float(PHASE[k])!r})"
            motions[f"{name}_motion"] = {
                "joint": f"{name}_pin",
                "angle": f"{float(SWING[k])!r} * (sin({at}) - {start})",
            }
        before, before_place, before_angle = name, place, float(θ[k])
        place = place + LENGTH[k] * along
    found = {
        "mbproj": 1,
        "gravity": [0, 0, -GRAVITY],
        "simulation": {"duration": 4.0, "step": 0.02},
        "bodies": bodies,
        "joints": joints,
        "forces": forces,
        "markers": {"tooth": {"body": "bucket", "location": {"bucket": [float(LENGTH[2] - CENTRE[2]), 0, 0]}}},
    }
    return found | ({"motions": motions} if driven else {})


def _in_space(place):
    return [float(place[0]), 0.0, float(place[1])]
