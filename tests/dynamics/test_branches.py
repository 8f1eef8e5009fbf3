"""All assemblies of a mechanism, how far the search for them reaches, and `mbproj branches`."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

import mbproj
from mbproj.equations.assembly.assemblies import assemblies, conditions, freedom_left, reach_of
from mbproj.equations.constraints import constraint_at
from mbproj.equations.motions import drive_at
from mbproj.results.reader import open_results
from mbproj.scene.scene import read_scene_text
from tests.cli.commands import mbproj as command
from tests.cli.commands import succeeds
from tests.crossed import full
from tests.integrate.kinematic_scenes import FOUR_BAR as FILE
from tests.support import assembled

# Linkages whose numbers of assemblies are known, as scenes.

FOUR_BAR = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  crank: {mass: 0.4, inertia: [1e-3, 1e-3, 1e-3], position: [0.1, 0, 0]}
  coupler: {mass: 1.0, inertia: [2e-2, 2e-2, 2e-2], position: [0.4, 0, 0.2]}
  rocker: {mass: 0.8, inertia: [1e-2, 1e-2, 1e-2], position: [0.65, 0, 0.2]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [crank, coupler], location: [0.2, 0, 0], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [coupler, rocker], location: [0.6, 0, 0.4], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [ground, rocker], location: [0.7, 0, 0], axis: [0, 1, 0]}
"""


#: Dietmaier, The Stewart-Gough platform of general geometry can have 40 real postures (Advances in Robot Kinematics
#: 1998): ends of the legs in the ground and in the platform, and the legs' lengths.
BASE = (
    (0.0, 0.0, 0.0),
    (1.107915, 0.0, 0.0),
    (0.549094, 0.756063, 0.0),
    (0.735077, -0.223935, 0.525991),
    (0.514188, -0.526063, -0.368418),
    (0.590473, 0.094733, -0.205018),
)
PLATFORM = (
    (0.0, 0.0, 0.0),
    (0.542805, 0.0, 0.0),
    (0.956919, -0.528915, 0.0),
    (0.665885, -0.353482, 1.402538),
    (0.478359, 1.158742, 0.107672),
    (-0.137087, -0.235121, 0.353913),
)
LEGS = (1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071)


def platform(base, ends, lengths, position, *joints):
    """A scene's text: a platform, its centre at `position`, on rods of these lengths from points of the ground to
    points of its own, from its centre; and other joints, as YAML."""
    rods = [
        f"L{k}: {{type: distance, bodies: [ground, platform], length: {length}, "
        f"locations: [{list(start)}, {[x + y for x, y in zip(end, position, strict=True)]}]}}"
        for k, (start, end, length) in enumerate(zip(base, ends, lengths, strict=True), 1)
    ]
    listed = "\n".join(f"  {each}" for each in [*rods, *joints])
    return f"""
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  platform: {{mass: 1, inertia: [1e-2, 1e-2, 1e-2], position: {list(position)}}}
joints:
{listed}
"""


#: A planar 3-RPR platform: 6 assemblies, by the signs of its sextic along a turn.
RPR_BASE = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (-0.68, -0.08, 0.0))
RPR_PLATFORM = ((0.0, 0.0, 0.0), (0.58, 0.0, 0.0), (0.15, -0.41, 0.0))
RPR_LEGS = (0.8, 1.45, 0.85)
IN_PLANE = "plane: {type: planar, bodies: [ground, platform], location: [0.3, 0.3, 0], axis: [0, 0, 1]}"

#: A Stephenson III six-bar: crank, coupler, rocker and ground of its four-bar, the coupler's point from its pin at the
#: crank, the tip of its input, and the link between. The input's circle meets the coupler curve 6 times.
BARS, POINT, TIP, LINK = (0.77, 0.86, 1.29, 1.12), (1.01, 0.77), (-0.9, 0.3), 1.49
PIVOT = (-0.9, -0.2)


