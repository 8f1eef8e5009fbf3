"""Tables of the program: commands and options, exit codes, results files, pictures, checks, the Python API."""

from __future__ import annotations

import inspect

import click

import mbproj
from mbproj.cli.main import COMMANDS
from mbproj.cli.main import mbproj as group
from mbproj.errors import ExitCode
from mbproj.plot.kinds import KINDS
from mbproj.results.layout import CONSTANTS, DATASETS, NAMES
from mbproj.studies.stability.quantities import QUANTITIES
from mbproj.studies.verify.checks import CHECKS

from .markdown import code, table

#: What each exit code means to a caller.
MEANINGS = {
    ExitCode.DONE: "done",
    ExitCode.INTERNAL: "a fault of mbproj: please report it",
    ExitCode.BAD_INPUT: "wrong input: the message names the place and a next step",
    ExitCode.FAILED: "a simulation failed: the message names the time, the cause and what to try",
    ExitCode.CHECK_FAILED: "a check that was asked for does not hold",
    ExitCode.INTERRUPTED: "interrupted by Ctrl-C or SIGTERM; what was done is kept",
}


def commands() -> str:
    """Every command with its purpose and a table of its options."""
    context = click.Context(group, info_name="mbproj")
    parts = []
    for name in COMMANDS:
        command = group.get_command(context, name)
        assert command is not None
        own = click.Context(command, info_name=name, parent=context)
        usage = " ".join(command.collect_usage_pieces(own))
        summary = inspect.cleandoc(command.help or "").partition("\n\n")[0].replace("\n", " ")
        rows = [
            [code(record[0]), record[1]]
            for parameter in command.get_params(own)
            if (record := parameter.get_help_record(own)) is not None
        ]
        parts.append(f"## {name}\n\n`mbproj {name} {usage}`\n\n{summary}\n\n{table(['option', 'what it does'], rows)}")
    return "\n".join(parts)


def exit_codes() -> str:
    return table(["code", "meaning"], [[code(int(each)), MEANINGS[each]] for each in ExitCode])


def datasets() -> str:
    """Every dataset: its shape, unit, and what it is."""
    rows = []
    for each in DATASETS:
        shape = ", ".join(["T", *map(str, each.shape)])
        frame = f"; {each.frame}" if each.frame else ""
        rows.append([code(each.path), f"({shape})", each.unit, each.description + frame])
    for mark in CONSTANTS:
        rows.append([code(mark.path), f"({', '.join(map(str, mark.shape))})", mark.unit, mark.description])
    rows += [[code(each.path), f"({each.symbol})", "", each.description] for each in NAMES.values()]
    return table(["dataset", "shape", "unit", "what it is"], rows)


def pictures() -> str:
    return table(["kind", "what it shows"], [[code(name), kind.summary] for name, kind in KINDS.items()])


def checks() -> str:
    return table(["check", "what it claims"], [[code(name), check.claim] for name, check in CHECKS.items()])


def quantities() -> str:
    rows = [[code(name), each.unit, each.summary] for name, each in QUANTITIES.items()]
    return table(["quantity", "unit", "what varies"], rows)


def python_names() -> str:
    """Every public name with the first sentence of its docstring."""
    rows = []
    for name in sorted(mbproj.__all__):
        found = getattr(mbproj, name)
        said = inspect.cleandoc(found.__doc__ or "").partition("\n\n")[0].replace("\n", " ")
        rows.append([code(name), f"version of mbproj, now {found}" if name == "__version__" else said])
    return table(["name", "what it is"], rows)
