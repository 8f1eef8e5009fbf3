"""What bash, zsh and fish offer, asked through the functions that they load from mbproj."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from mbproj.cli.main import COMMANDS
from mbproj.cli.studies.pictures import OF_DESIGNS
from mbproj.figures import KINDS
from mbproj.figures.sweeps import PICTURES
from mbproj.guide.pages import pages
from mbproj.registry import PROJECTIONS
from mbproj.studies import QUANTITIES
from tests.support import ROOT

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
    script.write_text(
        f"#!/bin/sh\nPYTHONPATH='{ROOT}' exec '{sys.executable}' -c 'from mbproj.cli import main; main()' \"$@\"\n"
    )
    script.chmod(0o755)
    name, program = request.param
    printed = subprocess.run([script], capture_output=True, check=True, env={"_MBPROJ_COMPLETE": f"{name}_source"})
    (folder / "completion").write_bytes(printed.stdout)
    return Shell(name, program, folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("files")
    for name in ("crank.yaml", "rod.yml", "crank.h5", "notes.txt", "scenes/four_bar.yaml", "scenes/old/one.yaml"):
        (path / name).parent.mkdir(parents=True, exist_ok=True)
        (path / name).touch()
    (path / "deep" / "only").mkdir(parents=True)
    (path / "deep" / "only" / "scene.yaml").touch()
    (path / "spaces").mkdir()
    (path / "spaces" / "a scene.yaml").touch()
    return path


def test_commands(shell, folder):
    assert sorted(shell.offers(folder, "")) == sorted(COMMANDS)
    assert sorted(shell.offers(folder, "re")) == ["recommend", "rerun"]


def test_a_scene_is_a_yaml_file_or_in_a_folder(shell, folder):
    for command in ("run", "check", "recommend", "tradeoff", "batch", "stability"):
        assert shell.offers(folder, command, "cra") == ["crank.yaml"]
    assert sorted(shell.offers(folder, "run", "")) == ["crank.yaml", "deep/", "rod.yml", "scenes/", "spaces/"]
    assert sorted(shell.offers(folder, "run", "sc")) == ["scenes/four_bar.yaml", "scenes/old/"]
    assert shell.offers(folder, "run", "de") == ["deep/only/scene.yaml"]


def test_results_are_h5_files(shell, folder):
    for words in (("plot",), ("info",), ("rerun",), ("plot", "crank.h5"), ("run", "crank.yaml", "-o")):
        assert shell.offers(folder, *words, "cr") == ["crank.h5"]


def test_options_and_their_choices(shell, folder):
    assert shell.offers(folder, "run", "--certi") == ["--certify"]
    assert sorted(shell.offers(folder, "run", "--projection", "")) == sorted(PROJECTIONS)
    assert shell.offers(folder, "run", "--integrator", "dopr") == ["dopri5"]
    assert shell.offers(folder, "run", "--project-position", "t") == ["true"]
    assert sorted(shell.offers(folder, "plot", "--kind", "")) == sorted([*KINDS, *PICTURES, *OF_DESIGNS])
    assert shell.offers(folder, "plot", "--format", "sv") == ["svg"]
    assert sorted(shell.offers(folder, "stability", "--vary", "")) == sorted(QUANTITIES)
    assert shell.offers(folder, "new", "slid") == ["slider-crank"]
    assert sorted(shell.offers(folder, "help", "")) == sorted(pages())


def test_a_list_is_completed_word_by_word(shell, folder):
    """The function for fish, which is click's, cuts what is offered at the first comma."""
    offered = [] if shell.name == "fish" else ["gopm,gpopm", "gopm,gpopm-pinv"]
    assert sorted(shell.offers(folder, "compare", "--projections", "gopm,gpopm")) == offered


def test_names_that_need_quotes_and_other_files_are_left_to_the_shell(shell, folder):
    left = {"bash": ["left to the shell: default"], "zsh": ["left to the shell: -f"], "fish": ["spaces/a scene.yaml"]}
    assert shell.offers(folder, "run", "spaces/") == left[shell.name]
    other = {"bash": ["left to the shell: default"], "zsh": ["left to the shell: -f"], "fish": ["notes.txt"]}
    assert shell.offers(folder, "run", "no") == other[shell.name]
    folders = {"bash": ["left to the shell: dirnames"], "zsh": ["left to the shell: -/"], "fish": ["scenes/"]}
    assert shell.offers(folder, "export", "crank.h5", "-o", "sce") == folders[shell.name]


def test_a_folder_that_is_not_there_is_left_to_the_shell(shell, folder):
    left = {"bash": ["left to the shell: default"], "zsh": ["left to the shell: -f"], "fish": []}
    assert shell.offers(folder, "run", "nowhere/") == left[shell.name]