def coupler_curve(theta, sign):
    """(pin at the crank, pin at the rocker, coupler point) at crank angles (n,), (n, 2) each; nan where it is open."""
    a, b, c, g = BARS
    pin = np.stack([a * np.cos(theta), a * np.sin(theta)], axis=-1)
    x, y = g - pin[..., 0], -pin[..., 1]
    r = np.hypot(x, y)
    with np.errstate(invalid="ignore"):
        turn = np.arctan2(y, x) + sign * np.arccos((r**2 + b**2 - c**2) / (2.0 * r * b))
    along = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    across = np.stack([-np.sin(turn), np.cos(turn)], axis=-1)
    return pin, pin + b * along, pin + POINT[0] * along + POINT[1] * across


def crank_angles():
    """(crank angle, sign) of each assembly of the six-bar, by bisection along the coupler curve."""

    def off(theta, sign):
        return np.hypot(*(coupler_curve(theta, sign)[2] - TIP).T) - LINK

    found, theta = [], np.linspace(0.0, 2.0 * np.pi, 4001)
    for sign in (1.0, -1.0):
        values = off(theta, sign)
        for k in np.flatnonzero(values[1:] * values[:-1] < 0.0):
            low, high = theta[k], theta[k + 1]
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if off(middle, sign) * off(low, sign) > 0.0 else (low, middle)
            found.append((0.5 * (low + high), sign))
    return found


def six_bar(motions=""):
    """Its scene's text at the first assembly, in the x-y plane."""
    theta, sign = crank_angles()[0]
    pin, other, point = (part.tolist() for part in coupler_curve(np.array(theta), sign))
    ends = {
        "crank": ([0.0, 0.0], pin),
        "coupler": (pin, other),
        "rocker": (other, [BARS[3], 0.0]),
        "link": (point, list(TIP)),
        "input": (list(PIVOT), list(TIP)),
    }
    pins = {
        "A": ("ground", "crank", [0.0, 0.0]),
        "B": ("crank", "coupler", pin),
        "C": ("coupler", "rocker", other),
        "D": ("ground", "rocker", [BARS[3], 0.0]),
        "E": ("coupler", "link", point),
        "G": ("link", "input", list(TIP)),
        "F": ("ground", "input", list(PIVOT)),
    }
    centres = {name: [0.5 * (x + y) for x, y in zip(*both, strict=True)] for name, both in ends.items()}
    bodies = "\n".join(
        f"  {name}: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: {[*centre, 0.0]}}}"
        for name, centre in centres.items()
    )
    joints = "\n".join(
        f"  {name}: {{type: revolute, bodies: [{first}, {second}], location: {[*place, 0.0]}, axis: [0, 0, 1]}}"
        for name, (first, second, place) in pins.items()
    )
    return f"\nmbproj: 1\ngravity: [0, -9.81, 0]\nbodies:\n{bodies}\njoints:\n{joints}\n{motions}"


# All assemblies of a mechanism, against the numbers that are known of its kind.


def made(text):
    """(system, start) of a scene's text."""
    return assembled(read_scene_text(text))


def found(text, *held, starts=None):
    """(system, assemblies) with these coordinates held."""
    system, state = made(text)
    wanted = conditions(system, state, iter([(system.names.coordinates.index(name), None) for name in held]))
    assert freedom_left(system, state, wanted) == 0
    result = assemblies(system, state, wanted, starts)
    for each in result.assemblies:
        assert np.abs(constraint_at(system, each.q)).max() < 1e-12
    return system, result


def test_a_four_bar_has_two():
    _, result = found(FOUR_BAR, "A.angle")
    assert len(result.assemblies) == 2
    assert result.share < 0.05 and not result.is_unsure
    # The rocker's end is mirrored at the line from the crank's end to its pivot, the x axis here.
    (first, second), pin = (each.q.reshape(-1, 7) for each in result.assemblies), np.array([0.4, 0.0, 0.2])
    np.testing.assert_allclose(first[1, :3], pin, atol=1e-12)
    np.testing.assert_allclose(second[1, :3], pin * [1, 1, -1], atol=1e-12)


def test_a_stephenson_six_bar_has_six_at_the_crank_angles_of_its_coupler_curve():
    system, result = found(six_bar(), "F.angle")
    known = sorted(angle for angle, _ in crank_angles())
    assert len(known) == 6
    start = crank_angles()[0][0]
    index = system.names.coordinates.index("A.angle")
    cranks = sorted((start + each.coordinates[index]) % (2.0 * np.pi) for each in result.assemblies)
    np.testing.assert_allclose(cranks, known, atol=1e-9)
    assert not result.is_unsure


