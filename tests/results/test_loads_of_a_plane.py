"""Which loads of a machine that moves in a plane are unique, and how large they are where a friction reverses."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import open_results, read_scene_text, run
from mbproj.results.analysis.loads import loads_of

#: A crank of 0.1 m drives a rocker of 0.2 m, whose hinge rubs. `turned` is the pose of its plane in the world.
FOUR_BAR = """
mbproj: 1
gravity: {gravity}
simulation: {{duration: 1.1, kinematic: true, output_step: {step}}}
bodies:
  crank: {{mass: 1, inertia: [0.01, 0.01, 0.001], position: {crank}, orientation: {{matrix: {turned}}}}}
  coupler: {{mass: 2, inertia: [0.01, 0.05, 0.05], position: {coupler}, orientation: {{matrix: {turned}}}}}
  rocker: {{mass: 1.5, inertia: [0.02, 0.02, 0.001], position: {rocker}, orientation: {{matrix: {turned}}}}}
joints:
  A: {{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: {axis}}}
  B: {{type: revolute, bodies: [crank, coupler], location: {B}, axis: {axis}}}
  C: {{type: revolute, bodies: [coupler, rocker], location: {C}, axis: {axis}}}
  D: {{type: revolute, bodies: [ground, rocker], location: {D}, axis: {axis}}}
forces:
  rub: {{type: friction, joint: D, coulomb: {{torque: 3}}}}
motions:
  drive: {{joint: A, angle: {{constant_speed: 6 rad/s}}}}
"""
POINTS = {
    "crank": (0.0, 0.0, 0.05),
    "coupler": (0.2, 0.0, 0.15),
    "rocker": (0.4, 0.0, 0.1),
    "B": (0.0, 0.0, 0.1),
    "C": (0.4, 0.0, 0.2),
    "D": (0.4, 0.0, 0.0),
    "axis": (0.0, 1.0, 0.0),
}


def four_bar(path, yaw, tilt, *, across=0.0, step=0.01):
    """The loads of a run by (kind, name, quantity), with gravity `across` the plane."""
    (c, s), (ct, st) = ((np.cos(a), np.sin(a)) for a in (yaw, tilt))
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ [[1, 0, 0], [0, ct, -st], [0, st, ct]]
    given = {name: (turned @ point).tolist() for name, point in POINTS.items()}
    gravity = (turned @ [0.0, across, -9.81]).tolist()
    text = FOUR_BAR.format(**given, gravity=gravity, turned=turned.tolist(), step=step)
    run(read_scene_text(text), output=path).close()
    with open_results(path) as results:
        assert len(results.constant("joints/reaction_force_open")) == 4
        return {(load.kind, load.name, load.quantity): load for load in loads_of(results)}


@pytest.mark.parametrize(("yaw", "tilt"), [(0.0, 0.0), (0.7, 0.4)])
def test_bearings_share_only_loads_out_of_the_plane(tmp_path, yaw, tilt):
    """All were starred, since their components out of the plane are not unique."""
    loads = four_bar(tmp_path / "in.h5", yaw, tilt)
    assert all(loads["joint", name, "reaction_force"].unique for name in "ABCD")
    loads = four_bar(tmp_path / "across.h5", yaw, tilt, across=2.0)
    assert not any(loads["joint", name, "reaction_force"].unique for name in "ABCD")


def test_peaks_at_a_reversal_are_within_their_uncertainty(tmp_path):
    """Beside samples a hundred times as dense. The stated ± was round-off, and the peak off by a part in a thousand."""
    fine = four_bar(tmp_path / "fine.h5", 0.0, 0.0, step=1e-4)
    for step, known in ((0.03, 0.1), (0.01, 2e-5)):
        coarse = four_bar(tmp_path / "coarse.h5", 0.0, 0.0, step=step)
        for name in "ABCD":
            found, exact = (each["joint", name, "reaction_force"] for each in (coarse, fine))
            assert abs(found.largest - exact.largest) <= found.uncertainty + 1e-9
            assert found.uncertainty < known * exact.largest
