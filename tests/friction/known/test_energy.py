"""Dry friction takes energy and never gives any: chains at random in space, with frictions of every kind."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.stops.runs import run

KINDS = ("revolute", "prismatic", "cylindrical", "screw")


def law(rng, unit):
    """The keys of a friction on a coordinate in this unit: constant or by the force, with and without Stribeck."""
    keys = {}
    if rng.random() < 0.5:
        keys["torque" if unit == "rad" else "force"] = size = rng.uniform(0.2, 1.0)
    else:
        keys["coefficient"] = size = rng.uniform(0.05, 0.2)
        keys["preload"] = rng.uniform(0.0, 1.0)
        if unit == "rad":
            keys["radius"] = rng.uniform(0.02, 0.1)
    if rng.random() < 0.7:
        keys["static"] = size * rng.uniform(1.1, 1.5)
        if rng.random() < 0.7:
            keys["stribeck_speed"] = rng.uniform(0.05, 0.5)
    return "{" + ", ".join(f"{key}: {value}" for key, value in keys.items()) + "}"


def chain(seed, steps):
    """Three bodies that hang on each other by joints of three types, moving, each with friction on its coordinates."""
    rng = np.random.default_rng(seed)
    bodies, joints, forces, before = [], [], [], "ground"
    place = np.zeros(3)
    for number, kind in enumerate(rng.permutation(KINDS)[:3]):
        axis, here = rng.normal(size=3), place.copy()
        place = place + rng.uniform(-0.3, 0.3, size=3)
        at = ", ".join(map(repr, map(float, place)))
        turn = ", ".join(map(repr, map(float, Rotation.random(random_state=int(rng.integers(1000))).as_rotvec())))
        bodies.append(f"  b{number}: {{mass: 1, inertia: [0.1, 0.12, 0.15], position: [{at}],")
        bodies.append(f"    orientation: {{axis: [{turn}], angle: 1}}}}")
        units = {"revolute": {"angle": "rad"}, "prismatic": {"displacement": "m"}}.get(
            kind, {"angle": "rad", "displacement": "m"}
        )
        speeds = {name: rng.uniform(-1.0, 1.0) for name in units}
        if kind == "screw":
            speeds = {"angle": rng.uniform(-1.0, 1.0)}
        speed = f"{{{', '.join(f'{k}: {v}' for k, v in speeds.items())}}}" if len(units) > 1 else speeds.popitem()[1]
        pitch = ", pitch: 0.3" if kind == "screw" else ""
        where = ", ".join(map(repr, map(float, here)))
        along = ", ".join(map(repr, map(float, axis)))
        joints.append(
            f"  j{number}: {{type: {kind}, bodies: [{before}, b{number}], location: [{where}], axis: [{along}],"
        )
        joints.append(f"    speed: {speed}{pitch}}}")
        laws = {name: law(rng, unit) for name, unit in units.items()}
        coulomb = f"{{{', '.join(f'{k}: {v}' for k, v in laws.items())}}}" if len(units) > 1 else laws.popitem()[1]
        forces.append(f"  f{number}: {{type: friction, joint: j{number}, coulomb: {coulomb}}}")
        before = f"b{number}"
    return "\n".join(
        [
            "mbproj: 1",
            "gravity: [0, 0, -9.81]",
            f"simulation: {{duration: 0.6, {steps}}}",
            "bodies:",
            *bodies,
            "joints:",
            *joints,
            "forces:",
            *forces,
        ]
    )


@pytest.mark.parametrize("seed", range(4))
def test_energy_never_grows_and_the_balance_closes(seed):
    steps = "integrator: dop853, tolerance: 1.0e-10, output_step: 0.01, formulation: reduced"
    _, recorded = run(chain(seed, steps))
    size = max(1.0, np.ptp(recorded["diagnostics/kinetic_energy"]))
    assert np.diff(recorded["diagnostics/total_energy"]).max() < 1e-8 * size
    assert np.diff(recorded["friction/dissipation"], axis=0).min() > -1e-10
    assert recorded["friction/dissipation"][-1].sum() > 0.01
    assert recorded.unbalanced < 1e-7 * size
    force, state = recorded["friction/force"], recorded["friction/state"]
    assert set(np.unique(state)) <= {-1, 0, 1}
    assert (force[state == 1] <= 1e-9).all()
    assert (force[state == -1] >= -1e-9).all()
    assert recorded["joints/violation"].max() < 2e-13


def test_full_and_reduced_find_the_same_motion():
    steps = "integrator: dop853, tolerance: 1.0e-10, output_step: 0.05, formulation: "
    texts = [
        chain(1, steps + formulation).replace("duration: 0.6", "duration: 0.05") for formulation in ("full", "reduced")
    ]
    ends = [run(text)[1] for text in texts]
    times = [[(event.kind, event.name, event.time) for event in end.of("stick", "slip")] for end in ends]
    assert [each[:2] for each in times[0]] == [each[:2] for each in times[1]]
    assert [each[2] for each in times[0]] == pytest.approx([each[2] for each in times[1]], abs=1e-7)
    assert ends[0]["bodies/position"][-1] == pytest.approx(ends[1]["bodies/position"][-1], abs=1e-7)
