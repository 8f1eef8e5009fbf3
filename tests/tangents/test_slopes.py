"""Slopes of the motion by parameters, which dual numbers follow along a run, against differences of runs."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene
from mbproj.errors import InputError
from mbproj.integrate import choose, numbers_of
from mbproj.mechanisms_folder import mechanism
from tests.kernel.scenes import needs_kernel
from tests.studies.design.following import NEIGHBOURS, directions_of, follow

pytestmark = needs_kernel

#: Of each mechanism parameters, their values and by what neighbours differ: a length, a mass, a speed at the start.
CASES = {
    "five_bar": {"length": (1.0, 3e-4), "bodies.bar3.mass": (1.0, 3e-4), "joints.A.speed": (0.5, 3e-4)},
    "spatial_slider_crank": {
        "crank_length": (0.08, 3e-5),
        "bodies.rod.mass": (0.5, 3e-4),
        "speed": (6.0, 3e-3),
        "rod_pin": (4e-3, 3e-6),
        "bodies.slider.mass": (2.0, 1e-3),
    },
}
EXACT = {"integrator": "dop853", "tolerance": 1e-12, "step": None}


def builder(name, formulation="auto", **simulation):
    """Of the values of its parameters a mechanism ready to run; and its settings."""
    keys = {"duration": 0.5, "formulation": formulation, **simulation}

    def build(values):
        parameters = dict(zip(CASES[name], map(float, values), strict=True))
        scene = read_scene(mechanism(name), parameters, keys)
        system = compile_system(scene)
        state = assemble(system, initial_guess(scene, system))
        return choose(system, state, scene.settings).compiled, state, scene.settings

    return build


def values_and_widths(name):
    return np.array(list(CASES[name].values())).T


def tangents(name, **keys):
    """The run that was followed, the slopes of q and q' at its end, and what was built."""
    build, (values, widths) = builder(name, **keys), values_and_widths(name)
    compiled, state, directions = directions_of(lambda at: build(at)[:2], values, widths)
    followed = follow(compiled, state, build(values)[2], directions)
    return followed, np.concatenate(followed.coordinates(compiled), axis=1), compiled


def end(build, values):
    """q and q' at the end of a run."""
    compiled, state, settings = build(values)
    run = compiled.run(state, settings)
    run.advance(2**31, 1e9)
    assert compiled.failure(run, settings) is None
    return np.concatenate(compiled.coordinates(compiled.bodies_of(run.standing["y"])))


def differences(name, k, **keys):
    """The slope of q and q' at the end by parameter k, by four runs."""
    build, (values, widths) = builder(name, **keys), values_and_widths(name)
    step = np.eye(len(values))[k] * widths[k]
    return sum(weight * end(build, values + place * step) for place, weight in NEIGHBOURS) / widths[k]


@cache
def exact(name):
    return tangents(name, **EXACT)


@pytest.mark.parametrize(("name", "k"), [(name, k) for name, own in CASES.items() for k in range(len(own))])
def test_slopes_are_those_of_precise_runs(name, k):
    _, slopes, _ = exact(name)
    expected = differences(name, k, **EXACT)
    assert np.abs(expected).max() > 1e-3
    assert np.abs(slopes[k] - expected).max() < 2e-9 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("integrator", "projection", "apart"), [("rk4", "gpopm", 2e-5), ("dop853", "gpopm", 1e-8), ("rk4", "gopm", 3e-7)]
)
def test_slopes_of_coarse_steps_are_those_of_the_same_steps(integrator, projection, apart):
    """Fixed steps are the same for a neighbour. A projection whose factor is of another pose is not quite the least
    one: with RK4, whose steps leave 0.3 mm here, the slopes show that. GOPM has a factor of its own, of the pose."""
    keys = {"integrator": integrator, "step": 0.01, "duration": 0.3, "projection": projection}
    _, slopes, _ = tangents("spatial_slider_crank", **keys)
    for k in range(3):
        expected = differences("spatial_slider_crank", k, **keys)
        assert np.abs(slopes[k] - expected).max() < apart * np.abs(expected).max()


def test_states_are_those_of_the_run():
    followed, _, compiled = exact("five_bar")
    build, (values, _) = builder("five_bar", **EXACT), values_and_widths("five_bar")
    assert followed.t[0] == 0.0
    assert followed.t[-1] == 0.5
    own = np.concatenate(compiled.coordinates(compiled.bodies_of(followed.y[-1])))
    assert np.array_equal(own, end(build, values))


def test_slopes_keep_to_the_joints():
    """G ∂q = -∂C by the parameters: at the end all rows are closed for the neighbour that the slopes predict."""
    followed, _, _ = exact("spatial_slider_crank")
    build, (values, widths) = builder("spatial_slider_crank", **EXACT), values_and_widths("spatial_slider_crank")
    step = np.eye(len(values))[0] * widths[0]
    sides = []
    for place, weight in NEIGHBOURS:
        compiled = build(values + place * step)[0]
        y = followed.y[-1] + place * widths[0] * followed.slopes[-1, 0]
        sides.append(weight * compiled.equations().constraint(np.ascontiguousarray(compiled.bodies_of(y)), 0.5))
    assert np.abs(sum(sides) / widths[0]).max() < 1e-9


def test_planar_and_spatial_slopes_agree():
    _, planar, _ = exact("five_bar")
    _, spatial, _ = tangents("five_bar", formulation="reduced", **EXACT)
    assert spatial == pytest.approx(planar, abs=1e-8 * np.abs(planar).max())


def test_more_directions_than_a_dual_number_has():
    """They are followed in groups: each direction's slopes are the same in any group."""
    build, (values, widths) = builder("five_bar", **EXACT), values_and_widths("five_bar")
    compiled, state, three = directions_of(lambda at: build(at)[:2], values, widths)
    rows = np.arange(9) % 3
    nine = replace(three, numbers=three.numbers[rows], start=three.start[rows])
    followed = follow(compiled, state, build(values)[2], nine)
    assert np.array_equal(followed.slopes[-1], exact("five_bar")[0].slopes[-1][rows])


def test_numbers_of_a_model_are_what_a_parameter_changes():
    """A mass, and the inertia that the scene makes of it: no other number."""
    build, (values, widths) = builder("five_bar", formulation="reduced"), values_and_widths("five_bar")
    heavier = values + np.eye(3)[1] * widths[1]
    change = numbers_of(build(heavier)[0]) - numbers_of(build(values)[0])
    assert np.flatnonzero(change).tolist() == [2 * 10]  # of body 3 the mass, then nine moments
    assert change[20] == pytest.approx(widths[1])


@pytest.mark.parametrize(
    ("keys", "why"),
    [({"integrator": "radau5"}, "tableau is not that of explicit steps"), ({"projection": "baumgarte"}, "projection")],
)
def test_slopes_that_are_not_known_are_refused(keys, why):
    with pytest.raises(InputError, match=why):
        tangents("five_bar", **keys)
