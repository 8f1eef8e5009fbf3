"""Assembly: closing open guesses, hard conditions on joints, refusals that name the joint."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly import gauss_newton
from mbproj.equations.assembly.assemble import assemble, coordinate_values
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.assembly.gauss_newton import set_rows, shortest
from mbproj.equations.constraints import constraint_at, constraint_velocity_at, set_velocity
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.joints.table import JOINTS
from mbproj.model.compile.mechanism import initial_guess
from mbproj.scene.records import Body, Joint, Pair
from mbproj.scene.scene import read_scene, read_scene_text
from tests.support import ROOT, assembled, random_chain, scene_of

ROUND = ((0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01))
Y_AXIS = Pair((0.0, 1.0, 0.0), (0.0, 1.0, 0.0), local=True)


def link(name: str, x: float, z: float = 0.0, turn: float = 0.0) -> Body:
    return Body(name, 1.0, ROUND, (x, 0.0, z), (np.cos(turn / 2), 0.0, -np.sin(turn / 2), 0.0))


def pin(name: str, bodies: tuple[str, str], first: float, second: float, **conditions) -> Joint:
    """A pin along y, by its place along each body's x axis."""
    points = Pair((first, 0.0, 0.0), (second, 0.0, 0.0), local=True)
    return Joint(name, "revolute", bodies, points, Y_AXIS, **conditions)


def triangle(base: float, guess: float = 0.0):
    """Two links of 2 m from the ground at 0 and at `base`, pinned together at the top: a rigid triangle."""
    return scene_of(
        [link("left", 0.4 * base + guess, 0.9, 1.0), link("right", 0.7 * base, 0.8, 2.0)],
        [
            pin("A", ("ground", "left"), 0.0, -1.0),
            Joint("B", "spherical", ("left", "right"), Pair((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), local=True)),
            pin("C", ("ground", "right"), base, -1.0),
        ],
    )


@pytest.mark.parametrize("kind", sorted(JOINTS))
def test_a_closed_guess_is_kept_and_its_velocities_made_consistent(kind):
    scene = random_chain(8, [kind] * 3)
    system, state = assembled(scene)
    np.testing.assert_allclose(state.q, initial_guess(scene, system).q, atol=1e-13)
    assert np.abs(constraint_velocity_at(system, state.q, state.v)).max() < 1e-12


@pytest.mark.parametrize("kind", sorted({name for name, kind in JOINTS.items() if kind.rows} - {"knife_edge"}))
def test_a_guess_that_is_open_by_a_tenth_closes(kind):
    scene = random_chain(8, [kind] * 3)
    system = compile_system(scene)
    guess = initial_guess(scene, system)
    opened = dataclasses.replace(guess, q=guess.q + 0.1 * np.random.default_rng(1).uniform(-1, 1, size=21))
    state = assemble(system, opened)
    assert np.abs(constraint_at(system, state.q)).max() < 1e-13
    assert np.linalg.norm(state.q - guess.q) < (2.0 if kind == "screw" else 0.6)


def test_a_loop_with_local_points_closes():
    system, state = assembled(triangle(2.0, guess=0.15))
    assert np.abs(constraint_at(system, state.q)).max() < 1e-13
    top = state.q.reshape(-1, 7)[0, :3] * 2.0  # the left link starts in the origin
    np.testing.assert_allclose(top, [1.0, 0.0, np.sqrt(3.0)], atol=1e-12)


def test_a_loop_that_cannot_close_names_the_joint_and_how_far_it_is_open():
    with pytest.raises(InputError) as caught:
        assembled(triangle(5.0))
    message = str(caught.value)
    assert message.startswith("error: the mechanism does not close: joint '")
    assert "' stays open by 0.333 m and " in message  # 5 m over two links of 2 m, shared by three joints


def test_a_joint_speed_is_a_hard_condition():
    scene = random_chain(8, ["revolute", "universal", "prismatic"])
    joints = [dataclasses.replace(scene.joints[0], speed={"angle": 6.0}), *scene.joints[1:]]
    joints[2] = dataclasses.replace(joints[2], speed={"displacement": -0.5})
    system, state = assembled(dataclasses.replace(scene, joints=tuple(joints)))
    pose = pose_of(state.q)
    speeds = set_velocity(system.coordinates, pose, twist_of(pose, state.v))
    assert speeds[system.names.coordinates.index("J0.angle")] == pytest.approx(6.0, abs=1e-12)
    assert speeds[system.names.coordinates.index("J2.displacement")] == pytest.approx(-0.5, abs=1e-12)
    assert np.abs(constraint_velocity_at(system, state.q, state.v)).max() < 1e-12


