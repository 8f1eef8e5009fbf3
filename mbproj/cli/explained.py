"""Commands whose help groups the options by their purpose, and ends with examples."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any

import click

#: Options of earlier versions, and what to give instead.
EARLIER = {"--from-equilibrium": "--start equilibrium"}


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
            if error.option_name not in EARLIER:
                raise
            raise click.NoSuchOption(error.option_name, possibilities=[EARLIER[error.option_name]], ctx=ctx) from error

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
