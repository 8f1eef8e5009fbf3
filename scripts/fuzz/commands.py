"""Command lines: options as the commands themselves declare them, with values that belong there or do not."""

from __future__ import annotations

from random import Random
from typing import Any

import click

from fuzz.values import any_value, path
from mbproj.commands.main import mbproj

#: What each command works with, short enough to end at once, and how often it is drawn: those that start processes of
#: their own take a second each.
BASES: dict[str, tuple[int, tuple[str, ...]]] = {
    "run": (30, ("scene.yaml", "--duration", "0.01")),
    "check": (12, ("scene.yaml",)),
    "rerun": (4, ("short.h5",)),
    "plot": (6, ("short.h5", "--kind", "energy")),
    "info": (5, ("short.h5",)),
    "export": (6, ("short.h5",)),
    "compare-results": (4, ("short.h5", "other.h5")),
    "new": (8, ("chain",)),
    "schema": (1, ()),
    "examples": (1, ()),
    "verify": (2, ("scene.yaml", "--duration", "0.01")),
    "recommend": (2, ("scene.yaml", "--until", "0.01", "--error", "1e-3")),
    "batch": (2, ("scene.yaml",)),
    "compare": (1, ("scene.yaml", "--until", "0.01", "--repeat", "1")),
    "tradeoff": (1, ("scene.yaml", "--until", "0.01", "--repeat", "1", "--longest", "0.01", "--integrators", "rk4")),
    "threshold": (1, ("scene.yaml", "--duration", "0.01", "--repeat", "1")),
    "stability": (1, ("scene.yaml", "--duration", "0.01", "--vary", "step", "--points", "3")),
}


def command_line(random: Random, scene: str | None = None) -> list[str]:
    """A command with its arguments. `scene`: a scene that it is to read, if it reads one."""
    name = random.choices(list(BASES), [weight for weight, _ in BASES.values()])[0]
    base = list(BASES[name][1])
    if scene is not None:
        base = [scene if part == "scene.yaml" else part for part in base]
    elif base and random.random() < 0.25:
        base[0] = path(random)
    command = mbproj.get_command(click.Context(mbproj), name)
    assert command is not None
    options = [parameter for parameter in command.params if isinstance(parameter, click.Option)]
    given: list[str] = []
    for option in random.sample(options, min(len(options), random.choice((0, 1, 1, 2, 3)))):
        given += _option(option, random)
    if random.random() < 0.03:
        given.append(any_value(random))
    return [name, *base, *given]


def _option(option: click.Option, random: Random) -> list[str]:
    name = option.opts[0]
    if option.is_flag:
        return [name]
    return [name, _value(option.type, random)]


def _value(kind: Any, random: Random) -> str:
    if isinstance(kind, click.Choice) and random.random() < 0.8:
        return str(random.choice(list(kind.choices)))
    if isinstance(kind, click.Path) and random.random() < 0.9:
        return path(random)
    if isinstance(kind, click.types.IntParamType) and random.random() < 0.5:
        return str(random.choice((1, 2, 3)))
    return any_value(random)
