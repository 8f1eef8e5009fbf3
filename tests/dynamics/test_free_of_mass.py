"""Motions without mass, in words."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import massless_motions, mobility, refuse_unsolvable, swamped_motions
from tests.dynamics import linkages
from tests.dynamics.linkages import assembled, scaled


def light_coupler(*kinds: str):
    """The four-bar with a coupler without mass, and these joints at its ends."""
    scene = linkages.four_bar()
    light = dataclasses.replace(scene.bodies[1], mass=0.0, inertia=((0.0,) * 3,) * 3)
    ends = [
        dataclasses.replace(joint, type=kind, axes=joint.axes if kind == "revolute" else None)
        for joint, kind in zip(scene.joints[1:3], kinds, strict=True)
    ]
    joints = (scene.joints[0], *ends, scene.joints[3])
    return dataclasses.replace(scene, bodies=(scene.bodies[0], light, scene.bodies[2]), joints=joints)


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("mass", [1e-6, 1e6])
def test_a_massless_coupler_on_two_balls_spins_about_their_line(length, mass):
    system, state = assembled(scaled(light_coupler("spherical", "spherical"), length, mass))
    (motion,) = massless_motions(system, pose_of(state.q))
    assert str(motion) == "'link2' turns about [0.949, 0, 0.316] through its centre of mass"
    with pytest.raises(InputError, match=r"a motion that moves no mass \(Eq. 20 does not hold\): 'link2' turns about"):
        refuse_unsolvable(system, mobility(system, pose_of(state.q)))


def test_on_a_revolute_joint_and_a_ball_it_is_legal():
    system, state = assembled(light_coupler("revolute", "spherical"))
    assert massless_motions(system, pose_of(state.q)) == ()


def test_a_rod_without_inertia_about_its_axis_spins_between_two_balls():
    scene = light_coupler("spherical", "spherical")
    axis = np.array([0.6, 0.0, 0.2]) / np.hypot(0.6, 0.2)
    inertia = 0.01 * (np.eye(3) - np.outer(axis, axis))
    rod = dataclasses.replace(scene.bodies[1], mass=1.0, inertia=tuple(tuple(row) for row in inertia.tolist()))
    system, state = assembled(dataclasses.replace(scene, bodies=(scene.bodies[0], rod, scene.bodies[2])))
    (motion,) = massless_motions(system, pose_of(state.q))
    assert str(motion) == "'link2' turns about [0.949, 0, 0.316] through its centre of mass"


def test_a_massless_body_on_a_ball_turns_about_three_axes_through_it():
    scene = linkages.door()
    leaf = dataclasses.replace(scene.bodies[0], mass=0.0, inertia=((0.0,) * 3,) * 3)
    ball = dataclasses.replace(scene.joints[0], type="spherical", axes=None)
    system, state = assembled(dataclasses.replace(scene, bodies=(leaf,), joints=(ball,)))
    motions = massless_motions(system, pose_of(state.q))
    assert sorted(str(motion) for motion in motions) == [
        "'door' turns about x through [0.5, 0, 0.2] m",
        "'door' turns about y through [0, 0, 0.2] m",
        "'door' turns about z through [0, 0, 1] m",
    ]


def test_a_massless_slide_shifts():
    scene = linkages.slider_crank(0.5, 0.7)
    slider = dataclasses.replace(scene.bodies[2], mass=0.0, inertia=((0.0,) * 3,) * 3)
    system, state = assembled(dataclasses.replace(scene, bodies=(slider,), joints=(scene.joints[3],)))
    assert [str(motion) for motion in massless_motions(system, pose_of(state.q))] == ["'slider' shifts along x"]


@pytest.mark.parametrize(("part", "swamped"), [(1e-12, 1), (1e-6, 0)])
def test_a_body_that_hardly_weighs_anything_is_ruled_by_round_off_where_it_moves_by_itself(part, swamped):
    """A coupler spins between two balls; held by a revolute joint it does what the others do, whatever it weighs;
    at the end of a tree no force but its own acts on it."""

    def motions(kinds, keep):
        scene = light_coupler(*kinds)
        inertia = tuple(tuple(part * float(i == k) for k in range(3)) for i in range(3))
        coupler = dataclasses.replace(scene.bodies[1], mass=part, inertia=inertia)
        bodies = (scene.bodies[0], coupler, scene.bodies[2])[: keep or 3]
        system, state = assembled(dataclasses.replace(scene, bodies=bodies, joints=scene.joints[: keep or 4]))
        return swamped_motions(system, pose_of(state.q))

    assert len(motions(("spherical", "spherical"), 0)) == swamped
    assert motions(("revolute", "spherical"), 0) == ()
    assert motions(("spherical", "spherical"), 2) == ()
