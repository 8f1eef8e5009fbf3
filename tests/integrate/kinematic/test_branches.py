"""Branches of a motion that cross, that nearly cross, and that end at a dead centre."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.errors import SimulationError
from tests.integrate.kinematic.scenes import BY_THE_ROCKER, FORMULATIONS, PARALLELOGRAM, rocker_at_dead_centre, run

#: A force with a state: what is integrated beside the motion does not shorten the steps at what is nearly singular.
SEAL = "forces: {seal: {type: torsion_maxwell, joint: A, stiffness: 1, damping: 1}}\n"
COARSE = {"integrator": "dopri5", "tolerance": 1e-2, "output_step": "20 ms"}
CRANK, LENGTH, SPEED = 0.2, 0.5, 57.0 * 2.0 * np.pi / 60.0


def rocker_angle(crank, side, shorter):
    """Of the rocker from the ground's line, by the cosine rule, on the branch to this side of the diagonal."""
    x, z = LENGTH - (CRANK - shorter) * np.cos(crank), -(CRANK - shorter) * np.sin(crank)
    diagonal = np.hypot(x, z)
    inner = np.arccos((diagonal**2 + CRANK**2 - LENGTH**2) / (2.0 * diagonal * CRANK))
    return np.arctan2(-z, -x) + side * inner


def nearly_a_parallelogram(shorter: float) -> str:
    """The crank is shorter than the rocker by this: twice a turn it is in line with it, and nearly with the others."""
    z = CRANK - shorter
    beside = rocker_angle(np.pi / 2.0, -1, shorter)
    x, height = LENGTH + CRANK * np.cos(beside), CRANK * np.sin(beside)
    text = PARALLELOGRAM.replace("location: [0, 0, 0.2]", f"location: [0, 0, {z!r}]")
    return text.replace("location: [0.5, 0, 0.2]", f"location: [{float(x)!r}, 0, {float(height)!r}]")


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("shorter", [1e-4, 1e-6, 1e-8])
def test_a_motion_stays_on_its_branch_where_another_one_is_next_to_it(shorter, formulation):
    """In line both branches are √(shorter) apart. A step that goes straight on comes to the other one, with velocities
    that agree."""
    text = nearly_a_parallelogram(shorter).replace("tolerance: 1e-3, integrator: dop853, ", "") + SEAL
    report, found, _ = run(text, formulation=formulation, duration="3 s", **COARSE)
    assert report.kinematic
    crank = np.pi / 2.0 + SPEED * found["time"]
    own, other = (rocker_angle(crank, side, shorter) for side in (-1, 1))
    turned = found["joints/coordinate"][:, 3] + rocker_angle(np.pi / 2.0, -1, shorter)
    off = np.abs(np.exp(1j * turned) - np.exp(1j * own))
    assert np.abs(np.exp(1j * own) - np.exp(1j * other)).max() > 1.0
    assert off.max() < 1e-10


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_parallelogram_with_a_state_passes_where_branches_cross(formulation):
    text = PARALLELOGRAM.replace("tolerance: 1e-3, integrator: dop853, ", "") + SEAL
    report, found, _ = run(text, formulation=formulation, duration="3 s", **COARSE)
    assert report.kinematic
    crank, rocker = found["joints/coordinate"][:, 0], found["joints/coordinate"][:, 3]
    assert crank[-1] > 0.5 * np.pi
    np.testing.assert_allclose(np.unwrap(rocker), np.unwrap(crank), atol=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_run_stops_at_a_dead_centre_and_names_the_motion_and_its_joint(formulation):
    with pytest.raises(SimulationError) as stopped:
        run(BY_THE_ROCKER, formulation=formulation, output_step="10 ms")
    time = rocker_at_dead_centre() / (2.0 * np.pi / 3.0)
    assert stopped.value.time == pytest.approx(time, abs=1e-7)
    assert stopped.value.where == "motion 'drive'"
    assert f"D.angle = {rocker_at_dead_centre():.3g} rad" in str(stopped.value)


def test_the_branch_of_a_mechanism_of_many_bodies_is_watched_too():
    """Eight linkages with a motion each, of which two have their branches next to each other."""
    pytest.importorskip("mbproj.kernel._core")
    shorter = [1e-6, 1e-8, *np.linspace(0.02, 0.05, 6).tolist()]
    texts = [nearly_a_parallelogram(each) for each in shorter]
    blocks = {"bodies": "", "joints": "", "motions": ""}
    for number, text in enumerate(texts):
        for name in blocks:
            lines = text[text.index(f"{name}:") :].splitlines()[1:]
            own = "\n".join(lines[: next((k for k, line in enumerate(lines) if line[:1] != " "), len(lines))])
            for part in ("crank", "coupler", "rocker"):
                own = own.replace(f"{part}:", f"{part}{number}:").replace(f"{part}]", f"{part}{number}]")
                own = own.replace(f"[{part},", f"[{part}{number},")
            for joint in "ABCD":
                own = own.replace(f"  {joint}: ", f"  {joint}{number}: ").replace(
                    f"joint: {joint},", f"joint: {joint}{number},"
                )
            blocks[name] += own.replace("drive:", f"drive{number}:") + "\n"
    head = texts[0][: texts[0].index("bodies:")].replace("tolerance: 1e-3, integrator: dop853, ", "")
    text = head + "".join(f"{name}:\n{entries}" for name, entries in blocks.items())
    report, found, _ = run(text + SEAL.replace("joint: A", "joint: A0"), duration="3 s", **COARSE)
    assert report.kinematic and found["bodies/position"].shape[1] == 24
    crank = np.pi / 2.0 + SPEED * found["time"]
    for number, each in enumerate(shorter):
        turned = found["joints/coordinate"][:, 4 * number + 3] + rocker_angle(np.pi / 2.0, -1, each)
        off = np.abs(np.exp(1j * turned) - np.exp(1j * rocker_angle(crank, -1, each)))
        assert off.max() < 1e-10, each
