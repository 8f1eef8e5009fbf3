"""The options that studies have in common, each a decorator of their commands."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from mbproj.cli.quantity import Names, Positive
from mbproj.registry import PROJECTIONS
from mbproj.registry import integrators as known_integrators

Command = TypeVar("Command", bound=Callable[..., Any])

at = click.option("--at", type=Names(), metavar="A,B,..",
                  help="Markers whose error counts, or bodies of a scene without markers [default: all].")
until = click.option("--until", type=Positive("s"), metavar="TIME", help="End of the study [default: the duration].")
changes = click.option("--set", "changes", multiple=True, metavar="NAME=VALUE", help="Change a parameter of the scene.")
repeat = click.option("--repeat", default=5, show_default=True, type=click.IntRange(1),
                      help="How often each setting is timed.")
fresh = click.option("--fresh", is_flag=True, help="Start over: use nothing of an earlier study.")


def projections(default: str) -> Callable[[Command], Command]:
    """Several methods by name; `default` says which are taken otherwise."""
    text = f"Of {', '.join(PROJECTIONS)} [default: {default}]."
    return click.option("--projections", type=Names(), metavar="A,B,..", help=text)


def integrators(default: str) -> Callable[[Command], Command]:
    """Several integrators by name; `default` says which are taken otherwise."""
    text = f"Of {', '.join(known_integrators())} [default: {default}]."
    return click.option("--integrators", type=Names(), metavar="A,B,..", help=text)


force = click.option("--force", is_flag=True, help="Replace files that mbproj did not write, too.")


def files(command: Command) -> Command:
    """The options -o (`output`), --format (`ending`) and --force, which replaces files that mbproj did not write."""
    command = force(command)
    formats = click.Choice(["png", "svg", "pdf"])
    command = click.option("--format", "ending", default="png", type=formats, help="Format [default: png].")(command)
    folder = click.Path(path_type=Path)
    return click.option(
        "-o", "--output", default=".", type=folder, metavar="DIR", help="Output directory [default: .]."
    )(command)
