"""A tolerance below what round-off leaves is pointed out, and no other."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene
from mbproj.scene.settings import settings_to_run
from mbproj.studies.record import notes_on
from tests.support import ROOT


@pytest.mark.parametrize(("tolerance", "notes"), [(1e-14, 0), (1e-16, 1)])
def test_a_tolerance_below_round_off_is_pointed_out(tolerance, notes):
    """The five-bar's coordinates are up to 1.1 m: 4 ε of that is 1e-15 m. Its error falls no further than 1e-13 m."""
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml")
    system = compile_system(scene)
    settings = replace(
        settings_to_run(scene), duration=0.1, step=None, tolerance=tolerance, integrator="dop853", output_step=0.05
    )
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings)
    found = [
        note for note in notes_on(report) if note.text.startswith("the tolerance of 1e-16 is below what round-off")
    ]
    assert len(found) == notes
    assert report.round_off == pytest.approx(1e-15, rel=0.5)
