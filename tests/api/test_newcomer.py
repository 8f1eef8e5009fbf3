"""What somebody types who has not read the guide: each line runs as guessed, and shows what it is."""

from __future__ import annotations

import shutil
import subprocess
import sys

import numpy as np
import pytest

import mbproj
from mbproj.commands.main import COMMANDS
from mbproj.commands.main import mbproj as group
from tests.support import ROOT

#: A line, and what stands in what it shows.
GUESSED = [
    ("mbproj.read_scene('five_bar.yaml')", "A revolute, B revolute"),
    ("[body.name for body in scene.bodies]", "['bar1', 'bar2', 'bar3', 'bar4', 'bar5']"),
    ("scene.with_(length=1.2)", "length = 1.2"),
    ("scene.to_yaml()", "mbproj: 1"),
    ("mbproj.check('five_bar.yaml')", "5 degrees of freedom, can run"),
    ("mbproj.run('five_bar.yaml', duration='20 ms', step=0.005)", "5 from 0 to 0.02 s"),
    ("mbproj.run(scene, parameters={'length': np.float64(1.2)}, duration=0.02)", "complete"),
    ("mbproj.run(scene, projection='gopm', integrator='dop853', tolerance=1e-9, duration=0.02)", "complete"),
    ("mbproj.run({'mbproj': 1, 'gravity': [0, 0, -9.81], 'bodies': {'b': BALL}}, duration=0.1, step=0.1)", "complete"),
    ("results", "tip"),
    ("results.status", "complete"),
    ("results.time[-1]", "0.05"),
    ("results['markers/position'].shape", "(6, 1, 3)"),
    ("results.marker('tip').position[0]", "5."),
    ("results.body('bar1').velocity.shape", "(6, 3)"),
    ("results.joint('A').reaction_force.shape", "(6, 3)"),
    ("results.names('joints')", "('A', 'B', 'C', 'D', 'E')"),
    ("results.attributes['energy_drift'] < 1e-6", "True"),
    ("results.scene.title", "Five-bar pendulum"),
    ("results.settings.integrator", "rk4"),
    ("results.plot.energy()", "Picture: energy (J); energy balance (J)"),
    ("results.plot('reactions', 'A').save('A.png')", "A.png"),
    ("results.animate().save('five_bar.html')", "five_bar.html"),
    ("results.to_pandas()['markers']['tip'].shape", "(6, 9)"),
    ("sorted(results.to_xarray().sizes)", "'marker'"),
    ("mbproj.equilibrium(scene).stable", "True"),
    ("mbproj.modes(scene, at='equilibrium').frequencies[0]", "0.268"),
    ("mbproj.compare(scene, projections=['gopm', 'gpopm'], until=0.02).to_pandas().shape[0]", "2"),
]
WRONG = [
    ("results.plot()", "which picture? plot.energy() is one; choose from: markers, paths"),
    ("results.plot('enrgy')", "there is no picture 'enrgy', plot.energy() is one; did you mean 'energy'?"),
    ("results.marker('tp')", "did you mean 'tip'?"),
    ("mbproj.run('fivebar.yaml')", "there is no such file; did you mean 'five_bar.yaml'?"),
    ("mbproj.run(scene, integrator='rk45')", "unknown integrator 'rk45'"),
]


@pytest.fixture(scope="module")
def names(tmp_path_factory):
    folder = tmp_path_factory.mktemp("newcomer")
    shutil.copy(ROOT / "mechanisms" / "five_bar.yaml", folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        ball = {"mass": 1, "inertia": [1, 1, 1], "position": [0, 0, 0]}
        with mbproj.run("five_bar.yaml", duration=0.05) as results:
            scene = mbproj.read_scene("five_bar.yaml")
            yield {"mbproj": mbproj, "np": np, "scene": scene, "results": results, "BALL": ball}


@pytest.mark.parametrize(("line", "shown"), GUESSED, ids=[line for line, _ in GUESSED])
def test_a_line_runs_as_guessed(line, shown, names):
    found = repr(eval(line, names))
    assert shown in found
    assert " object at 0x" not in found


@pytest.mark.parametrize(("line", "said"), WRONG, ids=[line for line, _ in WRONG])
def test_a_wrong_guess_says_what_was_meant(line, said, names):
    with pytest.raises((mbproj.InputError, KeyError)) as raised:
        eval(line, names)
    assert said in str(raised.value)


def test_a_scene_is_a_table_in_a_notebook(names):
    """Names from a file are no markup."""
    shown = names["scene"]._repr_html_()
    assert shown.startswith("<table><caption>Five-bar pendulum (Zhang, Liu &amp; Liu 2015")
    assert "<th>joints</th><td>A revolute" in shown
    titled = names["scene"].with_({"title": "<script>"})
    assert "<script>" not in titled._repr_html_()


def test_until_and_duration_are_one_word():
    """Each command that has one of them has both, for the same parameter."""
    having = 0
    for name in COMMANDS:
        command = group.get_command(None, name)
        assert command is not None
        options = [set(each.opts) for each in command.params]
        words = [each & {"--until", "--duration"} for each in options if each & {"--until", "--duration"}]
        assert words in ([], [{"--until", "--duration"}]), name
        having += len(words)
    assert having >= 10


@pytest.mark.parametrize(
    ("word", "shown"),
    [
        ("joints/reference", "A joint connects two bodies"),
        ("notebook", "mbproj examples --notebooks"),
        ("cam", "A cam with its follower"),
        ("pulley", "tackles"),
        ("optimise", "Usage: mbproj optimise"),
        ("plugin", "write_a_plugin"),
        ("watch", "Usage: mbproj watch"),
    ],
)
def test_help_finds_the_page(word, shown):
    from click.testing import CliRunner

    done = CliRunner().invoke(group, ["help", word], catch_exceptions=False)
    assert (done.exit_code, shown in done.stdout) == (0, True)


def test_an_import_leaves_the_search_for_garbage_as_it_was():
    code = "import gc, mbproj; mbproj.run; on = gc.isenabled(); gc.disable(); mbproj.modes; print(on, gc.isenabled())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "False"]


def test_python_runs_the_command_line():
    done = subprocess.run([sys.executable, "-m", "mbproj", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"mbproj, version {mbproj.__version__}\n"


def test_an_axis_is_a_letter_and_a_tolerance_alone_has_an_integrator():
    text = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {rod: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: y}}
simulation: {duration: 0.1, tolerance: 1e-6}
"""
    with mbproj.run(text) as results:
        assert results.settings.integrator == "dopri5"
    given = mbproj.read_scene_text(text).joints[0].axes.first
    assert given == (0.0, 1.0, 0.0)