def test_a_planar_platform_on_three_legs_has_six():
    _, result = found(platform(RPR_BASE, RPR_PLATFORM, RPR_LEGS, (0.3, 0.3, 0.0), IN_PLANE))
    assert len(result.assemblies) == 6
    assert not result.is_unsure


@pytest.mark.full
@pytest.mark.long
def test_dietmaiers_platform_has_all_forty():
    _, result = found(platform(BASE, PLATFORM, LEGS, (0.0, 0.1, 0.2)))
    assert len(result.assemblies) == 40
    assert result.share < 0.005
    for each in result.assemblies:  # the legs, by hand
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


# The search for assemblies reaches all that the mechanism reaches, however far from the scene's pose.


def ready(text, *held):
    """(system, start, conditions) of a scene's text with these coordinates held."""
    system, state = assembled(read_scene_text(text))
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
    angles = np.sort([2.0 * np.arctan2(each.q[6], each.q[3]) for each in found.assemblies])
    angles = np.sort((angles + np.pi) % (2.0 * np.pi) - np.pi)
    np.testing.assert_allclose(angles, platform.angles(), atol=1e-5)
    assert not found.is_unsure


@pytest.mark.parametrize("first", [0, *map(full, (4, 8, 12, 16))])
def test_every_assembly_lies_within_the_reach(first):
    for seed in range(first, first + 4):
        platform = Platform(seed, 1.5, 3.0)
        system, state, held = ready(platform.text)
        low, high = reach_of(system, state.q, held, drive_at(system, 0.0)).box(np.eye(3))
        for each in mbproj.branches(platform.text, starts=200).assemblies:
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
    slides = sorted(each.coordinates[-1] + 0.6 for each in found.assemblies)
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


# `mbproj branches`: the report, JSON, the scenes that it writes, its picture, and how it fails.

CRANK, COUPLER, ROCKER, GROUND = 0.2, float(np.hypot(0.4, 0.4)), float(np.hypot(0.1, 0.4)), 0.7
SCENE = """\
mbproj: 1
title: Four bars
gravity: [0, 0, -9.81]
simulation: {duration: 0.1 s, output_step: 0.1 s, kinematic: true}
parameters: {weight: 1}
"""
SCENE += FILE[FILE.index("bodies:") :].replace("{mass: 0.4,", "{mass: weight,")
FREE = SCENE[: SCENE.index("motions:")].replace(", kinematic: true", ", step: 1 ms")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "four_bar.yaml").write_text(SCENE)
    (tmp_path / "free.yaml").write_text(FREE)
    return tmp_path


def rockers(crank: float) -> list[float]:
    """Angles of the rocker in both assemblies, from that of the scene, by the cosine rule."""
    x, z = GROUND - CRANK * np.cos(crank), -CRANK * np.sin(crank)
    diagonal, start = np.hypot(x, z), np.arctan2(0.4, -0.1)
    inner = np.arccos((diagonal**2 + ROCKER**2 - COUPLER**2) / (2.0 * diagonal * ROCKER))
    both = np.arctan2(-z, -x) + inner * np.array([-1.0, 1.0]) - start
    return sorted(np.remainder(both + np.pi, 2.0 * np.pi) - np.pi)


def test_it_lists_both_assemblies_of_a_four_bar(folder):
    done = command("branches", "four_bar.yaml", folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0] == "Four bars: 2 assemblies"
    assert lines[1].split() == ["A.angle", "B.angle", "C.angle", "D.angle", "found", "distance"]
    assert lines[2].startswith("1 (the start)")
    assert "random starts led to one; one that draws 3 % of such starts or more was missed" in lines[4]


