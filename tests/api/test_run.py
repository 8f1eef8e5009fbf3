"""`mbproj.run`, `.modes`, `.equilibrium`, `.linearize`: what they give is what the commands give, from any scene."""

from __future__ import annotations

import gc
import inspect

import numpy as np
import pytest

import mbproj
from mbproj.base.settings import SETTINGS
from tests.support import ROOT

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"
PENDULUM = {
    "mbproj": 1,
    "parameters": {"length": 0.5},
    "bodies": {"rod": {"mass": 2, "inertia": [0.1, 0.1, 0.1], "position": ["length", 0, 0]}},
    "joints": {
        "A": {"type": "revolute", "bodies": ["ground", "rod"], "location": [0, 0, 0], "axis": [0, 0, 1]},
    },
    "gravity": [0, -9.81, 0],
    "simulation": {"duration": 0.1, "step": 0.01},
}


def test_run_records_what_the_parts_give():
    scene = mbproj.read_scene(FIVE_BAR, {}, {"duration": 0.05})
    system = mbproj.compile_system(scene)
    start = mbproj.assemble(system, mbproj.initial_guess(scene, system))
    report = mbproj.simulate(system, start, mbproj.settings_to_run(scene))
    with mbproj.run(FIVE_BAR, duration=0.05) as results:
        assert results.time[-1] == pytest.approx(0.05)
        assert results.attributes["position_violation_max"] == report.position_violation.value


@pytest.mark.parametrize("form", ["path", "text", "mapping", "scene"])
def test_every_form_of_a_scene_gives_the_same_motion(form, tmp_path):
    scene = mbproj.read_scene_text(PENDULUM)
    path = tmp_path / "pendulum.yaml"
    path.write_text(scene.text, encoding="utf-8")
    given = {"path": path, "text": scene.text, "mapping": PENDULUM, "scene": scene}[form]
    with mbproj.run(given, step=np.float64(0.005), parameters={"length": np.float64(0.4)}) as results:
        assert results.settings.step == 0.005
        assert results["bodies/position"][0, 0] == pytest.approx([0.4, 0.0, 0.0])
        energy = results["diagnostics/total_energy"]
    assert energy == pytest.approx(energy[0], abs=1e-6)


def test_run_takes_the_words_of_the_command_line():
    assert set(SETTINGS) <= set(inspect.signature(mbproj.run).parameters)


def test_certified_run_says_how_long_it_holds():
    with mbproj.run(PENDULUM, certify=True, limits=[1e-3]) as results:
        assert results.trust.limits == (1e-3,)


def test_problems_name_arguments():
    with pytest.raises(mbproj.InputError, match=r"^step: error: 'step' must be greater than 0, found -1"):
        mbproj.run(PENDULUM, step=-1)
    with pytest.raises(mbproj.InputError, match=r"^parameters\['lenght'\]: error: unknown parameter 'lenght'; did you"):
        mbproj.run(PENDULUM, parameters={"lenght": 1})
    with pytest.raises(mbproj.InputError, match=r"^limits: error: it needs"):
        mbproj.run(PENDULUM, limits=[1e-3])
    with pytest.raises(TypeError, match="found int"):
        mbproj.run(3)


def test_a_temporary_file_goes_with_its_results(tmp_path):
    results = mbproj.run(PENDULUM)
    folder = results.path.parent
    assert folder.exists()
    results.close()
    del results
    gc.collect()
    assert not folder.exists()
    mbproj.run(PENDULUM, output=tmp_path / "kept.h5").close()
    assert mbproj.open_results(tmp_path / "kept.h5").status == "complete"


def test_results_say_what_they_are(tmp_path):
    scene = mbproj.read_scene_text({**PENDULUM, "title": "<b>bob</b>"})
    results = mbproj.run(scene)
    assert repr(results).splitlines()[0] == "Results: <b>bob</b>"
    assert "11 from 0 to 0.1 s" in repr(results)
    assert "&lt;b&gt;bob" in results._repr_html_()
    assert "<b>" not in results._repr_html_()
    results.close()
    assert repr(results).endswith("closed")


def test_linear_functions_know_the_pendulum():
    """About its lowest point: ω² = m g l / (J + m l²)."""
    scene = mbproj.read_scene_text(PENDULUM)
    rest = mbproj.equilibrium(scene)
    assert rest.stable
    found = mbproj.modes(scene, at="equilibrium")
    expected = np.sqrt(2 * 9.81 * 0.5 / (0.1 + 2 * 0.5**2)) / (2 * np.pi)
    assert found.frequencies[0] == pytest.approx(expected, rel=1e-9)
    model = mbproj.linearize(scene, ["A.angle"], "A.angle", at="equilibrium")
    A, _, _, _ = model.matrices
    assert np.abs(np.linalg.eigvals(A).imag).max() == pytest.approx(2 * np.pi * expected, rel=1e-9)
    with pytest.raises(mbproj.InputError, match="at: error: unknown place 'top'"):
        mbproj.modes(scene, at="top")
