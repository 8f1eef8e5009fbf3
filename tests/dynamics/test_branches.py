"""The search for assemblies reaches all that the mechanism reaches, however far from the scene's pose."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.dynamics import assemble
from mbproj.dynamics.assembly.assemblies import conditions, reach_of
from mbproj.dynamics.equations.motions import drive_at
from mbproj.model import compile_system, initial_guess
from mbproj.scene import read_scene_text
from tests.crossed import full
from tests.dynamics.assemblies.linkages import FOUR_BAR


def ready(text, *held):
    """(system, start, conditions) of a scene's text with these coordinates held."""
    scene = read_scene_text(text)
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    wanted = [(system.names.coordinates.index(name), None) for name in held]
    return system, state, conditions(system, state, iter(wanted))


class Platform:
    """A body in a plane on three rods, with random points on the ground and on the body, at a random pose.

    `size`: that of the body beside the ground's triangle, `far`: how far away it stands."""

    def __init__(self, seed, size, far):
        rng = np.random.default_rng(seed)
        self.base, self.points = rng.uniform(-1, 1, (3, 2)), rng.uniform(-1, 1, (3, 2)) * size
        self.place, self.angle = rng.normal(size=2) * far, rng.uniform(-3, 3)
        self.ends = self.place + self.points @ self.rotation(self.angle).T
        self.rods = np.linalg.norm(self.ends - self.base, axis=1)

    @staticmethod
    def rotation(angle):
        return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    @property
    def text(self):
        x, y = self.place.tolist()
        joints = "".join(
            f"  d{k}: {{type: distance, bodies: [ground, p], locations: [[{a!r}, {b!r}, 0], [{c!r}, {d!r}, 0]]}}\n"
            for k, ((a, b), (c, d)) in enumerate(zip(self.base.tolist(), self.ends.tolist(), strict=True))
        )
        return (
            "mbproj: 1\ngravity: [0, 0, 0]\nsimulation: {duration: 1, step: 0.01}\nbodies:\n"
            f"  p: {{mass: 1, inertia: [1, 1, 1], position: [{x!r}, {y!r}, 0], "
            f"orientation: {{axis: [0, 0, 1], angle: {self.angle!r}}}}}\njoints:\n"
            f"  plane: {{type: planar, bodies: [ground, p], location: [{x!r}, {y!r}, 0], axis: [0, 0, 1]}}\n{joints}"
        )

    def _closure(self, angle):
        """A trigonometric polynomial of the body's angle that is 0 at each assembly. At an angle, the differences of
        |p + v|² = d² of the rods are linear in the place p; the first rod then says whether the angle serves."""
        v = self.points @ self.rotation(angle).T - self.base
        A = 2.0 * (v[1:] - v[0])
        right = self.rods[1:] ** 2 - self.rods[0] ** 2 - (v[1:] ** 2).sum(axis=1) + (v[0] ** 2).sum()
        det = np.linalg.det(A)
        p = np.array([right[0] * A[1, 1] - A[0, 1] * right[1], A[0, 0] * right[1] - right[0] * A[1, 0]])
        return ((p + det * v[0]) ** 2).sum() - (det * self.rods[0]) ** 2

    def angles(self):
        """The body's angles in all assemblies: the roots on the unit circle of the polynomial in e^iφ, up to 6."""
        count = 32
        c = np.fft.fft([self._closure(2.0 * np.pi * k / count) for k in range(count)]) / count
        degree = np.flatnonzero(np.abs(c[: count // 2]) > 1e-10 * np.abs(c).max()).max()
        z = np.roots(np.concatenate([c[-degree:], c[: degree + 1]])[::-1])
        return np.sort(np.angle(z[np.abs(np.abs(z) - 1.0) < 1e-6]))


@pytest.mark.parametrize(
    "seed, size, far",
    [
        (3, 0.3, 0.0),
        (6, 1.2, 2.7),
        *(full(*each) for each in ((12, 0.3, 7.6), (15, 2.4, 6.5), (23, 2.4, 5.1), (31, 8.0, 0.5), (5, 0.01, 30.0))),
    ],
)
def test_a_platform_on_three_rods_has_the_assemblies_of_its_polynomial(seed, size, far):
    platform = Platform(seed, size, far)
    found = mbproj.branches(platform.text)
    angles = np.sort([2.0 * np.arctan2(each.q[6], each.q[3]) for each in found.found])
    angles = np.sort((angles + np.pi) % (2.0 * np.pi) - np.pi)
    np.testing.assert_allclose(angles, platform.angles(), atol=1e-5)
    assert not found.is_unsure


@pytest.mark.parametrize("first", [0, *map(full, (4, 8, 12, 16))])
def test_every_assembly_lies_within_the_reach(first):
    for seed in range(first, first + 4):
        platform = Platform(seed, 1.5, 3.0)
        system, state, held = ready(platform.text)
        low, high = reach_of(system, state.q, held, drive_at(system, 0.0)).box(np.eye(3))
        for each in mbproj.branches(platform.text, starts=200).found:
            assert np.all((low <= each.q[None, :3]) & (each.q[None, :3] <= high))


def test_the_reach_of_a_link_is_its_length_and_that_of_the_links_before_it():
    """The crank of 0.2 m is held at its middle; the coupler's centre is reached over the crank, or the rocker."""
    system, state, held = ready(FOUR_BAR, "A.angle")
    reach = reach_of(system, state.q, held, drive_at(system, 0.0))
    bodies = state.q.reshape(-1, 7)
    from_pivots = np.linalg.norm(reach.points[:, None] - bodies[None, :, :3], axis=-1).T
    assert np.all(from_pivots <= reach.radius * (1.0 + 1e-12))
    crank = int(np.argmin(np.linalg.norm(bodies[:, :3], axis=1)))
    at_pivot = int(np.argmin(np.linalg.norm(reach.points, axis=1)))
    assert reach.radius[crank, at_pivot] == pytest.approx(np.linalg.norm(bodies[crank, :3]), rel=2e-3)


#: A slider-crank in space: its block slides freely.
SLIDER = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, step: 1 ms}
bodies:
  crank: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.05, 0, 0]}
  rod: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.35, 0, 0]}
  block: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.6, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: spherical, bodies: [crank, rod], location: [0.1, 0, 0]}
  C: {type: universal, bodies: [rod, block], location: [0.6, 0, 0], axes: [[0, 1, 0], [0, 0, 1]]}
  D: {type: prismatic, bodies: [ground, block], location: [0.6, 0, 0], axis: [1, 0, 0]}
"""


def test_a_block_that_slides_freely_is_found_on_both_sides():
    found = mbproj.branches(SLIDER, hold=["A.angle=60deg"])
    slides = sorted(each.coordinates[-1] + 0.6 for each in found.found)
    height = 0.1 * np.sin(np.pi / 3)
    way = np.sqrt(0.25 - height**2)
    np.testing.assert_allclose(slides, [0.05 - way, 0.05 + way], atol=1e-12)


@pytest.mark.parametrize("seed", [12, full(15)])
def test_the_stated_share_holds(seed):
    """An assembly with the stated share is missed by so many starts with the stated probability, whatever the number
    of starts at which the search ends: batch k may miss with the part 1 / (k (k + 1)) of it."""
    found = mbproj.branches(Platform(seed, 1.0, 4.0).text)
    n, k, p = found.starts, found.looks, found.share
    assert n == 200 * k
    assert (1.0 - p) ** n / p == pytest.approx(1e-3 / (k * (k + 1)), rel=0.05)
    assert (1.0 - p) ** n / p <= 1e-3 / (k * (k + 1))
