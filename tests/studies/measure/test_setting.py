"""A setting says the same in every rendering: its options, its command line, the scene's keys."""

from __future__ import annotations

import shlex

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbproj.base.errors import InputError
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.studies.measure.setting import Setting, shortest
from tests.support import ROOT

SCENE = ROOT / "mechanisms" / "physical_pendulum.yaml"
SETTINGS = [
    Setting("gpopm", "dop853", tolerance=1e-8),
    Setting("none", "rk4", step=0.005, formulation="full"),
    Setting("baumgarte", "rk4", step=0.005, gains=(10.0, 20.0)),
    Setting("gopm", "bs32", step=0.0025, every=3, threshold=1e-6, projection_tolerance=1e-10, max_iterations=4),
    Setting("mmopm", "heun2", step=0.001, alpha=1e5, projection_test="paper", project_velocity=False),
]


def test_command_line():
    line = "--integrator dop853 --tolerance 1e-8 --projection gpopm"
    assert Setting("gpopm", "dop853", tolerance=1e-8).command_line() == line
    scene = read_scene(SCENE, {}, {"every": 4, "threshold": 1e-3})
    line = Setting("gpopm", "rk4", step=0.01).command_line(scene.settings)
    assert line == "--integrator rk4 --step 0.01 --projection gpopm --every 1 --threshold 1e-50"


@pytest.mark.parametrize("setting", SETTINGS, ids=lambda setting: setting.label)
@pytest.mark.parametrize("before", [{}, {"every": 4, "threshold": 1e-3}, {"projection": "none", "integrator": "bs32"}])
def test_the_command_line_gives_the_setting_over_any_scene(setting, before):
    scene = read_scene(SCENE, {}, before)
    words = shlex.split(setting.command_line(scene.settings))
    names = [word.removeprefix("--").replace("-", "_") for word in words[::2]]
    options = dict(zip(names, words[1::2], strict=True))
    kept = [f"{key}: {value}" for key, value in before.items() if key in ("every", "threshold")]
    method = before.get("projection", "gpopm")
    text = scene.text.replace("projection: gpopm", f"projection: {{{', '.join([f'method: {method}', *kept])}}}")
    again = Setting.of(read_scene_text(text, simulation=options).settings)
    expected = Setting.of(setting.settings(1.0, 0.25))
    if setting.threshold is None and "threshold" in before and again.threshold is not None:
        assert again.threshold == 1e-50
        again = Setting(**{**vars(again), "threshold": None})
    assert again == expected


def test_what_does_not_fit_is_an_error():
    with pytest.raises(InputError, match=r"'output_step' \(1 s\) is not a whole multiple of 'step' \(0.3 s\)"):
        Setting(step=0.3).settings(2.0, 1.0)
    with pytest.raises(InputError, match="unknown projection method 'gpom'; did you mean 'gpopm'"):
        Setting("gpom", step=0.1).settings(1.0, 1.0)
    with pytest.raises(InputError, match="'rk4' has no error estimate"):
        Setting(tolerance=1e-6).settings(1.0, 1.0)


@given(st.floats(min_value=1e-300, max_value=1e300))
def test_shortest_reads_back(value):
    assert float(shortest(value)) == value


def test_shortest():
    assert [shortest(value) for value in (1e-8, 0.01, 2.5e-7, 1e20)] == ["1e-8", "0.01", "2.5e-7", "1e20"]
