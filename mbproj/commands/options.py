"""The common options of commands on a scene: --set, and one for each setting of a run.

The scene's reader reads their text by its own rules, with units and suggestions.
"""

from __future__ import annotations

import inspect
import os
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, TypedDict, TypeVar

import click
from click.shell_completion import CompletionItem

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem
from mbproj.base.settings import SETTINGS, SettingEntry, option_name, settings_taken
from mbproj.commands.kinds import Kind, Words

if TYPE_CHECKING:
    from mbproj.commands.arguments import Quantity
    from mbproj.results.record import Results

# --- Completion of arguments in a shell -------------------------------------------------------------------------------
# Scenes, results, folders, one of several words, a list of words.


#: Names that every shell takes as one word without quotes. Other names are left to the shell, which can quote them.
PLAIN = re.compile(r"[\w%+,./-]*")


class File(click.Path):
    """The path of a file with one of these endings."""

    def __init__(self, *endings: str, **attributes: Any) -> None:
        super().__init__(**attributes)
        self._endings = endings

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """The matching files, and the folders to search; where there are none, the shell's own completion."""
        candidates = list(_matching(incomplete, self._endings))
        while len(candidates) == 1 and candidates[0].endswith(
            "/"
        ):  # a shell would end the word after the only candidate
            inside = list(_matching(candidates[0], self._endings))
            if not inside:
                break
            candidates = inside
        if not candidates or not all(PLAIN.fullmatch(each) for each in (incomplete, *candidates)):
            return [CompletionItem(incomplete, type="file")]
        return [CompletionItem(each) for each in candidates]


class FolderPath(click.Path):
    """The path of a folder, which a command may create."""

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Leave the completion of folders to the shell."""
        return [CompletionItem(incomplete, type="dir")]


def scene_file(**attributes: Any) -> File:
    """The type of an argument SCENE."""
    return File(".yaml", ".yml", **attributes)


def results_file(**attributes: Any) -> File:
    """The type of an argument RESULTS."""
    return File(".h5", **attributes)


def one_of(words: Callable[[], Collection[str]]) -> Callable[..., list[str]]:
    """The `shell_complete` of an option that takes one of these words."""

    def complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
        return [word for word in words() if word.startswith(incomplete)]

    return complete


def some_of(words: Callable[[], Collection[str]]) -> Callable[..., list[str]]:
    """The `shell_complete` of an option that takes several of these words: A,B,.."""

    def complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
        typed, comma, last = incomplete.rpartition(",")
        left = [word for word in words() if word not in typed.split(",")]
        return [f"{typed}{comma}{word}" for word in left if word.startswith(last)]

    return complete


def _matching(incomplete: str, endings: tuple[str, ...]) -> Iterator[str]:
    """The paths that begin with the typed text: files with these endings, and folders with a slash."""
    start = incomplete.rpartition("/")[2]
    folder = incomplete[: len(incomplete) - len(start)]
    try:
        entries = sorted(os.scandir(Path(folder or ".")), key=lambda entry: entry.name)
    except OSError:
        return
    for entry in entries:
        if not entry.name.startswith(start) or (entry.name.startswith(".") and not start):
            continue
        if entry.is_dir():
            yield f"{folder}{entry.name}/"
        elif entry.name.endswith(endings):
            yield f"{folder}{entry.name}"


# --- Commands whose help groups the options by their purpose, and ends with examples ----------------------------------


#: The names of arguments and options in earlier versions, and what to give instead.
EARLIER = {
    "resume": "keep",
    "repetitions": "repeat",
    "processes": "jobs",
    "tell": "progress",
    "from_equilibrium": "start equilibrium",
}


class Part(Enum):
    """The purposes of options. The values are the headings of a help text, in this order."""

    WHAT = "What"
    INTEGRATION = "How: integration"
    PROJECTION = "How: projection"
    ACCURACY = "How: accuracy"
    EFFORT = "How: effort"
    OUTPUT = "Output"
    HELP = "Help"


class GroupedOption(click.Option):
    """An option with the part of the help that it belongs to."""

    def __init__(self, *names: Any, part: Part, **attributes: Any) -> None:
        super().__init__(*names, **attributes)
        self.part = part


class Command(click.Command):
    """A command with examples: sentences, each with the command line that does so."""

    def __init__(self, *names: Any, examples: Sequence[tuple[str, str]], **attributes: Any) -> None:
        super().__init__(*names, **attributes)
        self.examples = examples

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments. Raises NoSuchOption, for an option of an earlier version with the one to give instead."""
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            now = f"--{EARLIER.get(error.option_name.lstrip('-').replace('-', '_'), '')}"
            if now.partition(" ")[0] not in (name for option in self.params for name in option.opts):
                raise
            said = f"No such option '{error.option_name}'; give {now}"
            raise click.NoSuchOption(error.option_name, said, ctx=ctx) from error

    def options_by_part(self, context: click.Context) -> dict[Part, list[click.Parameter]]:
        """The options by purpose; click's own `--help` comes last."""
        groups: dict[Part, list[click.Parameter]] = {part: [] for part in Part}
        for parameter in self.get_params(context):
            if isinstance(parameter, click.Option):
                groups[parameter.part if isinstance(parameter, GroupedOption) else Part.HELP].append(parameter)
        return {part: options for part, options in groups.items() if options}

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write a section of the help for each part."""
        for part, options in self.options_by_part(ctx).items():
            records = [record for option in options if (record := option.get_help_record(ctx)) is not None]
            with formatter.section(part.value):
                formatter.write_dl(records)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples as lines that can be given to a shell."""
        with formatter.section("Examples"):
            for said, line in self.examples:
                formatter.write(f"{'':{formatter.current_indent}}# {said}\n{'':{formatter.current_indent}}{line}\n")


