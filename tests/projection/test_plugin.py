"""A projection method from another package: it closes the joints, runs everywhere, and is an error where it is not."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mbproj
from mbproj.base import plugins
from mbproj.base.registry import PROJECTIONS
from mbproj.guide.pages import pages
from mbproj.motion.projection import Method
from tests.guide.fences import fences
from tests.support import ROOT

FIVE_BAR = str(ROOT / "mechanisms" / "five_bar.yaml")


PENDULUM = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}
forces:
  spring: {type: hardening_spring, points: {ground: [0, 0, 1], rod: [0.5, 0, 0]}, stiffness: 9 N/m, free_length: 1}
  drive: {type: motor, joint: A, stall_torque: 4 N*m, no_load_speed: 9 rad/s, delay: 50 ms}
simulation: {duration: 0.1, step: 0.01, projection: lumped, integrator: three-eighths}
"""
SWEEP = """\
sweep: 1
scene: scene.yaml
vary: {bodies.rod.mass: {linspace: [1 kg, 2 kg, 2]}}
measure: {open: {diagnostic: position_violation, at: maximum}}
"""
#: The modules of the guide's page, in its order, as one package.
MODULES = ("lumped", "integrator", "spring", "motor")


class Nearest(mbproj.Projection):
    """GOPM's formula in other words."""

    def correction(self, M, C_q, violation):
        return -np.linalg.lstsq(C_q, violation, rcond=None)[0]


@pytest.fixture
def nearest(monkeypatch):
    monkeypatch.setattr(PROJECTIONS, "_added", {})
    monkeypatch.setattr(plugins, "_origins", {})
    mbproj.register_projection("nearest", Nearest, summary="the smallest correction")


@pytest.fixture
def environment(tmp_path) -> dict[str, str]:
    """A folder of installed packages with the one of the guide's page in it."""
    site = tmp_path / "site"
    about = site / "mbproj_lumped-1.0.dist-info"
    about.mkdir(parents=True)
    found = [fence.text for fence in fences(pages()["write_a_plugin"]) if fence.language == "python"]
    points = "[mbproj.plugins]\n"
    for module, code in zip(MODULES, found, strict=True):
        assert len([line for line in code.splitlines() if line]) <= 40
        (site / f"{module}.py").write_text(code, encoding="utf-8")
        points += f"{module} = {module}:register\n"
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: mbproj-lumped\nVersion: 1.0\n", encoding="utf-8")
    (about / "entry_points.txt").write_text(points, encoding="utf-8")
    return {"PYTHONPATH": f"{site}:{ROOT}", "MBPROJ_CACHE": str(tmp_path / "cache"), "OPENBLAS_NUM_THREADS": "1"}


def command(folder: Path, environment: dict[str, str], *words: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "mbproj", *words]
    return subprocess.run(line, capture_output=True, text=True, cwd=folder, env=environment, check=False)


def test_a_registered_method_moves_as_the_one_it_equals(nearest):
    settings = {"duration": 0.1, "step": 0.01, "formulation": "full"}
    with (
        mbproj.run(FIVE_BAR, projection="nearest", **settings) as own,
        mbproj.run(FIVE_BAR, projection="gopm", **settings) as gopm,
    ):
        assert own.attributes["position_violation_max"] < 1e-12
        np.testing.assert_allclose(own["bodies/position"], gopm["bodies/position"], atol=1e-11)
        assert own.settings.projection.method == "nearest"
    with mbproj.run(FIVE_BAR, projection="nearest", duration=0.02) as automatic:
        assert automatic.attributes["formulation"] == "full"


