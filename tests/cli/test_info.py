"""`mbproj info`: the account of the energy, what limits the steps, and how the kernel was compiled."""

from __future__ import annotations

import json
import platform

import h5py
import numpy as np
import pytest

from mbproj import __version__, kernel, open_results
from mbproj.base.registry import FORMULATIONS
from tests.cli.commands import SLIDER_CRANK, mbproj, succeeds
from tests.crossed import full
from tests.integrate.stiff_scenes import CREEP

# info --energy: what forces put in, and what dampers, the integrator and the projection took.


def parts_of(folder, scene, *options):
    done = succeeds("run", scene, *options, "-o", "r.h5", folder=folder)
    done = succeeds("info", "r.h5", "--energy", "--json", folder=folder)
    return json.loads(done.stdout)


@pytest.mark.parametrize("integrator", ["rk4", full("esdirk4"), full("radau5")])
def test_the_parts_lead_from_the_start_to_the_end(tmp_path, integrator):
    found = parts_of(tmp_path, SLIDER_CRANK, "--integrator", integrator, "--step", "0.02", "--duration", "1")
    changes = found["put_in"] - found["dissipated"] + found["integrator"] + found["projection"]
    assert found["end"] - found["start"] == pytest.approx(changes, abs=1e-13)
    assert min(abs(found["integrator"]), abs(found["projection"])) > 1e-7
    with open_results(tmp_path / "r.h5") as results:
        assert found["end"] == results["diagnostics/total_energy"][-1]
    shown = mbproj("info", "r.h5", "--energy", folder=tmp_path).stdout
    assert (
        f"  the projection  {'took' if found['projection'] < 0.0 else 'added'} {abs(found['projection']):.2e} J"
        in shown
    )


def test_what_cannot_be_divided_is_said(tmp_path):
    (tmp_path / "creep.yaml").write_text(CREEP)
    assert mbproj("run", "creep.yaml", folder=tmp_path).returncode == 0
    done = mbproj("info", "results.h5", "--energy", folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "results.h5: its energy cannot be divided: steps of 'auto' are not all of one method" in done.stderr
    assert "give --steps or --energy, not both" in mbproj("info", "r", "--steps", "--energy", folder=tmp_path).stderr


# info --steps: which bodies make the error of the smaller steps, and which force holds them.

#: Two masses on springs: one swings with 20 rad/s, one with 1 rad/s.
TWO = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 2 s, tolerance: 1.0e-8, integrator: dop853, output_step: 0.05}
bodies:
  slow: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  fast: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, slow], location: [0, 0, 0], axis: [1, 0, 0]}
  wire: {type: prismatic, bodies: [ground, fast], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  soft: {type: linear_spring_damper, joint: rail, force: "-(displacement + 0.1)"}
  hard: {type: linear_spring_damper, joint: wire, force: "-400*(displacement + 0.1)"}
"""


def steps_of(folder, text, *options):
    (folder / "scene.yaml").write_text(text)
    done = succeeds("run", "scene.yaml", *options, folder=folder)
    done = succeeds("info", "results.h5", "--steps", "--json", folder=folder)
    return json.loads(done.stdout)["steps"]


def test_the_faster_mass_makes_the_error(tmp_path):
    """Its error is 20⁸ times the other's."""
    found = steps_of(tmp_path, TWO)
    for each in found:
        assert each["shares"]["fast"] > 0.999
        assert each["reason"] == ""
    assert 0.01 < max(each["error"] for each in found) <= 1.01
    shown = mbproj("info", "results.h5", "--steps", folder=tmp_path).stdout
    assert "fast 100 %" in shown
    assert "accuracy" in shown


@pytest.mark.full
def test_the_picture_of_the_steps_says_it_too(tmp_path):
    steps_of(tmp_path, TWO)
    done = mbproj("plot", "results.h5", "--kind", "steps", "--format", "svg", folder=tmp_path)
    assert (done.returncode, done.stdout.split()) == (0, ["results-steps.svg"])
    shown = mbproj("info", "results.h5", "--steps", folder=tmp_path).stdout
    assert done.stderr == shown
    assert "steps limited by body 'fast' at " in (tmp_path / "results-steps.svg").read_text(encoding="utf-8")


def test_a_stiff_force_holds_them(tmp_path):
    found = steps_of(tmp_path, CREEP, "--integrator", "dop853", "--duration", "0.3", "--output-step", "0.01")
    held = [each for each in found if each["reason"].startswith("force 'bush': c h / m = ")]
    assert len(held) >= len(found) / 2


def test_fixed_steps_have_no_limit(tmp_path):
    (tmp_path / "scene.yaml").write_text(TWO)
    assert mbproj("run", "scene.yaml", "--step", "0.05", "--duration", "0.5", folder=tmp_path).returncode == 0
    done = mbproj("info", "results.h5", "--steps", folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "its steps are fixed, and nothing limits them; run it with a --tolerance" in done.stderr
    assert mbproj("info", "--steps", folder=tmp_path).returncode == 2


# info --build: what runs, and how the kernel was compiled.


def facts(folder):
    done = mbproj("info", "--build", "--json", folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


def test_versions_and_formulations(tmp_path):
    has = facts(tmp_path)
    versions = {"mbproj": __version__, "python": platform.python_version()}
    assert has.items() >= {**versions, "numpy": np.__version__, "h5py": h5py.__version__}.items()
    assert {"auto", *has["formulations"]} == set(FORMULATIONS)


def test_the_kernel_is_the_one_in_use(tmp_path):
    has, build = facts(tmp_path)["kernel"], kernel.build_info()
    if isinstance(build, str):
        assert (has["built"], has["reason"]) == (False, build)
    else:
        assert has == {"built": True, **build}
        assert {"compiler", "flags", "build_type", "eigen", "instruction_set"} <= set(build)
        assert "-ffast-math" not in build["flags"]


def test_text_says_the_same(tmp_path):
    done = mbproj("info", "--build", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    build = kernel.build_info()
    assert f"mbproj        {__version__}\n" in done.stdout
    if isinstance(build, str):
        assert f"kernel        none: {build}\n" in done.stdout
    else:
        assert f"kernel        {build['instruction_set']}\n  compiler    {build['compiler']}\n" in done.stdout


@pytest.mark.parametrize("arguments", [[], ["--json"], ["--build", "a.h5"]])
def test_either_a_file_or_the_build(tmp_path, arguments):
    done = mbproj("info", *arguments, folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "give RESULTS, a results file, or --build, for how mbproj itself was built" in done.stderr