def explained(
    name: str, examples: Sequence[tuple[str, str]], **attributes: Any
) -> Callable[[Callable[..., Any]], Command]:
    """Return a decorator that makes the function a command with these examples."""
    return click.command(name, cls=Command, examples=examples, **attributes)


def option(part: Part, *names: str, **attributes: Any) -> Callable[[Any], Any]:
    """Return a decorator that adds an option to a command, in this part of its help."""
    return click.option(*names, cls=GroupedOption, part=part, **attributes)


# --- The common options of commands on a scene ------------------------------------------------------------------------


Decorated = TypeVar("Decorated", bound=Callable[..., Any])

#: The parts of the help that options stand in, where not with integration, or projection.
PARTS = {"duration": Part.WHAT, "start": Part.WHAT, "adjust_joints": Part.WHAT, "output_step": Part.OUTPUT}
#: Further names of these options.
ALSO = {"duration": ["--until"]}
#: The names of all these options.
SCENE_OPTIONS = ("--set", *map(option_name, SETTINGS))


def _option(entry: SettingEntry) -> Callable[[Decorated], Decorated]:
    """The decorator that adds the option of a setting."""
    words = ("true", "false") if entry.kind == "bool" else entry.words
    metavar = {"float": "TIME" if entry.takes == "s" else "NUMBER", "int": entry.takes}.get(entry.kind, entry.metavar)
    part = PARTS.get(entry.name, Part.INTEGRATION if len(entry.path) == 1 else Part.PROJECTION)
    names = (option_name(entry.name), *ALSO.get(entry.name, ()), entry.name)
    return option(part, *names, help=entry.help, **({"type": Words(words)} if words != () else {"metavar": metavar}))


#: The default of an argument that is a mapping: no parameter is changed.
NOTHING: Mapping[str, Any] = MappingProxyType({})
#: Decorates a command with --set.
changes = option(
    Part.WHAT,
    "--set",
    "changes",
    multiple=True,
    metavar="NAME=VALUE",
    help="Change a parameter, or any value by its path.",
)


def scene_options(command: Decorated) -> Decorated:
    """Decorate a command with the argument SCENE and all these options; `overrides` collects their values."""
    return scene_options_of("")(command)


def scene_options_of(name: str) -> Callable[[Decorated], Decorated]:
    """Return a decorator like `scene_options` for the study of this name, which chooses some settings itself."""

    def add(command: Decorated) -> Decorated:
        for entry in reversed([*settings_taken(name).values()]):
            command = _option(entry)(command)
        command = changes(command)
        return click.argument("scene", type=scene_file())(command)

    return add


json_option = option(
    Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object instead of the report."
)
quiet_option = option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print nothing but errors.")
force_option = option(Part.OUTPUT, "--force", is_flag=True, help="Replace files that mbproj did not write, too.")


def output_option(usual: str | None, kind: click.Path, help: str, metavar: str | None = None) -> Any:
    """The decorator that adds -o to a command: `usual` is the name where none is given."""
    more = {"default": usual, "show_default": True} if usual is not None else {}
    more |= {} if metavar is None else {"metavar": metavar}
    return option(Part.OUTPUT, "-o", "--output", type=kind, help=help, **more)


def overrides(options: Mapping[str, Any]) -> dict[str, str]:
    """The settings that the command line gives, from a command's parameters."""
    return {name: options[name] for name in SETTINGS if options.get(name) is not None}


