"""A sweep's file: what it makes, and what is said of a wrong one, at its place."""

from __future__ import annotations

import pytest

from mbproj.base.errors import InputError
from mbproj.studies.sweep.spec import read_spec
from tests.studies.sweep.specs import MEASURE, complaints, write


def test_units_come_from_the_scene_and_else_from_the_sweep(tmp_path):
    vary = (
        "  length: 0.8 m:1.2 m:3\n  bodies.bar.mass: [1, 2]\n  simulation.projection: [gopm, gpopm]\n  fails: [0 s]\n"
    )
    spec = read_spec(write(tmp_path, vary))
    assert dict(spec.units) == {"length": "m", "bodies.bar.mass": "kg", "simulation.projection": "", "fails": "s"}
    assert spec.design.count == 12
    assert spec.measures[0].unit == "m"


@pytest.mark.parametrize(
    ("vary", "measure", "more", "lines"),
    [
        ("  lenght: [1]\n", MEASURE, "", ["4:3: error: unknown parameter 'lenght'; did you mean 'length'?"]),
        (
            "  bodies.baar.mass: [1]\n",
            MEASURE,
            "",
            ["4:3: error: the scene has no 'bodies.baar'; did you mean 'bar'?"],
        ),
        ("  bodies.bar.mas: [1]\n", MEASURE, "", ["4:3: error: unknown key 'mas'; did you mean 'mass'?"]),
        (
            "  bodies.bar.mass: [1, 2 m, 3, -1]\n  length: -1:1:3\n",
            MEASURE,
            "",
            [
                "4:24: error: 'mass' is in kg, this is a length, in m",
                "4:32: error: 'mass' must be at least 0, found -1",
            ],
        ),
        (
            "  simulation.projection: [gopm, gpomp]\n",
            MEASURE,
            "",
            ["4:33: error: unknown projection method 'gpomp'; did you mean 'gpopm'?"],
        ),
        (
            "  length: [1, 2]\n  fails: [0, 1, 0]\n",
            MEASURE,
            "combine: zip\n",
            ["4:3: error: 'length' has 2 values, and 'fails' has 3; zip takes ranges of one length"],
        ),
        (
            "  length: {uniform: [1, 2]}\n",
            MEASURE,
            "",
            [
                "4:3: error: 'grid' cannot take a distribution; combine: lhs, sobol, saltelli, montecarlo, or list its "
                "values"
            ],
        ),
        (
            "  length: {uniform: [1, 2]}\n",
            MEASURE,
            "combine: sobol\nsamples: 20\n",
            ["8:10: error: 'sobol' needs a power of 2 of samples, found 20; take 16 or 32"],
        ),
        (
            "  length: {uniform: [1, 2]}\n",
            MEASURE,
            "combine: lhs\n",
            ["7:10: error: 'lhs' needs 'samples'; add it: how many, a whole number"],
        ),
        (
            "  length: [1]\n",
            MEASURE,
            "seed: 1\n",
            ["7:7: error: 'grid' takes no 'seed'; leave it out, or combine: lhs, sobol, saltelli, montecarlo"],
        ),
        (
            "  length: [1]\n",
            "",
            "",
            ["5:9: error: 'measure' is empty; say what to measure, as in  tip: {marker: tip, quantity: position, ..}"],
        ),
        (
            "  length: [1]\n",
            "  x: {marker: ned, quantity: position, at: end, component: z}\n",
            "",
            ["6:15: error: unknown marker 'ned'; choose from: end"],
        ),
        (
            "  length: [1]\n",
            "  x: {marker: end, quantity: position, at: end}\n",
            "",
            ["6:30: error: 'position' has 3 components, and this is about one number; add component: x, y, z or norm"],
        ),
        (
            "  length: [1]\n",
            "  x: {marker: end, quantity: position, at: 0.105, component: z}\n",
            "",
            [
                "6:44: error: there is no sample at 0.105 s; the nearest are at 0.1 s and 0.11 s; choose one of "
                "them, or another 'output_step'"
            ],
        ),
        (
            "  length: [1]\n",
            "  length: {joint: pin, quantity: angle, at: end}\n",
            "",
            ["6:3: error: 'length' is another column of the summary; give the measure another name"],
        ),
        ("  length: [1]\n", MEASURE, "keeep: all\n", ["7:1: error: unknown key 'keeep'; did you mean 'keep'?"]),
    ],
)
def test_what_is_wrong_is_said_at_its_place(tmp_path, vary, measure, more, lines):
    assert complaints(write(tmp_path, vary, measure, more)) == lines


def test_a_scene_that_is_not_there_is_said_at_the_key_that_names_it(tmp_path):
    path = write(tmp_path, "  length: [1]\n")
    path.write_text(path.read_text().replace("pendulum.yaml", "pendulun.yaml"))
    (line,) = complaints(path)
    scene = tmp_path / "pendulun.yaml"
    assert line == f"2:8: error: scene '{scene}': there is no such file; did you mean 'pendulum.yaml'?"


def test_nothing_to_measure_is_a_missing_key(tmp_path):
    path = write(tmp_path, "  length: [1]\n", "")
    path.write_text(path.read_text().replace("measure:\n", ""))
    with pytest.raises(InputError, match=r"error: missing key 'measure'"):
        read_spec(path)