def test_json_has_coordinates_by_name_and_poses(folder):
    done = command("branches", "free.yaml", "--hold", "A.angle=50deg", "--json", folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    facts = json.loads(done.stdout)
    assert facts["scene"] == "free.yaml" and facts["written"] == [] and facts["picture"] is None
    assert facts["units"] == dict.fromkeys(("A.angle", "B.angle", "C.angle", "D.angle"), "rad")
    found = facts["assemblies"]
    assert [each["at_start"] for each in found] == [True, False]
    assert not any(each["singular"] for each in found)
    np.testing.assert_allclose([each["coordinates"]["A.angle"] for each in found], np.radians(50.0), atol=1e-12)
    np.testing.assert_allclose(
        sorted(each["coordinates"]["D.angle"] for each in found), rockers(np.radians(50.0)), atol=1e-11
    )
    for each in found:
        pose = each["bodies"]["rocker"]
        np.testing.assert_allclose(
            np.hypot(pose["position"][0] - GROUND, pose["position"][2]), 0.5 * ROCKER, atol=1e-12
        )
        np.testing.assert_allclose(np.linalg.norm(pose["orientation"]), 1.0, atol=1e-13)
    assert sum(each["found"] for each in found) == facts["closed"] <= facts["starts"]
    assert facts["missed"] <= 1e-3 and facts["share"] < 0.05


def test_each_assembly_is_written_as_a_scene_that_starts_there(folder):
    done = command("branches", "four_bar.yaml", "--json", "--write", "starts", "--picture", "both.png", folder=folder)
    facts = json.loads(done.stdout)
    assert facts["written"] == ["starts/four_bar_1.yaml", "starts/four_bar_2.yaml"]
    assert facts["picture"] == "both.png"
    for path, each in zip(facts["written"], facts["assemblies"], strict=True):
        assert command("run", path, "-o", "run.h5", "-q", folder=folder).returncode == 0
        with open_results(folder / "run.h5") as results:
            start = results.body("rocker").position[0]
        np.testing.assert_allclose(start, each["bodies"]["rocker"]["position"], atol=1e-11)


def test_the_picture_shows_them_side_by_side(folder):
    done = command("branches", "four_bar.yaml", "--picture", "both.png", folder=folder)
    assert done.returncode == 0 and done.stdout.splitlines()[-1] == "both.png"
    image = np.asarray(Image.open(folder / "both.png").convert("L"))
    drawn = np.flatnonzero((image < 200).any(axis=0))
    middle = image.shape[1] // 2
    assert (drawn < middle).sum() > 100 and (drawn > middle).sum() > 100


def test_a_search_from_few_starts_says_that_it_is_not_sure(folder):
    done = succeeds("branches", "four_bar.yaml", "--starts", "3", folder=folder)
    assert "search from more poses, --starts 12" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["free.yaml"],
            "--hold: error: 1 degree of freedom is left: assemblies cannot be counted; hold 1 of the coordinates",
        ),
        (
            ["free.yaml", "--hold", "A.angel"],
            "--hold: error: there is no coordinate 'A.angel'; did you mean 'A.angle'?",
        ),
        (
            ["free.yaml", "--hold", "A.angle=3 m"],
            "--hold A.angle: error: '--hold A.angle' is in rad, this is a length, in m",
        ),
        (["four_bar.yaml", "--set", "weight=2", "--write", "w"], "--write: error: --set has changed parameters"),
        (["missing.yaml"], "missing.yaml"),
    ],
)
def test_it_says_what_is_wrong(folder, arguments, message):
    done = command("branches", *arguments, folder=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_files_of_others_are_not_replaced(folder):
    (folder / "starts").mkdir()
    (folder / "starts" / "four_bar_1.yaml").write_text("mine\n")
    (folder / "both.png").write_text("mine\n")
    done = command("branches", "four_bar.yaml", "--write", "starts", folder=folder)
    assert done.returncode == 2 and "starts/four_bar_1.yaml" in done.stderr
    done = command("branches", "four_bar.yaml", "--picture", "both.png", folder=folder)
    assert done.returncode == 2 and "both.png" in done.stderr
    assert (folder / "both.png").read_text() == "mine\n"
    assert command("branches", "four_bar.yaml", "--write", "starts", "--force", folder=folder).returncode == 0
    assert (folder / "starts" / "four_bar_1.yaml").read_text().startswith("mbproj: 1")
