"""Command line over scene over defaults, and what a run needs."""

from __future__ import annotations

from typing import Any

import pytest

from mbproj.base.errors import InputError, Place
from mbproj.base.registry import PROJECTIONS
from mbproj.base.settings import ProjectionSettings
from mbproj.scene.settings import settings_to_run
from tests.scene.scenes import GOOD, changed, errors, read, read_with

BARE_SCENE = "mbproj: 1\ngravity: [0, 0, 0]\nbodies: {b: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}\n"


GAINS: list[tuple[Any, tuple[float, float]]] = [("5", (5, 5)), ("4,9", (4, 9)), ((4, 9.5), (4, 9.5)), (2.5, (2.5, 2.5))]


@pytest.mark.parametrize(("written", "gains"), GAINS)
def test_gains(written: Any, gains: tuple[float, float]) -> None:
    settings = read(GOOD, simulation={"projection": "baumgarte", "gains": written}).settings
    assert settings.projection.gains == gains


def test_the_command_line_wins_and_none_is_not_given() -> None:
    settings = read(GOOD, simulation={"duration": 3, "step": None}).settings
    assert (settings.duration, settings.step) == (3.0, 0.01)


def test_options_may_name_parameters_of_the_scene() -> None:
    assert read(GOOD, simulation={"duration": "2 * rod_length"}).settings.duration == 0.6


def test_a_tolerance_replaces_the_scenes_step_and_the_other_way_round() -> None:
    settings = read(GOOD, simulation={"tolerance": 1e-7, "integrator": "dopri5"}).settings
    assert (settings.step, settings.tolerance) == (None, 1e-7)
    text = changed("step: 0.01\n  integrator: rk4", "tolerance: 1e-6\n  integrator: dopri5")
    settings = read(text, simulation={"step": 0.005}).settings
    assert (settings.step, settings.tolerance) == (0.005, None)


@pytest.mark.parametrize("method", PROJECTIONS)
def test_a_methods_own_options_have_defaults_and_others_have_none(method: str) -> None:
    projection = read_with("projection: gpopm", f"projection: {method}").settings.projection
    alpha = 1e7 if method in ("mmopm", "mass-orthogonal") else None
    gains = (25.0, 25.0) if method == "baumgarte" else None
    assert (projection.method, projection.alpha, projection.gains) == (method, alpha, gains)


def test_another_method_leaves_behind_what_it_does_not_take() -> None:
    text = changed("projection: gpopm", "projection: {method: mmopm, tolerance: 1e-9, every: 4, alpha: 5}")
    as_gopm = read(text, simulation={"projection": "gopm"}).settings.projection
    assert as_gopm == ProjectionSettings("gopm", 1e-9, every=4)
    assert read(text, simulation={"projection": "none"}).settings.projection == ProjectionSettings("none")
    orthogonal = read(text, simulation={"projection": "mass-orthogonal"}).settings.projection
    assert orthogonal == ProjectionSettings("mass-orthogonal", 1e-9, every=4, alpha=5.0)


WRONG_OPTIONS: tuple[tuple[dict[str, Any], list[str]], ...] = (
    ({"projection_tolerance": "-1"}, ["--projection-tolerance: error: 'tolerance' must be greater than 0, found -1"]),
    (
        {"step": 0.1, "tolerance": 1e-3},
        ["--tolerance: error: 'step' and 'tolerance' cannot both be given; keep one of them"],
    ),
    (
        {"tolerance": 1e-6},
        [
            "--tolerance: error: 'rk4' has no error estimate, which 'tolerance' needs; these have one: bs32, dopri5, "
            "dop853, esdirk4, radau5, auto"
        ],
    ),
    (
        {"step": 0.003},
        [
            "--step: error: 'output_step' (0.01 s) is not a whole multiple of 'step' (0.003 s); "
            "set 'output_step' to 0.009 s"
        ],
    ),
    (
        {"step": 1e-30, "output_step": 1e30},
        [
            "--output-step: error: 'output_step' (1e+30 s) is not a whole multiple of 'step' (1e-30 s); "
            "set 'output_step' to 1e-15 s",
            "--step: error: 'step' of 1e-30 s: 16 digits cannot tell so many steps apart in the duration of 10 s; "
            "make it 1e-14 s or longer, or the duration shorter",
        ],
    ),
    (
        {"integrator": "dop853", "tolerance": 1e-6, "output_step": 1e-30},
        [
            "--output-step: error: 'output_step' of 1e-30 s: more than 1e+07 samples in the duration of 10 s; "
            "make it 1e-06 s or longer, or the duration shorter"
        ],
    ),
    (
        {"duration": 1e49},
        [
            "--duration: error: 'step' of 0.01 s: 16 digits cannot tell so many steps apart in the "
            "duration of 1e+49 s; make it 1e+34 s or longer, or the duration shorter"
        ],
    ),
    ({"step": float("nan")}, ["--step: error: numbers must be finite"]),
    ({"duration": "10 m"}, ["--duration: error: 'duration' is in s, this is a length, in m"]),
    ({"duration": "1 +"}, ["--duration: error: the expression ends too early"]),
    ({"integrator": "rk"}, ["--integrator: error: unknown integrator 'rk'; did you mean 'rk4'?"]),
    ({"project_position": "maybe"}, ["--project-position: error: 'position' needs true or false, found 'maybe'"]),
    (
        {"projection": "none", "every": 3},
        [
            "--every: error: projection method 'none' has no 'every'; these have: "
            + ", ".join(name for name, entry in PROJECTIONS.items() if entry.corrects)
        ],
    ),
    ({"alpha": 3}, ["--alpha: error: projection method 'gpopm' has no 'alpha'; these have: mass-orthogonal, mmopm"]),
    ({"stepp": 3}, ["--stepp: error: unknown option 'stepp'; did you mean 'step'?"]),
    (
        {"every": 0, "step": "x"},
        [
            "--step: error: unknown name 'x'; parameters are defined under 'parameters'",
            "--every: error: 'every' must be at least 1, found 0",
        ],
    ),
)


