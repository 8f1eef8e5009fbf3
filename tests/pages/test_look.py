"""What a mechanism and its forces look like: solids, glyphs of joints, gears that mesh, and passages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj import Scene, assemble, compile_system, initial_guess, read_scene, read_scene_text
from mbproj.joints.table import JOINTS
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.show.appearance.bodies import solid_of
from mbproj.show.appearance.joints import GLYPHS, radii, sketch_of
from mbproj.show.appearance.layout import PartNumbers
from mbproj.show.appearance.mechanism import look_of, view_of
from mbproj.show.appearance.motion import PoseHistory, motion_at
from mbproj.show.appearance.parts import bar, hull, plate, turn_to
from mbproj.show.page.pages import carried, dips, load_groups, passages
from tests.crossed import some
from tests.linear.closed_forms import chain
from tests.support import MECHANISMS, assembled, random_chain

# What a mechanism looks like: solids of equal inertia, glyphs of every joint, gears that mesh, where to look from.

LENGTHS = st.floats(0.01, 10.0)


def start(scene: Scene) -> PoseHistory:
    system, state = assembled(scene)
    return motion_at(system, state.q)


@settings(max_examples=40, deadline=None)
@given(st.tuples(LENGTHS, LENGTHS, LENGTHS), st.floats(0.1, 100.0), st.integers(0, 2**31))
def test_the_solid_of_a_box_is_that_box(edges, mass, seed):
    a, b, c = edges
    own = mass / 12.0 * np.diag([b * b + c * c, c * c + a * a, a * a + b * b])
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    solid = solid_of(mass, turn @ own @ turn.T, 1e-6)
    assert solid is not None
    if solid.kind == "cylinder":  # two edges alike: the same moments, another outline
        radius, length = solid.size
        moments = mass * np.array([radius**2 / 2, *[(3 * radius**2 + length**2) / 12] * 2])
        assert np.allclose(sorted(moments), sorted(np.diag(own)), rtol=1e-4)
    else:
        assert np.allclose(sorted(solid.size), sorted(edges), rtol=1e-5)


def test_the_solid_of_a_disc_is_that_disc():
    solid = solid_of(15.0, np.diag([0.234375, 0.234375, 0.46875]), 1e-3)  # of the heavy top
    assert solid is not None and solid.kind == "cylinder"
    assert solid.size == pytest.approx((0.25, 1e-3))
    assert np.allclose(np.abs(solid.rotation[:, 2]), [0, 0, 1])


def test_a_point_has_no_solid():
    assert solid_of(0.0, np.zeros((3, 3)), 0.1) is None
    assert solid_of(1.0, np.zeros((3, 3)), 0.1) is None


@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda axis: np.linalg.norm(axis) > 1e-3))
def test_the_shortest_turn_takes_z_to_the_axis(axis):
    found = rotation_matrix(turn_to(np.array(axis))) @ [0, 0, 1]
    assert np.allclose(found, np.array(axis) / np.linalg.norm(axis), atol=1e-6)


def test_a_bar_ends_where_it_was_told_to():
    rod, *ends = bar(np.array([1.0, 2.0, 3.0]), np.array([1.0, 5.0, 3.0]), 0.1)
    assert rod.size == (0.1, 3.0)
    assert np.allclose(np.ptp(rod.outline(), axis=0), [0.2, 3.0, 0.2], atol=1e-12)
    assert [end.position.tolist() for end in ends] == [[1, 2, 3], [1, 5, 3]]


@given(st.lists(st.tuples(st.integers(-50, 50), st.integers(-50, 50)), min_size=3, max_size=40, unique=True))
def test_a_hull_holds_its_points_and_turns_left(points):
    cloud = np.array(points, dtype=float)
    if np.linalg.matrix_rank(cloud - cloud[0]) < 2:
        return
    corners = hull(cloud)
    sides = np.roll(corners, -1, axis=0) - corners
    for corner, side in zip(corners, sides, strict=True):
        away = cloud - corner
        assert (side[0] * away[:, 1] - side[1] * away[:, 0] >= -1e-9).all()


def test_a_plate_lies_in_the_plane_of_its_points_and_points_on_a_line_make_none():
    points = [np.array(point) for point in ([0.0, 0, 1], [2.0, 0, 1], [0.0, 3, 1])]
    (part,) = plate(points, 0.1)
    corners = part.outline()
    assert np.ptp(corners[:, 2]) == pytest.approx(0.1)
    assert part.mesh is not None
    a, b, c = (part.mesh.vertices[part.mesh.triangles[:, corner]] for corner in range(3))
    assert (np.einsum("ti,ti->t", np.cross(b - a, c - a), (a + b + c) / 3) > 0).all()  # the outside is outside
    assert plate([np.array([x, 0.0, 0.0]) for x in (0, 1, 2)], 0.1) == ()


def test_every_joint_type_has_a_glyph_but_gears_which_have_wheels():
    assert set(GLYPHS) == {sketch_of(name) for name, kind in JOINTS.items() if kind.frame != "joints"}


@pytest.mark.parametrize("kind", sorted(JOINTS))
def test_each_joint_is_seen_on_its_bodies(kind):
    scene = random_chain(7, ["revolute", kind])
    scene = replace(scene, joints=tuple(replace(joint, reaction=False) for joint in scene.joints))
    motion = start(scene)
    look = look_of(scene, motion, {})
    number = [joint.name for joint in scene.joints].index("J1")
    parts = [drawn for drawn in look.drawn if drawn.layer != "bodies" and drawn.item == number]
    assert parts
    assert {drawn.carrier for drawn in parts} <= {0, 1}
    ends = [motion.point(body, part) for body, part in [(1, look.joints[number].point)]]
    near = min(np.linalg.norm(motion.point(drawn.carrier, drawn.part.position) - ends[0]) for drawn in parts)
    assert near <= 2.0 * look.size


def test_wheels_of_a_gear_meet_at_their_pitch_circles():
    points, axes = [np.zeros(3), np.array([0.3, 0.0, 0.7])], [np.array([0.0, 0, 1])] * 2
    outside = radii(points, axes, (20.0, 40.0))
    assert outside == pytest.approx((0.1, 0.2))
    inside = radii(points, axes, (20.0, -60.0))
    assert inside == pytest.approx((0.15, 0.45))
    assert radii(points, [axes[0], np.array([0.0, 1, 0])], (20.0, 40.0)) is None
    assert radii([points[0], points[0] + axes[0]], axes, (20.0, 40.0)) is None


@pytest.mark.parametrize("path", some(MECHANISMS, 3, 1), ids=lambda path: path.stem)
def test_every_shipped_mechanism_is_drawn_where_its_joints_are(path):
    scene = read_scene(path)
    motion = start(scene)
    look, layout = look_of(scene, motion, {}), PartNumbers.of(scene, motion)
    assert {drawn.item for drawn in look.drawn if drawn.layer == "bodies"} == set(range(len(scene.bodies)))
    types = {joint.name: joint.type for joint in scene.joints}
    for name, (first, second) in layout.bodies.items():
        frame = layout.frames[name]
        if ("coincident", "p1", "p2") in JOINTS[types[name]].rows:
            ends = motion.point(first, frame["p1"]), motion.point(second, frame["p2"])
            assert np.linalg.norm(ends[0] - ends[1]) <= 1e-9 * look.size  # they were assembled


FLAT = {"five_bar": 1, "n_four_bar": 1, "planar_four_bar": 1, "double_pendulum": 1, "massless_coupler": 1}


@pytest.mark.parametrize(("name", "axis"), FLAT.items())
def test_a_planar_mechanism_is_seen_along_its_normal(name, axis):
    scene = read_scene(next(path for path in MECHANISMS if path.stem == name))
    motion = start(scene)
    view = view_of(scene, motion, look_of(scene, motion, {}))
    assert view.flat
    assert np.abs(view.eye[axis]) == pytest.approx(1.0)
    assert np.allclose(view.up, [0, 0, 1])
    assert np.cross(view.up, view.eye)[0] == pytest.approx(1.0)  # x goes to the right


@pytest.mark.parametrize("name", ["stewart_platform", "spherical_pendulum", "heavy_top", "inline_four", "free_body"])
def test_others_are_seen_from_above_and_one_side(name):
    scene = read_scene(next(path for path in MECHANISMS if path.stem == name))
    motion = start(scene)
    view = view_of(scene, motion, look_of(scene, motion, {}))
    assert not view.flat
    assert view.eye @ view.up == pytest.approx(np.sin(np.radians(22.0)))
    assert np.linalg.norm(view.eye) == pytest.approx(1.0)


@pytest.mark.parametrize("links", [5, 300])
def test_links_of_a_long_chain_stay_slender(links):
    scene = read_scene_text(chain(links))
    layout = PartNumbers.of(scene, start(scene))
    assert layout.thickness <= 0.1 / links  # of links of 1 m / links


# What forces are drawn as, given forces over a run, and passages near singular positions.

FORCES = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, step: 0.01}
bodies:
  arm: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, -0.5], orientation: {axis: [0, 1, 0], angle: 30 deg}}
  sled: {mass: 1, shape: {box: [0.2, 0.15, 0.1]}, position: [0.7, 0, -0.2]}
  engine: {mass: 2, shape: {box: [0.3, 0.2, 0.2]}, position: [-0.6, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, 1, 0]}
  rail: {type: prismatic, bodies: [ground, sled], location: [0.4, 0, -0.2], axis: [1, 0, 0]}
forces:
  twist: {type: torsion_spring_damper, joint: pin, stiffness: 3}
  slide: {type: linear_spring_damper, joint: rail, stiffness: 100, free_displacement: 0.2}
  rubbing: {type: torsion_spring_damper, joint: pin, damping: 3}
  mount:
    type: bushing
    bodies: [ground, engine]
    location: [-0.6, 0, -0.1]
    axes: {axis: [0, 1, 0], angle: 90 deg}
    stiffness: {translation: [4e3, 4e3, 4e3], rotation: [30, 30, 30]}
  wind: {type: force, body: arm, location: [0, 0, -1], force: [3*sin(4*t), 0, 1]}
  jet: {type: force, body: arm, force: [2, 0, 0], axes: body}
  spin: {type: torque, body: engine, torque: [0, 2*cos(9*t), 0]}
"""
#: A parallelogram of bars 1 m and 2 m long; where it is flat its rows depend on each other.
PARALLELOGRAM = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, step: 0.01}
bodies:
  left: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.5]}
  right: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0.5]}
  top: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 1]}
