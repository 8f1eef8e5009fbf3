"""What forces are drawn as, given forces over a run, and passages near singular positions."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.scene.scene import read_scene_text
from mbproj.show.appearance.mechanism import look_of
from mbproj.show.appearance.motion import PoseHistory, motion_at
from mbproj.show.page.pages import carried, dips, load_groups, passages

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
