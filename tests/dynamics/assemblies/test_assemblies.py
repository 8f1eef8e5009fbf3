"""All assemblies of a mechanism, against the numbers that are known of its kind."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.assemblies import assemblies, conditions, freedom_left
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_at
from mbproj.model.compile.mechanism import initial_guess
from mbproj.scene.scene import read_scene_text
from tests.dynamics.assemblies.linkages import (
    BASE,
    FOUR_BAR,
    IN_PLANE,
    LEGS,
    PLATFORM,
    RPR_BASE,
    RPR_LEGS,
    RPR_PLATFORM,
    crank_angles,
    platform,
    six_bar,
)


def made(text):
    """(system, start) of a scene's text."""
    scene = read_scene_text(text)
    system = compile_system(scene)
    return system, assemble(system, initial_guess(scene, system))


def found(text, *held, starts=None):
    """(system, assemblies) with these coordinates held."""
    system, state = made(text)
    wanted = conditions(system, state, iter([(system.names.coordinates.index(name), None) for name in held]))
    assert freedom_left(system, state, wanted) == 0
    result = assemblies(system, state, wanted, starts)
    for each in result.found:
        assert np.abs(constraint_at(system, each.q)).max() < 1e-12
    return system, result


def test_a_four_bar_has_two():
    _, result = found(FOUR_BAR, "A.angle")
    assert len(result.found) == 2
    assert result.share < 0.05 and not result.is_unsure
    # The rocker's end is mirrored at the line from the crank's end to its pivot, the x axis here.
    (first, second), pin = (each.q.reshape(-1, 7) for each in result.found), np.array([0.4, 0.0, 0.2])
    np.testing.assert_allclose(first[1, :3], pin, atol=1e-12)
    np.testing.assert_allclose(second[1, :3], pin * [1, 1, -1], atol=1e-12)


def test_a_stephenson_six_bar_has_six_at_the_crank_angles_of_its_coupler_curve():
    system, result = found(six_bar(), "F.angle")
    known = sorted(angle for angle, _ in crank_angles())
    assert len(known) == 6
    start = crank_angles()[0][0]
    index = system.names.coordinates.index("A.angle")
    cranks = sorted((start + each.coordinates[index]) % (2.0 * np.pi) for each in result.found)
    np.testing.assert_allclose(cranks, known, atol=1e-9)
    assert not result.is_unsure


def test_a_planar_platform_on_three_legs_has_six():
    _, result = found(platform(RPR_BASE, RPR_PLATFORM, RPR_LEGS, (0.3, 0.3, 0.0), IN_PLANE))
    assert len(result.found) == 6
    assert not result.is_unsure


@pytest.mark.full
@pytest.mark.long
def test_dietmaiers_platform_has_all_forty():
    _, result = found(platform(BASE, PLATFORM, LEGS, (0.0, 0.1, 0.2)))
    assert len(result.found) == 40
    assert result.share < 0.005
    for each in result.found:  # the legs, by hand
        q = each.q
        w, x, y, z = q[3:]
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        ends = q[:3] + np.array(PLATFORM) @ turn.T
        np.testing.assert_allclose(np.linalg.norm(ends - np.array(BASE), axis=1), LEGS, atol=1e-12)


def test_what_was_not_found_often_is_not_sure():
    _, result = found(FOUR_BAR, "A.angle", starts=3)
    assert (result.starts, result.closed) == (3, 3)
    assert result.share * 1e-3 == pytest.approx((1.0 - result.share) ** 3, rel=0.02)
    assert result.share > 0.8 and result.is_unsure


def test_bodies_start_at_poses_of_their_own():
    """The coupler's pin lies below the crank then; points of joints stay where `position` has them."""
    turned = "start: {position: [0.4, 0, -0.2], orientation: {axis: [0, 1, 0], angle: 1.5}}}"
    text = FOUR_BAR.replace("position: [0.4, 0, 0.2]}", f"position: [0.4, 0, 0.2], {turned}")
    turned = "start: {position: [0.65, 0, -0.2], orientation: {axis: [0, 1, 0], angle: -2.6}}}"
    text = text.replace("position: [0.65, 0, 0.2]}", f"position: [0.65, 0, 0.2], {turned}")
    text = text.replace("axis: [0, 1, 0]}\n  B", "axis: [0, 1, 0], angle: 0}\n  B")
    system, state = made(text)
    reference, _ = made(FOUR_BAR)
    np.testing.assert_allclose(state.q.reshape(-1, 7)[1, :3], [0.4, 0.0, -0.2], atol=1e-12)
    np.testing.assert_array_equal(system.rows.local, reference.rows.local)
