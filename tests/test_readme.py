"""What the README says: its tables are the registries', its mechanism and its Python example run as written."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from xml.etree import ElementTree

import pytest
import yaml

from mbproj.joints import JOINTS
from mbproj.registry import PROJECTIONS, integrators
from mbproj.scene import read_scene_text
from mbproj.scene.forces import FORCE_RECORDS
from mbproj.scene.motions import KINDS
from mbproj.scene.observables import MOMENTS, OBSERVABLES
from mbproj.scene.unit_text import COMPOUNDS
from mbproj.scene.units import SYMBOLS
from mbproj.studies.stability.quantities import QUANTITIES
from mbproj.studies.verify.checks import CHECKS
from tests.cli.commands import mbproj
from tests.studies.scenes import PENDULUM
from tests.support import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize("name", list(PROJECTIONS))
def test_methods_table(name):
    entry = PROJECTIONS[name]
    options = ", ".join(f"`{option}`" for option in entry.options)
    assert f"| `{name}` | {entry.equations} | {entry.summary} | {options}{' ' if options else ''}|\n" in README


@pytest.mark.parametrize("name", list(integrators()))
def test_integrators_table(name):
    entry = integrators()[name]
    assert f"| `{name}` | {entry.order} | {entry.summary} | {'yes ' if entry.embedded else ''}|\n" in README


@pytest.mark.parametrize("name", list(JOINTS))
def test_joints_table(name):
    row = next(line for line in README.splitlines() if line.startswith(f"| `{name}` | "))
    for coordinate in JOINTS[name].coordinates:
        assert f"`{coordinate}`" in row


@pytest.mark.parametrize("name", list(FORCE_RECORDS))
def test_forces_table(name):
    row = next(line for line in README.splitlines() if line.startswith(f"| `{name}` | "))
    for key in FORCE_RECORDS[name].keys.keys() - {"type"}:
        assert f"`{key}" in row, key


@pytest.mark.parametrize("name", list(QUANTITIES))
def test_quantities_table(name):
    assert f"| `{name}` | {QUANTITIES[name].unit} | {QUANTITIES[name].summary} |\n" in README


@pytest.mark.parametrize("name", list(CHECKS))
def test_the_checks_of_a_verification_are_shown(name):
    assert re.search(rf"^  {name} +{re.escape(CHECKS[name].claim)} ", README, re.MULTILINE)


def test_every_unit_is_named():
    numbers = " ".join(README.partition("- *Numbers*")[2].partition("- *Errors*")[0].split())
    assert f"Units are `{' '.join(SYMBOLS)}` and" in numbers
    assert f"`{' '.join(COMPOUNDS)}` without spaces" in numbers


def test_motions_table():
    table = [line.split("`")[1] for line in README.partition("## Motions")[2].splitlines() if line.startswith("| `")]
    assert tuple(table[: len(KINDS)]) == KINDS


def test_the_examples_of_forces_and_motions_are_read():
    fragments = [text for text in blocks("yaml") if text.startswith(("forces:", "motions:"))]
    assert len(fragments) == 2
    body = "{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}"
    scene = read_scene_text(
        f"mbproj: 1\ngravity: [0, 0, 0]\nbodies:\n  frame: {body}\n  wheel: {body}\njoints:\n"
        "  A: {type: revolute, bodies: [ground, frame], location: [0, 0, 0], axis: [0, 0, 1]}\n"
        "  D: {type: prismatic, bodies: [frame, wheel], location: [0, 0, 0], axis: [0, 0, 1]}\n" + "".join(fragments)
    )
    assert [force.name for force in scene.forces] == ["suspension", "bumper", "wind"]
    assert [(motion.joint, motion.coordinate) for motion in scene.motions] == [("A", "angle"), ("D", "displacement")]


def test_the_first_mechanism_runs_as_written(tmp_path):
    (tmp_path / "swing.yaml").write_text(blocks("yaml")[0])
    checked = mbproj("check", "swing.yaml", folder=tmp_path)
    assert checked.returncode == 0, checked.stderr
    run = mbproj("run", "swing.yaml", "--duration", "0.2", "-o", "swing.h5", folder=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.splitlines()[:3] == [
        line for line in README.splitlines() if line in run.stdout.splitlines()[:3] and line
    ]
    plots = mbproj("plot", "swing.h5", folder=tmp_path)
    assert plots.returncode == 0, plots.stderr
    assert (tmp_path / "swing-markers.png").exists()
    assert (tmp_path / "swing-violation.png").exists()


def test_the_python_example_runs_as_written(tmp_path):
    code = blocks("python")[0].replace("mechanisms/", f"{ROOT}/mechanisms/").replace('"duration": 2', '"duration": 0.1')
    program, environment = [sys.executable, "-c", code], {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(program, capture_output=True, text=True, cwd=tmp_path, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    assert "Worst(value=" in done.stdout


def test_the_example_of_expectations_is_read_and_its_table_names_every_quantity():
    (fragment,) = (text for text in blocks("yaml") if text.startswith("expect:"))
    text = PENDULUM.replace("gravity", "parameters: {length: 1 m}\ngravity").replace("0.2", "2")
    scene = read_scene_text(text + fragment)
    assert [each.name for each in scene.expectations] == ["end", "fastest", "load", "closed", "energy"]
    section = README.partition("## Expectations")[2].partition("## In a pipeline")[0]
    for of in ("marker", "body", "joint", "force", "motion"):
        for quantity in OBSERVABLES[of]:
            coordinate = quantity.removesuffix("_speed").startswith(("angle", "displacement"))
            assert f"`{quantity}`" in section or (of == "joint" and coordinate), quantity
    assert all(f"`{word}`" in section or f"`at: {word}`" in section for word in MOMENTS)


def test_the_pipeline_runs_as_written(tmp_path):
    """The script of the GitLab job, but for its installation; and the commands below it."""
    (job,) = (yaml.safe_load(text) for text in blocks("yaml") if text.startswith("mechanisms:"))
    install, batch = job["mechanisms"]["script"]
    assert install == "pip install ."
    assert job["mechanisms"]["artifacts"] == {
        "when": "always", "paths": ["results"], "reports": {"junit": "mechanisms.xml"},
    }  # fmt: skip
    (tmp_path / "mechanisms").symlink_to(ROOT / "mechanisms")
    done = mbproj(*shlex.split(batch)[1:], folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    root = ElementTree.parse(tmp_path / "mechanisms.xml").getroot()
    assert (root.get("failures"), root.get("errors")) == ("0", "0")
    assert (tmp_path / "results" / "five_bar.h5").exists()
    assert (tmp_path / "results" / "validation" / "dymola_rssp.h5").exists()
    shown = README.partition("$ mbproj batch mechanisms\n")[2].partition("```")[0].splitlines()
    assert done.stdout.splitlines()[0].split() == shown[0].split()
    (commands,) = (text for text in blocks("sh") if text.startswith("mbproj new"))
    for command in commands.splitlines():
        done = mbproj(*shlex.split(command)[1:], folder=tmp_path)
        assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "the same motion"


def test_the_example_of_a_study_runs_as_written(tmp_path):
    code = blocks("python")[-1].replace("mechanisms/", f"{ROOT}/mechanisms/")
    code = code.replace("until=1.0, longest=0.05", "until=0.2, longest=0.005, repetitions=1")
    program, environment = [sys.executable, "-c", code], {"PYTHONPATH": str(ROOT), "MBPROJ_CACHE": str(tmp_path)}
    done = subprocess.run(program, capture_output=True, text=True, cwd=tmp_path, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("--integrator ")
    assert float(done.stdout.splitlines()[1].split()[0]) < 1e-6
    assert done.stdout.splitlines()[1].endswith(" None")


def test_the_set_up_commands_are_what_ci_runs():
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for command in blocks("sh")[:2]:
        assert command in ci
