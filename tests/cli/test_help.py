"""Help, examples, the paper, and what shells offer to complete."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from mbproj.base.mechanisms_folder import mechanism, mechanisms, validation_scenes
from mbproj.base.registry import PROJECTIONS
from mbproj.commands.main import COMMANDS, GROUPS
from mbproj.commands.main import mbproj as group
from mbproj.commands.options import GroupedOption, Part
from mbproj.commands.plot import OF_DESIGNS
from mbproj.guide.pages import pages
from mbproj.show.figures.kinds import KINDS, SWEEP_PICTURES
from mbproj.studies.stability import QUANTITIES
from tests.cli.commands import FIVE_BAR, SLIDER_CRANK, mbproj, succeeds
from tests.cli.examples import examples, fill, named
from tests.support import ROOT

# The help of every command: its options by what they decide, and examples that work.

every_command = pytest.mark.parametrize("name", COMMANDS)
TERMINAL = 80


def help_of(name: str) -> str:
    done = CliRunner().invoke(group, [name, "--help"], terminal_width=TERMINAL, prog_name="mbproj")
    assert done.exit_code == 0
    return done.output


def first_shown(option: click.Option) -> str:
    """The name that the help shows first of those that are no single letter."""
    return next(name for name in option.opts if name.startswith("--")).removeprefix("--")


@every_command
def test_each_option_is_in_exactly_one_part_and_is_shown_there(name):
    command, context = named(name)
    options = [each for each in command.get_params(context) if isinstance(each, click.Option)]
    in_parts = [each for part in command.options_by_part(context).values() for each in part]
    assert sorted(map(id, in_parts)) == sorted(map(id, options))
    shown, heading = {}, ""
    for line in help_of(name).splitlines():
        if line.endswith(":") and not line.startswith(" "):
            heading = line.removesuffix(":")
        elif line.startswith("  -"):
            shown.setdefault(line.split("--")[1].split()[0].rstrip(","), []).append(heading)
    for part, each in command.options_by_part(context).items():
        for option in each:
            if not option.hidden:
                assert shown.pop(first_shown(option)) == [part.value]
    assert not shown


@every_command
def test_the_help_option_alone_is_not_of_ours(name):
    command, _ = named(name)
    for each in command.params:
        assert isinstance(each, (GroupedOption, click.Argument)), each.name
        assert getattr(each, "part", None) is not Part.HELP


def test_an_option_needs_a_part():
    with pytest.raises(TypeError, match="part"):
        click.option("--size", cls=GroupedOption)(lambda size: None)


@every_command
def test_every_option_says_what_it_does(name):
    command, context = named(name)
    for part in command.options_by_part(context).values():
        for each in part:
            assert isinstance(each, click.Option)
            assert each.help, each.name


@every_command
def test_the_first_line_is_a_whole_sentence_that_fits(name):
    summary = {name: said for names in GROUPS.values() for name, said in names.items()}[name]
    _, _, first, _, *_ = help_of(name).splitlines()
    for sentence in (summary, first.strip()):
        assert sentence[0].isupper()
        assert sentence.split()[0].endswith("s"), "a verb: what the command does"
        assert sentence.endswith(".")
        assert sentence.count(". ") == 0
    assert first.startswith("  ")


def test_the_list_of_commands_has_a_line_for_each():
    done = CliRunner().invoke(group, ["--help"], terminal_width=TERMINAL)
    for names in GROUPS.values():
        for name, summary in names.items():
            assert f"\n  {name:15}  {summary}\n" in done.output


@every_command
def test_examples_are_the_end_of_the_help_and_fit(name):
    command, _ = named(name)
    assert 1 <= len(command.examples) <= 3
    shown = help_of(name).partition("\nExamples:\n")[2].splitlines()
    assert shown == [f"  {line}" for said, example in command.examples for line in (f"# {said}", example)]
    assert max(map(len, shown)) <= TERMINAL
    for said, example in command.examples:
        assert said.endswith((".", ". "))
        assert example.startswith(f"mbproj {name}")


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    path = tmp_path_factory.mktemp("examples")
    fill(path)
    return path


def short_examples():
    """The default run has the first of each command."""
    begun = set()
    for name, arguments in examples(long=False):
        needs_docs = pytest.mark.skipif(find_spec("furo") is None, reason="the extra `docs` is not installed")
        needs_mujoco = pytest.mark.skipif(find_spec("mujoco") is None, reason="the extra `import` is not installed")
        marks = [needs_docs] if "--html" in arguments else [needs_mujoco] if "robot.xml" in arguments else []
        marks += [pytest.mark.full] if name in begun else []
        begun.add(name)
        yield pytest.param(name, arguments, id=" ".join(arguments), marks=marks)


@pytest.mark.parametrize(("name", "arguments"), list(short_examples()))
def test_an_example_does_what_it_says(name, arguments, filled, tmp_path, undrawn):
    shutil.copytree(filled, tmp_path, dirs_exist_ok=True)
    succeeds(*arguments, folder=tmp_path)


@pytest.mark.parametrize(("name", "arguments"), list(examples(long=True)), ids=str)
def test_a_long_example_is_read_without_complaint(name, arguments, filled, monkeypatch):
    monkeypatch.chdir(filled)
    command, context = named(name)
    own = command.make_context(name, arguments[1:], parent=context.parent)
    for path in (own.params.get("scene"), *own.params.get("paths", ())):
        assert path is None or any(filled.glob(str(path)))


# check, examples, paper, help: what they print and how they exit.

FOUR_BAR = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  left: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.5]}
  top: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 1]}
  right: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0.5]}
joints:
  A: {type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [left, top], location: [0, 0, 1], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [top, right], location: [1, 0, 1], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [right, ground], location: [1, 0, 0], axis: [0, 1, 0]}
"""