joints:
  A: {type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [left, top], location: [0, 0, 1], axis: [0, 1, 0]}
  C: {type: spherical, bodies: [top, right], location: [2, 0, 1]}
  D: {type: revolute, bodies: [right, ground], location: [2, 0, 0], axis: [0, 1, 0]}
"""


@pytest.fixture(scope="module")
def drawn():
    scene = read_scene_text(FORCES)
    system = compile_system(scene)
    motion = motion_at(system, assemble(system, initial_guess(scene, system)).q)
    return scene, system, motion, look_of(scene, motion, {})


def test_each_kind_of_spring_has_its_parts(drawn):
    scene, _, motion, look = drawn
    names = [force.name for force in scene.forces]
    parts = [(names[part.item], part.carrier, part.part.kind) for part in look.drawn if part.layer == "springs"]
    assert parts == [("twist", -1, "mesh"), ("mount", -1, "tube"), ("mount", 2, "cylinder")]
    ring, pin = (part for part in look.drawn if part.layer == "springs" and names[part.item] == "mount")
    for part in (ring, pin):  # both stand at the frame, along its z: global x
        at = motion.point(part.carrier, part.part.position)[0]
        along = motion.vector(part.carrier, part.part.rotation[:, 2])[0]
        assert at == pytest.approx([-0.6, 0.0, -0.1])
        assert np.abs(along) == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    (span,) = look.spans
    assert (span.kind, span.name, span.carriers) == ("spring", "slide", (-1, 1))


def test_given_forces_are_those_of_the_scene_in_global_axes(drawn):
    _, system, motion, look = drawn
    times = np.array([0.0, 0.1, 0.4])
    repeated = PoseHistory(times, np.repeat(motion.position, 3, axis=0), np.repeat(motion.orientation, 3, axis=0))
    (forces, pushed), (torques, turned) = load_groups(system, look.loads, repeated)
    assert (forces.owners, forces.units, torques.owners) == (("wind", "jet"), ("N", "N"), ("spin",))
    zero = 0.0 * times
    np.testing.assert_allclose(pushed[:, :3], np.column_stack([3 * np.sin(4 * times), zero, zero + 1]), atol=1e-14)
    along = rotation_matrix(motion.orientation[0, 0]) @ [2.0, 0.0, 0.0]
    np.testing.assert_allclose(pushed[:, 3:], np.tile(along, (3, 1)), atol=1e-14)
    np.testing.assert_allclose(turned, np.column_stack([zero, 2 * np.cos(9 * times), zero]), atol=1e-14)
    wind = look.loads[0]
    assert motion.point(wind.body, wind.point)[0] == pytest.approx([0.0, 0.0, -1.0])


def parallelogram(angles):
    """The motion in which the short bars lean by these angles from the vertical, 0.01 s apart."""
    turn = np.stack([np.cos(angles / 2), 0 * angles, np.sin(angles / 2), 0 * angles], axis=-1)
    upright = np.broadcast_to([1.0, 0.0, 0.0, 0.0], turn.shape)
    half = 0.5 * np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=-1)
    position = np.stack([half, np.array([2.0, 0.0, 0.0]) + half, 2 * half + [1.0, 0.0, 0.0]], axis=1)
    return PoseHistory(0.01 * np.arange(len(angles)), position, np.stack([turn, turn, upright], axis=1))


def test_a_parallelogram_passes_a_singular_position_where_it_is_flat():
    system = compile_system(read_scene_text(PARALLELOGRAM))
    angles = np.radians(np.linspace(0.0, 180.0, 181))
    ((time, part),) = passages(system, parallelogram(angles))
    assert time == pytest.approx(0.90)
    assert part < 1e-10
    assert list(passages(system, parallelogram(angles[:60]))) == []


def test_what_carries_bodies_is_where_they_say():
    scene = read_scene_text(PARALLELOGRAM.replace("type: spherical", "type: fixed").replace("  D:", "  #D:"))
    system = compile_system(scene)
    q = assemble(system, initial_guess(scene, system)).q
    assert system.bodies < len(scene.bodies)
    assert carried(system, motion_at(system, q))[0] == pytest.approx(q)


def test_a_dip_counts_once_and_begins_and_ends_above_the_limit():
    assert list(dips(np.array([0.0, 1, 0.4, 0.2, 0.3, 1, 0.1, 1, 0.2]), 0.5)) == [3, 6]
    assert list(dips(np.ones(4), 0.5)) == []
