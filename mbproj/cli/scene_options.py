"""The common options of commands on a scene: --set, and one for each setting of a run.

The scene's reader reads their text by its own rules, with units and suggestions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import click

from mbproj.cli.completion import Words, scene_file
from mbproj.cli.explained import Part, option
from mbproj.errors import InputError, Place, Problem
from mbproj.settings import SETTINGS, SettingEntry, option_name, settings_taken

Command = TypeVar("Command", bound=Callable[..., Any])

#: The parts of the help that options stand in, where not with integration, or projection.
PARTS = {"duration": Part.WHAT, "start": Part.WHAT, "adjust_joints": Part.WHAT, "output_step": Part.OUTPUT}
#: Further names of these options.
ALSO = {"duration": ["--until"]}
#: The names of all these options.
SCENE_OPTIONS = ("--set", *map(option_name, SETTINGS))


def _option(entry: SettingEntry) -> Callable[[Command], Command]:
    """The decorator that adds the option of a setting."""
    words = ("true", "false") if entry.kind == "bool" else entry.words
    metavar = {"float": "TIME" if entry.takes == "s" else "NUMBER", "int": entry.takes}.get(entry.kind, entry.metavar)
    part = PARTS.get(entry.name, Part.INTEGRATION if len(entry.path) == 1 else Part.PROJECTION)
    names = (option_name(entry.name), *ALSO.get(entry.name, ()), entry.name)
    return option(part, *names, help=entry.help, **({"type": Words(words)} if words != () else {"metavar": metavar}))


def scene_options(command: Command) -> Command:
    """Decorate a command with the argument SCENE and all these options; `overrides` collects their values."""
    return scene_options_of("")(command)


def scene_options_of(name: str) -> Callable[[Command], Command]:
    """Return a decorator like `scene_options` for the study of this name, which chooses some settings itself."""

    def add(command: Command) -> Command:
        for entry in reversed([*settings_taken(name).values()]):
            command = _option(entry)(command)
        command = option(
            Part.WHAT,
            "--set",
            "settings",
            multiple=True,
            metavar="NAME=VALUE",
            help="Change a parameter, or any value by its path.",
        )(command)
        return click.argument("scene", type=scene_file())(command)

    return add


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