def test_a_stabilisation_of_a_plugin_takes_explicit_steps(nearest):
    class Damped(Method):
        stabilises = True

        def stabilised(self, gamma, C, C_dot):
            return gamma - 50.0 * C_dot - 625.0 * C

    mbproj.register_projection("damped", Damped, summary="Baumgarte's with gains of 25 / s")
    settings = {"duration": 0.1, "formulation": "full"}
    with (
        mbproj.run(FIVE_BAR, projection="damped", step=0.01, integrator="rk4", **settings) as own,
        mbproj.run(FIVE_BAR, projection="baumgarte", step=0.01, integrator="rk4", **settings) as same,
    ):
        np.testing.assert_allclose(own["bodies/position"], same["bodies/position"], atol=1e-12)
    for integrator, size in (("esdirk4", {"step": 0.01}), ("auto", {"tolerance": 1e-6})):
        with pytest.raises(mbproj.InputError, match="does not know the stabilisation of the plug-in 'damped'"):
            mbproj.run(FIVE_BAR, projection="damped", integrator=integrator, **size, **settings)


def test_what_cannot_be_registered_is_said(nearest):
    register = mbproj.register_projection
    with pytest.raises(mbproj.InputError, match="mbproj has a projection method 'gopm' itself"):
        register("gopm", Nearest, summary="")
    with pytest.raises(mbproj.InputError, match="'My method' cannot be the name of a projection method"):
        register("My method", Nearest, summary="")
    with pytest.raises(TypeError, match=r"derived from mbproj\.Projection"):
        register("dict", dict, summary="")
    with pytest.raises(TypeError, match="Projection has no method 'correction'"):
        register("empty", mbproj.Projection, summary="")
    with pytest.raises(mbproj.InputError, match="a method has no option 'beta'; options are: alpha, gains"):
        register("other", Nearest, summary="", options=["beta"])


def test_a_method_that_fails_is_said_with_its_name(nearest):
    """So is one whose correction has another shape; that a correction does not exist is a failure of the run."""

    class Broken(Nearest):
        def correction(self, M, C_q, violation):
            return violation[:2]

    class Raising(Nearest):
        def correction(self, M, C_q, violation):
            raise KeyError("weights")

    for name, code in (("broken", Broken), ("raising", Raising)):
        mbproj.register_projection(name, code, summary="")
    message = (
        r"'correction' of projection method 'broken', of a plug-in, has failed: ValueError: Δ has the shape \(2,\)"
    )
    with pytest.raises(mbproj.InputError, match=message):
        mbproj.run(FIVE_BAR, projection="broken", duration=0.02)
    with pytest.raises(mbproj.InputError, match=r"test_plugin.py:\d+: error: 'correction' .* KeyError: 'weights'"):
        mbproj.run(FIVE_BAR, projection="raising", duration=0.02)


#: What a correction may be in place of an array of floats, and the number's type that the message names.
REAL = {
    "list": lambda change: change.tolist(),
    "tuple of numbers of NumPy": tuple,
    "smaller floats": lambda change: change.astype(np.float32).astype(np.longdouble),
}
UNREAL = {
    "complex": lambda change: change * (1.0 + 1e-9j),
    "complex without an imaginary part": lambda change: change.astype(complex),
    "object": lambda change: change.astype(object),
    "<U": lambda change: [str(each) for each in change],
    "inhomogeneous": lambda change: [[0.0], *change[1:]],
    r"shape \(\)": lambda change: None,
}


@pytest.mark.parametrize("kind", REAL)
def test_a_correction_may_be_any_real_numbers(nearest, kind):
    class Other(Nearest):
        def correction(self, M, C_q, violation):
            return REAL[kind](super().correction(M, C_q, violation))

    mbproj.register_projection("other", Other, summary="")
    with mbproj.run(FIVE_BAR, projection="other", duration=0.05) as results:
        assert np.abs(results["joints/violation"]).max() < 1e-6


@pytest.mark.parametrize("kind", UNREAL)
def test_a_correction_that_is_not_real_is_said_with_the_name_of_the_method(nearest, kind):
    class Other(Nearest):
        def correction(self, M, C_q, violation):
            return UNREAL[kind](super().correction(M, C_q, violation))

    mbproj.register_projection("other", Other, summary="")
    said = rf"'correction' of projection method 'other', of a plug-in, has failed: .*{kind.partition(' ')[0]}"
    with pytest.raises(mbproj.InputError, match=said if kind[0] != "s" else f"'other'.*{kind}"):
        mbproj.run(FIVE_BAR, projection="other", duration=0.02)


