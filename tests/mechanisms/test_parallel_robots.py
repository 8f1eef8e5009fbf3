"""Stewart platform and Delta robot against their inverse kinematics, which is explicit."""

from __future__ import annotations

import numpy as np
import pytest

from tests.mechanisms.running import TIGHT, Run, assert_close, run


@pytest.fixture(scope="module")
def stewart() -> Run:
    return run("stewart_platform", **TIGHT, duration=0.4, output_step=0.02)


@pytest.fixture(scope="module")
def delta() -> Run:
    return run("delta_robot", **TIGHT, duration=0.4, output_step=0.02)


def legs(done: Run) -> tuple[np.ndarray, np.ndarray]:
    """Vectors (T, 6, 3) along the legs, and the velocities of their upper ends, from the platform's motion alone."""
    known = done.parameters
    base, top = (
        np.array([[known[radius] * f(known[f"{letter}{k}"]) for f in (np.cos, np.sin)] + [0.0] for k in range(1, 7)])
        for radius, letter in (("base", "b"), ("platform", "p"))
    )
    rotation = done.rotation("platform")
    arm = np.einsum("tij,kj->tki", rotation, top)
    ω = np.einsum("tij,tj->ti", rotation, done.column("bodies/angular_velocity", "platform"))
    velocity = done.column("bodies/velocity", "platform")[:, None] + np.cross(ω[:, None], arm)
    return done.column("bodies/position", "platform")[:, None] + arm - base, velocity


def test_legs_have_the_lengths_that_the_pose_of_the_platform_needs(stewart):
    vectors, velocity = legs(stewart)
    length = np.linalg.norm(vectors, axis=-1)
    displacement = np.stack([stewart.column("joints/coordinate", f"P{k}.displacement") for k in range(1, 7)], axis=-1)
    assert np.ptp(displacement, axis=0).min() > 0.05
    assert_close(displacement, length - stewart.parameters["length"], 5e-13)
    speed = np.stack([stewart.column("joints/speed", f"P{k}.displacement") for k in range(1, 7)], axis=-1)
    assert_close(speed, np.sum(vectors * velocity, axis=-1) / length, 1e-12)


def test_legs_start_at_the_speeds_that_the_scene_asks_for(stewart):
    for joint in stewart.scene.joints:
        for coordinate, speed in joint.speed.items():
            assert stewart.column("joints/speed", f"{joint.name}.{coordinate}")[0] == pytest.approx(speed, abs=1e-13)


def arm_angles(done: Run) -> np.ndarray:
    """θ (T, 3) below the horizontal from the platform's position: X cos θ - z sin θ = (X² + y² + z² + L² - l²)/(2L)."""
    known, position = done.parameters, done["markers/position"][:, 0]
    angles = []
    for azimuth in (known["s1"], known["s2"], known["s3"]):
        X = position[:, 0] * np.cos(azimuth) + position[:, 1] * np.sin(azimuth) + known["platform"] - known["base"]
        y = position[:, 1] * np.cos(azimuth) - position[:, 0] * np.sin(azimuth)
        z = position[:, 2]
        k = (X**2 + y**2 + z**2 + known["arm"] ** 2 - known["rod"] ** 2) / (2.0 * known["arm"])
        angles.append(np.arctan2(-z, X) - np.arccos(k / np.hypot(X, z)))
    return np.stack(angles, axis=-1)


def test_arms_have_the_angles_that_the_position_of_the_platform_needs(delta):
    turned = np.stack([delta.column("joints/coordinate", f"A{k}.angle") for k in (1, 2, 3)], axis=-1)
    assert np.ptp(turned, axis=0).min() > 0.1
    assert_close(delta.parameters["start"] + turned, arm_angles(delta), 2e-12)


def test_platform_of_the_delta_robot_never_turns(delta):
    rotation = delta.rotation("platform")
    assert_close(rotation, np.eye(3), 1e-13)
    assert_close(delta.column("bodies/angular_velocity", "platform"), 0.0, 1e-12)


def test_parallel_rods_stay_parallel(delta):
    for k in (1, 2, 3):
        left, right = (delta.rotation(f"rod{k}{side}")[..., 0] for side in "lr")
        assert_close(left, right, 1e-13)


def test_energy_is_conserved(stewart, delta):
    for done in (stewart, delta):
        assert done.report.energy_drift_relative < 1e-11
