"""The help of every command: its options by what they decide, and examples that work."""

from __future__ import annotations

import shutil
from importlib.util import find_spec

import click
import pytest
from click.testing import CliRunner

from mbproj.commands.main import COMMANDS, GROUPS
from mbproj.commands.main import mbproj as group
from mbproj.commands.options import GroupedOption, Part
from tests.cli.commands import mbproj
from tests.cli.examples import examples, fill, named

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
def folder(tmp_path_factory):
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
def test_an_example_does_what_it_says(name, arguments, folder, tmp_path, undrawn):
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    done = mbproj(*arguments, folder=tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("name", "arguments"), list(examples(long=True)), ids=str)
def test_a_long_example_is_read_without_complaint(name, arguments, folder, monkeypatch):
    monkeypatch.chdir(folder)
    command, context = named(name)
    own = command.make_context(name, arguments[1:], parent=context.parent)
    for path in (own.params.get("scene"), *own.params.get("paths", ())):
        assert path is None or any(folder.glob(str(path)))
