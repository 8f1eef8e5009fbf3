"""Every file in mechanisms/: it is read, closes, has the degrees of freedom that its comment says, and stays closed."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, mobility, read_scene
from mbproj.equations.constraints import constraint_at, constraint_velocity_at
from mbproj.equations.kinematics import pose_of
from tests.crossed import some
from tests.mechanisms.running import run
from tests.support import MECHANISMS, REDUNDANT, assembled

#: Bodies and degrees of freedom: the spatial four-bar's with the idle spin of its rod, the engine is driven.
SIZES = {
    "bennett": (3, 1),
    "bicycle": (4, 3),
    "bouncing_ball": (1, 6),
    "bricard": (5, 1),
    "bump_stop": (2, 2),
    "cam": (2, 0),
    "chaplygin_sleigh": (1, 2),
    "crane": (2, 5),
    "delta_robot": (10, 3),
    "differential": (3, 2),
    "door_closer": (1, 1),
    "door_with_stop": (1, 1),
    "double_pendulum": (2, 2),
    "drum_brake": (3, 1),
    "five_bar": (5, 5),
    "free_body": (1, 6),
    "geneva": (2, 1),
    "governor": (4, 2),
    "heavy_top": (1, 3),
    "hoist": (2, 1),
    "hooke_shaft": (3, 1),
    "inline_four": (9, 0),
    "locomotive": (4, 1),
    "massless_coupler": (3, 1),
    "n_four_bar": (5, 1),
    "newtons_cradle": (5, 5),
    "physical_pendulum": (1, 1),
    "planar_four_bar": (3, 1),
    "quarter_car": (5, 2),
    "rocking_cabinet": (1, 3),
    "rattleback": (1, 3),
    "rolling_coin": (1, 3),
    "screw_press": (1, 1),
    "spatial_four_bar": (3, 2),
    "spatial_slider_crank": (3, 1),
    "spherical_pendulum": (1, 3),
    "split_coupler": (4, 4),
    "steered_car": (5, 1),
    "stewart_platform": (13, 6),
    "stick_slip": (2, 1),
    "swinging_atwood": (3, 3),
    "turntable": (2, 3),
    "valve_train": (3, 3),
}

#: Steps that knots of curves split, in the first 20 ms: the cam begins on one.
KNOTS = {"cam": 1, "valve_train": 3}


@pytest.mark.parametrize("path", MECHANISMS, ids=lambda path: path.stem)
def test_closes_with_the_degrees_of_freedom_of_the_table(path):
    system, state = assembled(read_scene(path))
    assert np.abs(constraint_at(system, state.q)).max() <= 1e-13
    assert np.abs(constraint_velocity_at(system, state.q, state.v)).max() <= 1e-13
    ranks = mobility(system, pose_of(state.q))
    assert (system.bodies, ranks.degrees_of_freedom) == SIZES[path.stem]
    assert sum(ranks.redundant.values()) == REDUNDANT.get(path.stem, 0)
    assert ranks.massless == ()


@pytest.mark.parametrize("path", MECHANISMS, ids=lambda path: path.stem)
def test_closes_at_the_pose_that_it_gives(path):
    """Within round-off: no body is moved by assembly."""
    scene = read_scene(path)
    system = compile_system(scene)
    guess = initial_guess(scene, system)
    assert np.abs(assemble(system, guess).q - guess.q).max() <= 1e-13


@pytest.mark.parametrize("path", some(MECHANISMS, 4), ids=lambda path: path.stem)
def test_stays_closed_over_20_steps(path):
    done = run(path.stem, step="1 ms", duration="20 ms", output_step="1 ms", kinematic="false")
    assert done.report.counters["steps"] == 20 + KNOTS.get(path.stem, 0)
    assert done.report.position_violation.value <= 1e-13
    assert done.report.velocity_violation.value <= (1e-12 if path.stem in REDUNDANT else 1e-13)
    assert np.abs(done["markers/position"][-1] - done["markers/position"][0]).max() > 1e-6


@pytest.mark.parametrize("path", MECHANISMS, ids=lambda path: path.stem)
def test_says_what_it_is(path):
    scene = read_scene(path)
    assert scene.text.startswith("# ")
    assert len(scene.title) > 10
    assert scene.markers
