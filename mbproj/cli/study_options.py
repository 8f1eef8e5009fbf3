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
                  help="Markers (or bodies, where there are none) whose error counts (all).")
until = click.option("--until", type=Positive("s"), metavar="TIME", help="Up to this time (the duration).")
changes = click.option("--set", "changes", multiple=True, metavar="NAME=VALUE", help="Changes a parameter.")
repeat = click.option("--repeat", default=5, show_default=True, type=click.IntRange(1),
                      help="Timings of each setting.")
fresh = click.option("--fresh", is_flag=True, help="Begin anew where an earlier study was interrupted or is complete.")


def projections(default: str) -> Callable[[Command], Command]:
    """Several methods by name; `default` says which are taken otherwise."""
    text = f"Of {', '.join(PROJECTIONS)} ({default})."
    return click.option("--projections", type=Names(), metavar="A,B,..", help=text)


def integrators(default: str) -> Callable[[Command], Command]:
    """Several integrators by name; `default` says which are taken otherwise."""
    text = f"Of {', '.join(known_integrators())} ({default})."
    return click.option("--integrators", type=Names(), metavar="A,B,..", help=text)


force = click.option("--force", is_flag=True, help="Replace files that mbproj did not write, too.")


def files(command: Command) -> Command:
    """Where tables and figures go, `output`, the figures' format, `ending`, and whether to replace what is not ours."""
    command = force(command)
    formats = click.Choice(["png", "svg", "pdf"])
    command = click.option("--format", "ending", default="png", type=formats, help="Format (png).")(command)
    folder = click.Path(path_type=Path)
    return click.option("-o", "--output", default=".", type=folder, metavar="DIR", help="Directory (.).")(command)