def test_start_conditions_move_the_mechanism_and_count_turns():
    scene = random_chain(8, ["revolute", "prismatic"])
    joints = (
        dataclasses.replace(scene.joints[0], start={"angle": 7.0}),
        dataclasses.replace(scene.joints[1], start={"displacement": 0.25}),
    )
    system, state = assembled(dataclasses.replace(scene, joints=joints))
    values = coordinate_values(system, pose_of(state.q)) + 2.0 * np.pi * state.turns
    np.testing.assert_allclose(values, [7.0, 0.25], atol=1e-12)
    np.testing.assert_array_equal(state.turns, [1, 0])


def test_speeds_that_contradict_name_the_joint():
    rigid = triangle(2.0)
    joints = (dataclasses.replace(rigid.joints[0], speed={"angle": 1.0}), *rigid.joints[1:])
    message = r"cannot move at the speeds that its joints ask for: 'A.angle' stays 0\.\d+ rad/s away from its 1 rad/s"
    with pytest.raises(InputError, match=message):
        assembled(dataclasses.replace(rigid, joints=joints))


def test_a_turned_over_axis_is_refused():
    """Axes nearly opposite in the guess: the nearest closed pose has them opposite, which is another joint."""
    scene = scene_of([link("bar", 1.0)], [])
    joint = Joint(
        "hinge",
        "revolute",
        ("ground", "bar"),
        Pair((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0), local=True),
        Pair((0.0, 1.0, 0.0), (0.0, -1.0, 0.01), local=True),
    )
    with pytest.raises(InputError, match="assembly turned the axis of joint 'hinge' by 180 degrees"):
        assembled(dataclasses.replace(scene, joints=(joint,)))


def test_nearness_is_geometric_not_energetic():
    """A body's mass has no say in where the mechanism closes."""
    light = triangle(2.0, guess=0.15)
    heavy = dataclasses.replace(light, bodies=(dataclasses.replace(light.bodies[0], mass=1e6), light.bodies[1]))
    np.testing.assert_array_equal(assembled(light)[1].q, assembled(heavy)[1].q)


def test_round_off_of_a_body_that_is_far_away_is_no_misfit_of_speeds():
    """The digits of a velocity of 1e11 m/s end at 1e-5 m/s."""
    text = (ROOT / "mechanisms" / "spherical_pendulum.yaml").read_text(encoding="utf-8")
    far = text.replace("position: [length * sin(start), 0,", "position: [length * sin(start), 4e11,")
    assert far != text
    _, state = assembled(read_scene_text(far))
    assert np.isfinite(state.v).all()


@pytest.mark.parametrize("name", ["bricard", "bennett", "n_four_bar", "stewart_platform", "locomotive"])
@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_sparse_factors_find_the_shortest_correction_that_dense_ones_find(name, damping, monkeypatch):
    """Of rows that follow from others too, for a wish that they can fulfil and for one that they cannot. Undamped,
    round-off along free motions is divided by the shift, 1e-10 of the largest entry; it closes joints as well."""
    system, state = assembled(read_scene(ROOT / "mechanisms" / f"{name}.yaml"))
    rows = set_rows(system, system.rows, pose_of(state.q))
    rng = np.random.default_rng(5)
    wishes = rows.dense() @ rng.normal(size=6 * system.bodies), rng.normal(size=rows.count)
    dense = [shortest(rows, wish, damping) for wish in wishes]
    monkeypatch.setattr(gauss_newton, "THRESHOLDS", dataclasses.replace(THRESHOLDS, large=0))
    for expected, wish in zip(dense, wishes, strict=True):
        found, near = shortest(rows, wish, damping), 1e-9 if damping else 2e-6
        np.testing.assert_allclose(found, expected, rtol=0, atol=near * abs(expected).max())
        left, least = (np.linalg.norm(rows.dense() @ x - wish) for x in (found, expected))
        assert left <= least + 1e-9 * np.linalg.norm(wish)


def test_a_mechanism_is_assembled_to_the_same_pose_by_sparse_factors(monkeypatch):
    """The locomotive, its bodies drawn a little apart: 7 of its rows follow from the others."""
    scene = read_scene(ROOT / "mechanisms" / "locomotive.yaml")
    system = compile_system(scene)
    guess = initial_guess(scene, system)
    open_guess = dataclasses.replace(guess, q=guess.q + 1e-3 * np.random.default_rng(3).normal(size=guess.q.shape))
    dense = assemble(system, open_guess)
    monkeypatch.setattr(gauss_newton, "THRESHOLDS", dataclasses.replace(THRESHOLDS, large=0))
    sparse = assemble(system, open_guess)
    assert np.abs(dense.q - open_guess.q).max() > 1e-4
    np.testing.assert_allclose(sparse.q, dense.q, rtol=0, atol=1e-7)
    assert np.abs(constraint_at(system, sparse.q)).max() < 1e-13
    np.testing.assert_allclose(sparse.v, dense.v, rtol=0, atol=1e-6 * max(1.0, np.abs(dense.v).max()))