def parameters(settings: tuple[str, ...]) -> dict[str, str]:
    """The values that --set changes, by name. Raises InputError where a text is not NAME=VALUE."""
    changed = {}
    for text in settings:
        name, equals, value = text.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise InputError(Problem(f"'{text}' is not NAME=VALUE", Place("--set"), "e.g. --set crank_length=0.1"))
        changed[name.strip()] = value.strip()
    return changed


class RunSettings(TypedDict, total=False):
    """Settings of a run: numbers in SI units, or text with a unit. The scene's own settings complete them."""

    duration: Quantity | None
    step: Quantity | None
    tolerance: Quantity | None
    integrator: str | None
    projection: str | None
    formulation: str | None
    kinematic: bool | None
    acceleration: str | None
    impact_law: str | None
    output_step: Quantity | None
    break_times: Sequence[Quantity] | None
    start: str | None
    adjust_joints: Quantity | None
    projection_tolerance: Quantity | None
    projection_test: str | None
    project_position: bool | None
    project_velocity: bool | None
    projection_fallback: str | None
    energy_row: bool | None
    momentum_row: bool | None
    every: int | None
    threshold: Quantity | None
    max_iterations: int | None
    alpha: Quantity | None
    gains: Sequence[Quantity] | None


# --- Options and arguments as data: of a parameter of a function that is a command too ------------------------------


class Entry(ABC):
    """What a parameter is on the command line: an `Option` or an `Argument`."""

    kind: Any
    many: bool

    @abstractmethod
    def on_command_line(self, parameter: inspect.Parameter) -> Callable[[Any], Any]:
        """The decorator that adds it to a command for a parameter, with its default."""

    def read(self, value: Any, place: str) -> Any:
        """Return what a value stands for: numbers in SI units, names as a tuple. Raises InputError at `place`."""
        if not self.many:
            return self._one(value, place)
        several = value if isinstance(value, Iterable) and not isinstance(value, (str, Mapping)) else [value]
        values = tuple(self._one(each, place) for each in several)
        return self.kind.joined(values) if isinstance(self.kind, Kind) else values

    def _one(self, value: Any, place: str) -> Any:
        if isinstance(self.kind, Kind):
            return self.kind.of(value, place)
        return Path(value) if isinstance(self.kind, click.Path) and isinstance(value, str) else value


@dataclass(frozen=True)
class Option(Entry):
    """The option of a parameter: its part of the help, what it means, the `kind` that reads its value (a type of click;
    None for text), and a placeholder. `names` are its names on the command line, where these are not that of the
    parameter. `many`: it can be repeated. `complete` lists words for a shell."""

    part: Part
    words: str
    kind: Any = None
    metavar: str | None = None
    names: tuple[str, ...] = ()
    many: bool = False
    complete: Callable[..., Any] | None = None

    def names_of(self, name: str) -> tuple[str, ...]:
        """The names on the command line of the parameter of this name."""
        return self.names or (f"--{name.replace('_', '-')}",)

    def alone(self, name: str, usual: Any = None) -> Callable[[Any], Any]:
        """The decorator that adds the option to a command under this name, with a default."""
        return self.on_command_line(inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=usual))

    def on_command_line(self, parameter: inspect.Parameter) -> Callable[[Any], Any]:
        """The decorator that adds the option for a parameter, with its default."""
        name, usual = parameter.name, parameter.default
        more: dict[str, Any] = {"required": True} if usual is inspect.Parameter.empty else {}
        if usual is False:
            more["is_flag"] = True
        elif isinstance(usual, (int, float, str)) and usual != "":
            more |= {"default": usual, "show_default": True}
        if self.kind is not None and usual is not False:
            more["type"] = self.kind
        if self.many:
            more["multiple"] = True
        if self.complete is not None:
            more["shell_complete"] = self.complete
        if self.metavar is not None:
            more["metavar"] = self.metavar
        return option(self.part, *self.names_of(name), name, help=self.words, **more)


@dataclass(frozen=True)
class Argument(Entry):
    """A parameter that stands on the command line without a name; with `many`, several stand there."""

    kind: Any = None
    metavar: str | None = None
    many: bool = False

    def on_command_line(self, parameter: inspect.Parameter) -> Callable[[Any], Any]:
        """The decorator that adds the argument for a parameter."""
        required = parameter.default is inspect.Parameter.empty
        more: dict[str, Any] = {} if self.metavar is None else {"metavar": self.metavar}
        return click.argument(parameter.name, type=self.kind, nargs=-1 if self.many else 1, required=required, **more)


SomeResults = Annotated["Results | str | Path", Argument(results_file(path_type=Path))]