@pytest.mark.parametrize("wrong", [lambda gamma: gamma + 1e-9j, lambda gamma: gamma[:2], lambda gamma: "γ"])
def test_a_stabilisation_that_is_not_real_is_said(nearest, wrong):
    class Damped(Method):
        stabilises = True

        def stabilised(self, gamma, C, C_dot):
            return wrong(gamma)

    mbproj.register_projection("damped", Damped, summary="")
    with pytest.raises(mbproj.InputError, match="'stabilised' of projection method 'damped', of a plug-in, has failed"):
        mbproj.run(FIVE_BAR, projection="damped", duration=0.02, step=0.01, integrator="rk4", formulation="full")


def test_a_refusal_that_is_no_text_is_said(nearest):
    class Refusing(Nearest):
        def refusal(self, M):
            return np.linalg.det(M) == 0.0

    mbproj.register_projection("refusing", Refusing, summary="")
    with pytest.raises(mbproj.InputError, match=r"'refusal' of projection method 'refusing'.* no text and not None"):
        mbproj.run(FIVE_BAR, projection="refusing", duration=0.02)


@pytest.mark.parametrize("coefficient", [0.5j, np.complex128(0.5 + 1j), "1_0/20", "１/２"])
def test_a_coefficient_of_a_tableau_is_a_real_number(coefficient):
    with pytest.raises(mbproj.InputError, match="which is no number"):
        mbproj.register_integrator("midpoint", order=2, a=[[coefficient]], b=[0, 1], summary="")


def test_another_code_is_another_study(nearest):
    before = plugins.marks()
    mbproj.register_projection("nearest", type("Other", (Nearest,), {"__module__": "elsewhere"}), summary="changed")
    assert plugins.marks() != before


def test_an_installed_method_runs_in_commands_and_workers(tmp_path, environment):
    done = command(tmp_path, environment, "run", FIVE_BAR, "--projection", "lumped", "--duration", "0.05", "--json")
    assert json.loads(done.stdout)["position_violation_max"] < 1e-12, done.stderr
    assert "lumped" in command(tmp_path, environment, "run", "--help").stdout
    built = json.loads(command(tmp_path, environment, "info", "--build", "--json").stdout)
    assert built["plugins"] == {
        "projection method": {"lumped": "lumped"},
        "integrator": {"three-eighths": "integrator"},
        "force type": {"hardening_spring": "spring", "motor": "motor"},
    }
    (tmp_path / "scene.yaml").write_text(PENDULUM, encoding="utf-8")
    schema = command(tmp_path, environment, "schema").stdout
    assert all(f'"{name}"' in schema for name in ("lumped", "three-eighths", "hardening_spring", "motor"))
    (tmp_path / "spec.yaml").write_text(SWEEP, encoding="utf-8")
    swept = command(tmp_path, environment, "sweep", "spec.yaml", "--jobs", "2", "--json")
    assert json.loads(swept.stdout)["computed"] == 2, swept.stderr
    assert json.loads(swept.stdout)["failed"] == 0


def test_a_method_that_is_not_installed_is_an_error(tmp_path, environment):
    alone = environment | {"PYTHONPATH": str(ROOT)}
    done = command(tmp_path, alone, "run", FIVE_BAR, "--projection", "lumped")
    assert (done.returncode, "unknown projection method 'lumped'" in done.stderr) == (2, True)


def test_a_plug_in_that_fails_is_a_note_where_it_is_asked_for(tmp_path, environment):
    (tmp_path / "site" / "lumped.py").write_text("raise ValueError('no')\n", encoding="utf-8")
    note = "note: the plug-in 'lumped' (lumped:register) does not work: ValueError: no"
    asked = command(tmp_path, environment, "run", FIVE_BAR, "--projection", "lumped")
    assert (asked.returncode, note in asked.stderr) == (2, True)
    assert "unknown projection method 'lumped'" in asked.stderr
    other = command(tmp_path, environment, "run", FIVE_BAR, "--duration", "0.02", "--formulation", "full")
    assert (other.returncode, other.stderr) == (0, "")
