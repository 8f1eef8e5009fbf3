"""Each setting acts through each of its doors: the scene, the command line, Python; the file and the store know it."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any

import pytest
from click.testing import CliRunner

import mbproj
from mbproj.base.settings import HOW, SETTINGS, option_name, settings_taken
from mbproj.commands.main import mbproj as group
from mbproj.commands.options import RunSettings

#: A pendulum on a hinge with a rigid stop that it does not reach.
SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {BLOCK}
bodies: {rod: {mass: 1 kg, inertia: [0.02, 0.02, 0.001], position: [0.03, 0, -0.25]}}
joints:
  pin:
    type: revolute
    bodies: [ground, rod]
    location: [0, 0, 0]
    axis: [0, 1, 0]
    limits: {angle: {range: [-2, 2], rigid: true, restitution: 0.5}}
"""
BASE: dict[str, Any] = {"duration": 0.04, "step": 0.01}
#: Another value of each setting, and other settings that it needs.
OTHER: dict[str, tuple[Any, dict[str, Any]]] = {
    "duration": (0.05, {}),
    "step": (0.02, {}),
    "tolerance": (1e-6, {"integrator": "dopri5"}),
    "integrator": ("heun2", {}),
    "formulation": ("reduced", {}),
    "kinematic": (False, {}),
    "acceleration": ("eliminated", {"formulation": "full"}),
    "impact_law": ("newton", {}),
    "output_step": (0.02, {}),
    "break_times": ((0.015, 0.025), {}),
    "start": ("equilibrium", {}),
    "adjust_joints": (1e-6, {}),
    "projection": ("gopm", {}),
    "projection_tolerance": (1e-10, {}),
    "projection_test": ("paper", {}),
    "every": (2, {}),
    "threshold": (1e-6, {}),
    "project_position": (False, {}),
    "project_velocity": (False, {}),
    "max_iterations": (7, {}),
    "alpha": (1e6, {"projection": "mass-orthogonal"}),
    "gains": ((4.0, 9.0), {"projection": "baumgarte"}),
    "projection_fallback": ("gopm", {}),
    "energy_row": (True, {}),
    "momentum_row": (True, {}),
}


def block_of(values: dict[str, Any]) -> str:
    """The `simulation` block with these settings, as a line of YAML."""
    block: dict[str, Any] = {}
    for name, value in values.items():
        *inside, key = SETTINGS[name].path
        (block.setdefault("projection", {}) if inside else block)[key] = value
    return json.dumps(block)


def values_for(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The settings without and with the other value."""
    value, needed = OTHER[name]
    base = {key: each for key, each in BASE.items() if not (key == "step" and name == "tolerance")}
    return {**base, **needed}, {**base, **needed, name: value}


def as_option(value: Any) -> str:
    if isinstance(value, tuple):
        return ",".join(map(str, value))
    return str(value).lower() if isinstance(value, bool) else str(value)


@pytest.mark.parametrize(
    ("name", "door"),
    [
        pytest.param(name, door, marks=[pytest.mark.full] * (door != "command" and at % 3 != first))
        for at, name in enumerate(SETTINGS)
        for first, door in enumerate(("scene", "python", "command"))
    ],
)
def test_a_setting_is_in_the_file(name, door, tmp_path):
    before, changed = values_for(name)
    wanted, output, path = OTHER[name][0], tmp_path / "results.h5", tmp_path / "scene.yaml"
    path.write_text(SCENE.replace("{BLOCK}", block_of(changed if door == "scene" else BASE)), encoding="utf-8")
    options = (
        {} if door == "scene" else {key: value for key, value in changed.items() if key not in BASE or key == name}
    )
    if door == "python":
        mbproj.run(path, output=output, **options)
    else:
        words = [word for key, value in options.items() for word in (option_name(key), as_option(value))]
        CliRunner().invoke(group, ["run", str(path), "-q", "-o", str(output), *words], catch_exceptions=False)
    with mbproj.open_results(output) as results:
        entry = SETTINGS[name]
        assert entry.of(results.settings) == wanted != entry.usual
        assert results.settings == mbproj.read_scene(path, simulation=options).settings
        if name in ("duration", "step", "output_step", "start"):  # samples and the first pose show that it acted
            times = mbproj.run(SCENE.replace("{BLOCK}", block_of(before))).time
            assert name == "start" or results.time.tolist() != times.tolist()


class Asked(Exception):
    """The store was asked for a study with this key."""


@pytest.mark.parametrize("name", settings_taken("stability"))
def test_a_setting_is_in_the_key_of_a_store(name, monkeypatch):
    def asked(what: Any, *_: object) -> None:
        raise Asked(json.dumps(what))

    monkeypatch.setattr("mbproj.studies.stability.Study", asked)

    before, changed = values_for(name)

    def key(**given: Any) -> str:
        with pytest.raises(Asked) as raised:
            mbproj.stability(SCENE.replace("{BLOCK}", block_of(before)), "length-scale", points=2, **given)
        return str(raised.value)

    assert key() == key() != key(**{name: changed[name]})


def test_every_setting_of_how_is_in_the_names_of_a_studys_runs():
    for name in (name for name, entry in SETTINGS.items() if entry.decides == HOW):
        before, changed = (
            mbproj.read_scene_text(SCENE.replace("{BLOCK}", block_of(each))) for each in values_for(name)
        )
        lines = {mbproj.Setting.of(each.settings).command_line() for each in (before, changed)}
        assert len(lines) == 2, name


TYPES = {"str": "str", "bool": "bool", "int": "int", "float": "Quantity"}


def test_the_typed_lists_are_the_table():
    keywords = {name: f"{TYPES.get(entry.kind, 'Sequence[Quantity]')} | None" for name, entry in SETTINGS.items()}
    assert {name: kind.__forward_arg__ for name, kind in RunSettings.__annotations__.items()} == keywords
    own = {name: (entry.type, entry.usual) for name, entry in SETTINGS.items() if entry.decides == HOW}
    assert {each.name: (each.type, each.default) for each in fields(mbproj.Setting)} == own


@pytest.mark.parametrize("name", ["stability", "threshold", "verify"])
def test_what_a_study_chooses_itself_is_refused(name):
    chosen = [each for each in SETTINGS if each not in settings_taken(name)]
    assert chosen
    for each in chosen:
        with pytest.raises(TypeError, match=rf"{name}\(\) has no argument '{each}'"):
            getattr(mbproj, name)(SCENE, **{"vary": "step"} if name == "stability" else {}, **{each: OTHER[each][0]})
        done = CliRunner().invoke(group, [name, "scene.yaml", option_name(each), as_option(OTHER[each][0])])
        assert (done.exit_code, f"No such option '{option_name(each)}'" in done.output) == (2, True)