STRETCHED = FOUR_BAR
for bar, before, after in (
    ("left", "[0, 0, 0.5]", "[0.5, 0, 0]"),
    ("top", "[0.5, 0, 1]", "[1.5, 0, 0]"),
    ("right", "[1, 0, 0.5]", "[2.5, 0, 0]"),
    ("B", "[0, 0, 1]", "[1, 0, 0]"),
    ("C", "[1, 0, 1]", "[2, 0, 0]"),
    ("D", "location: [1, 0, 0]", "location: [3, 0, 0]"),
):
    STRETCHED = "\n".join(
        line.replace(before, after) if line.startswith(f"  {bar}:") else line for line in STRETCHED.split("\n")
    )


def test_check_says_what_a_scene_is(tmp_path):
    done = mbproj("check", SLIDER_CRANK, folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "    C  universal of rod and slider, free: angle_1, angle_2\n" in done.stdout
    assert "21 coordinates, 20 constraints of rank 20: 1 degrees of freedom\n" in done.stdout
    assert "bodies moved from their guess by up to " in done.stdout
    assert "    A.angle         0 rad, 6 rad/s\n" in done.stdout
    assert "    D.displacement  0 m, 0.24 m/s\n" in done.stdout
    assert done.stdout.endswith("  can run\n")


def test_check_counts_redundant_rows(tmp_path):
    (tmp_path / "four_bar.yaml").write_text(FOUR_BAR)
    done = succeeds("check", "four_bar.yaml", "--json", "--formulation", "reduced", folder=tmp_path)
    facts = json.loads(done.stdout)
    assert (facts["can_run"], facts["rank"], facts["degrees_of_freedom"]) == (True, 20, 1)
    assert len(facts["redundancy"]["sets"]) == 3


def test_run_refuses_what_check_refuses(tmp_path):
    """The four bars in one line, as long together as the ground is."""
    (tmp_path / "four_bar.yaml").write_text(STRETCHED)
    checked = mbproj("check", "four_bar.yaml", folder=tmp_path)
    assert checked.returncode == 4
    assert "four_bar.yaml:11:3: error: the pose is singular: at it rows of joints depend on" in checked.stderr
    for formulation in ("auto", "planar", "reduced", "full"):
        arguments = ["--duration", "1", "--step", "0.01", "--formulation", formulation]
        done = mbproj("run", "four_bar.yaml", *arguments, folder=tmp_path)
        assert (done.returncode, "stretched or folded" in done.stderr) == (2, True)
        assert not (tmp_path / "results.h5").exists()


def test_check_of_a_method_that_cannot_work(tmp_path):
    done = mbproj("check", FIVE_BAR, "--projection", "popm", "--formulation", "full", folder=tmp_path)
    assert done.returncode == 4
    assert "'popm' needs a positive definite mass matrix" in done.stderr


def test_examples_are_listed_and_copied_but_never_over_others(tmp_path):
    listed = succeeds("examples", folder=tmp_path)
    assert [line.split()[0] for line in listed.stdout.splitlines()] == [path.name for path in mechanisms()]
    succeeds("examples", "--copy", "here", folder=tmp_path)
    assert (tmp_path / "here" / "five_bar.yaml").read_bytes() == mechanism("five_bar").read_bytes()
    validation = tmp_path / "here" / "validation"
    assert {path.name for path in validation.glob("*")} == {path.name for path in validation_scenes()}
    again = mbproj("examples", "--copy", "here", folder=tmp_path)
    assert again.returncode == 2
    assert "here has already bennett.yaml, bicycle.yaml, bouncing_ball.yaml" in again.stderr


@pytest.mark.parametrize("drawn", [False, pytest.param(True, marks=pytest.mark.full)])
def test_paper_draws_its_eight_figures_and_says_what_is_not_converged(drawn, request, tmp_path):
    if not drawn:
        request.getfixturevalue("undrawn")
    done = succeeds("paper", "--output", "figures", "--duration", "0.1", "--format", "svg", folder=tmp_path)
    names = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert names == [f"paper-fig{number:02d}.svg" for number in (2, 3, 4, 5, 7, 8, 9, 10)]
    assert "RK4 + GPOPM at 0.01 s against DOP853 at 1e-11:\n  converged to 1 mm: the largest error is " in done.stdout
    assert ("GPOPM" in (tmp_path / "figures" / "paper-fig04.svg").read_text()) is drawn


def test_help_names_every_command_and_the_methods(tmp_path):
    text = mbproj("--help", folder=tmp_path).stdout
    for name in COMMANDS:
        assert f"\n  {name} " in text
    assert "gpopm-pinv" in mbproj("run", "--help", folder=tmp_path).stdout


def test_check_says_what_a_run_has_to_be_told(tmp_path):
    body = "bodies: {ball: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}\n"
    (tmp_path / "ball.yaml").write_text(f"mbproj: 1\ngravity: [0, 0, 0]\n{body}", encoding="utf-8")
    done = mbproj("check", "ball.yaml", folder=tmp_path)
    assert done.stdout.endswith("  can run, given --duration and --step or --tolerance\n")
    assert mbproj("run", "ball.yaml", "--duration", "1", "--step", "0.1", folder=tmp_path).returncode == 0


# What bash, zsh and fish offer, asked through the functions that they load from mbproj.

#: The function runs as the shell would run it; what only works while the cursor is in a line is replaced.
BASH = """
compopt() { echo "left to the shell: ${@: -1}"; }
source "$HOME/completion"
COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
_mbproj_completion mbproj
printf '%s\\n' "${COMPREPLY[@]}"
"""
ZSH = """
autoload -U compinit && compinit -D -u
source "$HOME/completion"
compadd() { print -l -- ${(P)@[-1]}; }
_describe() { print -l -- ${${(P)@[-2]}%%:*}; }
_path_files() { print "left to the shell: $1"; }
words=("$@") CURRENT=$#
_mbproj_completion mbproj
"""
FISH = """
source "$HOME/completion"
complete --do-complete "$argv"
"""


@dataclass(frozen=True)
class Shell:
    """A shell by its name, its program, and the folder with the command `mbproj` and what it prints for the shell."""

    name: str
    program: str
    commands: Path

    def offers(self, folder: Path, *words: str) -> list[str]:
        """What it offers for the last of these words."""
        arguments = [" ".join(("mbproj", *words))] if self.name == "fish" else ["mbproj", *words]
        start = {"bash": ["--norc", "-c", BASH, "bash"], "zsh": ["-f", "-c", ZSH, "zsh"], "fish": ["-c", FISH]}
        environment = {"PATH": f"{self.commands}{os.pathsep}{os.environ['PATH']}", "HOME": str(self.commands)}
        done = subprocess.run(
            [self.program, *start[self.name], *arguments],
            capture_output=True,
            text=True,
            cwd=folder,
            check=False,
            env=environment,
        )
        assert done.stderr == ""
        lines = [line for line in done.stdout.splitlines() if line]
        return [line.partition("\t")[0] for line in lines] if self.name == "fish" else lines


def installed(name: str) -> pytest.param:
    program = shutil.which(name)
    mark = pytest.mark.skipif(program is None, reason=f"{name} is not installed")
    return pytest.param((name, program), id=name, marks=mark)


@pytest.fixture(scope="module", params=[installed(name) for name in ("bash", "zsh", "fish")])
def shell(request, tmp_path_factory) -> Shell:
    folder = tmp_path_factory.mktemp("commands")
    script = folder / "mbproj"
    script.write_text(f"#!/bin/sh\nPYTHONPATH='{ROOT}' exec '{sys.executable}' -m mbproj \"$@\"\n")
    script.chmod(0o755)
    name, program = request.param
    printed = subprocess.run([script], capture_output=True, check=True, env={"_MBPROJ_COMPLETE": f"{name}_source"})
    (folder / "completion").write_bytes(printed.stdout)
    return Shell(name, program, folder)


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("files")
    for name in ("crank.yaml", "rod.yml", "crank.h5", "notes.txt", "scenes/four_bar.yaml", "scenes/old/one.yaml"):
        (path / name).parent.mkdir(parents=True, exist_ok=True)
        (path / name).touch()
    (path / "deep" / "only").mkdir(parents=True)
    (path / "deep" / "only" / "scene.yaml").touch()
    (path / "spaces").mkdir()
    (path / "spaces" / "a scene.yaml").touch()
    return path


def test_commands(shell, files):
    assert sorted(shell.offers(files, "")) == sorted(COMMANDS)
    assert sorted(shell.offers(files, "re")) == ["recommend", "rerun"]


def test_a_scene_is_a_yaml_file_or_in_a_folder(shell, files):
    for command in ("run", "check", "recommend", "tradeoff", "batch", "stability"):
        assert shell.offers(files, command, "cra") == ["crank.yaml"]
    assert sorted(shell.offers(files, "run", "")) == ["crank.yaml", "deep/", "rod.yml", "scenes/", "spaces/"]
    assert sorted(shell.offers(files, "run", "sc")) == ["scenes/four_bar.yaml", "scenes/old/"]
    assert shell.offers(files, "run", "de") == ["deep/only/scene.yaml"]


def test_results_are_h5_files(shell, files):
    for words in (("plot",), ("info",), ("rerun",), ("plot", "crank.h5"), ("run", "crank.yaml", "-o")):
        assert shell.offers(files, *words, "cr") == ["crank.h5"]


def test_options_and_their_choices(shell, files):
    assert shell.offers(files, "run", "--certi") == ["--certify"]
    assert sorted(shell.offers(files, "run", "--projection", "")) == sorted(PROJECTIONS)
    assert shell.offers(files, "run", "--integrator", "dopr") == ["dopri5"]
    assert shell.offers(files, "run", "--project-position", "t") == ["true"]
    assert sorted(shell.offers(files, "plot", "--kind", "")) == sorted([*KINDS, *SWEEP_PICTURES, *OF_DESIGNS])
    assert shell.offers(files, "plot", "--format", "sv") == ["svg"]
    assert sorted(shell.offers(files, "stability", "--vary", "")) == sorted(QUANTITIES)
    assert shell.offers(files, "new", "slid") == ["slider-crank"]
    assert sorted(shell.offers(files, "help", "")) == sorted(pages())


def test_a_list_is_completed_word_by_word(shell, files):
    """The function for fish, which is click's, cuts what is offered at the first comma."""
    offered = [] if shell.name == "fish" else ["gopm,gpopm", "gopm,gpopm-pinv"]
    assert sorted(shell.offers(files, "compare", "--projections", "gopm,gpopm")) == offered


def test_names_that_need_quotes_and_other_files_are_left_to_the_shell(shell, files):
    left = {"bash": ["left to the shell: default"], "zsh": ["left to the shell: -f"], "fish": ["spaces/a scene.yaml"]}
    assert shell.offers(files, "run", "spaces/") == left[shell.name]
    other = {"bash": ["left to the shell: default"], "zsh": ["left to the shell: -f"], "fish": ["notes.txt"]}
    assert shell.offers(files, "run", "no") == other[shell.name]
    folders = {"bash": ["left to the shell: dirnames"], "zsh": ["left to the shell: -/"], "fish": ["scenes/"]}
    assert shell.offers(files, "export", "crank.h5", "-o", "sce") == folders[shell.name]


def test_a_folder_that_is_not_there_is_left_to_the_shell(shell, files):
    left = {"bash": ["left to the shell: default"], "zsh": ["left to the shell: -f"], "fish": []}
    assert shell.offers(files, "run", "nowhere/") == left[shell.name]