@pytest.mark.parametrize(("given", "messages"), WRONG_OPTIONS)
def test_wrong_options(given: dict[str, Any], messages: list[str]) -> None:
    assert errors(GOOD, simulation=given) == messages


def test_problems_of_the_command_line_come_before_those_of_the_file() -> None:
    messages = errors(changed("mass: 0.12", "mass: -1"), simulation={"every": 0}, parameters={"rod": 1})
    assert messages == [
        "--set rod: error: unknown parameter 'rod'; parameters are: crank_length, rod_length",
        "--every: error: 'every' must be at least 1, found 0",
        "f.yaml:15:11: error: 'mass' must be at least 0, found -1",
    ]


def test_an_output_step_is_a_multiple_within_round_off() -> None:
    assert read_with("output_step: 0.01", "output_step: 0.07").settings.output_step == 0.07


def test_parameters_are_changed_by_text_or_number() -> None:
    scene = read(GOOD, parameters={"crank_length": "rod_length / 3", "rod_length": 0.6})
    assert scene.parameters == {"crank_length": 0.6 / 3, "rod_length": 0.6}
    assert scene.joints[1].points.first[2] == 0.12 + 0.6 / 3
    assert scene.overrides == {"crank_length": "rod_length / 3", "rod_length": "0.6"}
    assert scene.places["parameters", "crank_length"] == Place("--set crank_length")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        (
            "crank_lenght",
            1,
            "--set crank_lenght: error: unknown parameter 'crank_lenght'; did you mean 'crank_length'?",
        ),
        ("rod_length", "2 *", "--set rod_length: error: the expression ends too early"),
        (
            "rod_length",
            "rod_length",
            "--set rod_length: error: parameters that depend on each other: rod_length -> rod_length; "
            "give one of them a number",
        ),
        ("rod_length", "", "--set rod_length: error: 'rod_length' needs a number, found nothing"),
    ],
)
def test_wrong_changes_of_parameters(name: str, value: Any, message: str) -> None:
    assert errors(GOOD, parameters={name: value}) == [message]


def test_a_scene_without_parameters_has_none_to_set() -> None:
    message = "--set a: error: unknown parameter 'a'; the scene has no parameters"
    assert errors(BARE_SCENE, parameters={"a": 1}) == [message]


def test_places_of_options() -> None:
    places = read(GOOD, simulation={"step": 0.005, "projection": "mmopm", "alpha": 3}).places
    assert places["simulation", "step"] == Place("--step")
    assert places["simulation", "projection", "alpha"] == Place("--alpha")
    assert str(places["simulation", "projection"]) == "f.yaml:12:15"


def test_settings_to_run() -> None:
    assert settings_to_run(read(GOOD)) == read(GOOD).settings


def test_a_scene_that_does_not_say_how_long_or_by_which_step() -> None:
    with pytest.raises(InputError) as raised:
        settings_to_run(read(BARE_SCENE))
    assert [str(problem).splitlines()[0] for problem in raised.value.problems] == [
        "f.yaml:1:1: error: the scene has no duration; add 'duration' to 'simulation', or --duration",
        "f.yaml:1:1: error: the scene has neither step nor tolerance; add one of them to 'simulation', or --step or "
        "--tolerance",
    ]
    assert settings_to_run(read(BARE_SCENE, simulation={"duration": 1, "step": 0.1})).step == 0.1
