"""Forces and torques of given components are recorded: their values, their power, their work."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.results.analysis.loads import loads_of
from mbproj.results.analysis.tables import tables
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter

SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1 s, tolerance: 1e-10, integrator: dop853, output_step: 5 ms, formulation: FORMULATION}
bodies:
  rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  push: {type: force, body: rod, location: [1, 0, 0], force: [0, 0, "5*sin(3*t)"]}
  follow: {type: force, body: rod, location: [1, 0, 0], axes: body, force: [0, 0, 2]}
  twist: {type: torque, body: rod, axes: body, torque: [0, "2*t", 0]}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["full", "reduced", "planar"])
def test_given_forces_are_recorded_with_their_power_and_their_work(tmp_path, formulation):
    scene = read_scene_text(SCENE.replace("FORMULATION", formulation))
    system = compile_system(scene)
    with ResultsWriter(tmp_path / "out.h5", scene, system.names.as_mapping()) as recorder:
        simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    with open_results(tmp_path / "out.h5") as results:
        assert results.names("applied") == ("push", "follow", "twist")
        time, angle, speed = results.time, *results["joints/coordinate"].T, *results["joints/speed"].T
        push, follow, twist = np.swapaxes(results["forces/applied"], 0, 1)
        np.testing.assert_allclose(push[:, 2], 5.0 * np.sin(3.0 * time), atol=1e-14)
        np.testing.assert_allclose(twist, np.outer(2.0 * time, [0.0, 1.0, 0.0]), atol=1e-14)
        along = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)  # body z, turned about y
        np.testing.assert_allclose(follow, 2.0 * along, atol=1e-12)
        power = np.stack([-push[:, 2] * np.cos(angle) * speed, -2.0 * speed, 2.0 * time * speed], axis=1)
        np.testing.assert_allclose(results["forces/applied_power"], power, atol=1e-11)
        works = [load.put_in - load.taken_out for load in loads_of(results) if load.quantity == "power"]
        assert sum(works) == pytest.approx(results["diagnostics/work"][-1], abs=1e-6)
        pushed = next(table for table in tables(results) if table.name == "force-push")
    assert pushed.headings[3:] == ("applied_z (N)", "applied_power (W)")
