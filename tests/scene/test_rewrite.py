"""Settings changed in the text of a scene: every other character stays."""

from __future__ import annotations

import pytest

from mbproj.scene.changes import with_simulation

BLOCK = """\
mbproj: 1            # format
simulation:          # how
  duration: 10 s     # long
  step: 0.01 s       # the paper's

  # a remark
  projection:
    method: none     # drifts
    every: 4
bodies: {}
"""
CHOSEN = {"step": None, "tolerance": "1e-8", "integrator": "dop853"}


def test_a_block_keeps_its_comments_and_its_order():
    changes = {**CHOSEN, "projection": {"method": "gpopm", "every": None, "alpha": None}}
    assert with_simulation(BLOCK, changes) == (
        BLOCK.replace("step: 0.01 s ", "tolerance: 1e-8 ")
        .replace("method: none ", "method: gpopm ")
        .replace("    every: 4\n", "  integrator: dop853\n")
    )


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("{duration: 1, step: 0.1}", "{duration: 1, tolerance: 1e-8, integrator: dop853}"),
        ("{duration: 1,  # a\n  step: 0.1}", "{duration: 1,  # a\n  tolerance: 1e-8, integrator: dop853}"),
        ("{step: 0.1, duration: 1, integrator: rk4}", "{tolerance: 1e-8, duration: 1, integrator: dop853}"),
        ("{tolerance: 1e-3}", "{tolerance: 1e-8, integrator: dop853}"),
        ("{}", "{tolerance: 1e-8, integrator: dop853}"),
        ("", "{tolerance: 1e-8, integrator: dop853}"),
    ],
)
def test_a_block_in_braces(before, after):
    text = "mbproj: 1\nsimulation: {}\nbodies: 1\n"
    found = with_simulation(text.replace("simulation: {}", f"simulation: {before}".rstrip()), CHOSEN)
    assert found == text.replace("simulation: {}", f"simulation: {after}")


def test_a_scene_without_the_block_gets_one():
    assert with_simulation("mbproj: 1", {"tolerance": "1e-8"}) == "mbproj: 1\nsimulation: {tolerance: 1e-8}\n"


def test_several_keys_are_removed_from_braces():
    text = "simulation: {step: 0.1, projection: {method: none, every: 4, threshold: 1e-3}}\n"
    changes = {"projection": {"method": "gpopm", "every": None, "threshold": None}}
    assert with_simulation(text, changes) == "simulation: {step: 0.1, projection: {method: gpopm}}\n"


def test_line_ends_stay_those_of_the_file():
    text = BLOCK.replace("\n", "\r\n")
    assert "\n" not in with_simulation(text, CHOSEN).replace("\r\n", "")
