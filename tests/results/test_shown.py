"""What a prompt or a notebook shows of results is short, and the keys that the pages name exist."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj import assemble, compile_system, initial_guess, mobility, read_scene, simulate
from mbproj.results.layout import CONSTANTS
from mbproj.scene.settings import settings_to_run
from tests.support import ROOT

#: The most lines of a value in a notebook.
LINES = 15


@pytest.fixture(scope="module")
def results():
    with mbproj.run(ROOT / "mechanisms" / "planar_four_bar.yaml", duration=0.2, certify=True) as found:
        yield found


def test_values_of_results_are_shown_in_few_lines(results):
    shown = [
        results,
        results.trust,
        results.body(results.names("bodies")[0]),
        results.joint(results.names("joints")[0]),
    ]
    for value in shown:
        lines = repr(value).splitlines()
        assert len(lines) <= LINES and max(map(len, lines)) <= 120, lines
    assert f"violation          array ({len(results.time)},)" in repr(shown[-1])


def test_values_of_a_scene_are_shown_in_few_lines():
    scene = read_scene(ROOT / "mechanisms" / "planar_four_bar.yaml", {}, {"duration": "0.1"})
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    report = simulate(system, state, settings_to_run(scene))
    for value in (scene, system, state, report, mbproj.Mechanism.of(scene), mobility(system, state)):
        assert len(repr(value).splitlines()) <= LINES, type(value)
    assert repr(state).splitlines()[:2] == ["State", "  t                  0.0"]
    assert repr(system).splitlines()[-1].endswith(" more")


def test_what_does_not_change_is_found_by_its_path(results):
    for entry in CONSTANTS:
        assert entry.path in results
        np.testing.assert_array_equal(results[entry.path], results.constant(entry.path))
    with pytest.raises(KeyError, match="did you mean 'joints/reaction_force_unique'"):
        _ = results["joints/reaction_forces_unique"]
    assert "joints/reaction_forces_unique" not in results


def test_mobility_is_that_of_a_state():
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml")
    system = compile_system(scene)
    found = mobility(system, assemble(system, initial_guess(scene, system)))
    assert (found.degrees_of_freedom, found.rank) == (5, 30)
