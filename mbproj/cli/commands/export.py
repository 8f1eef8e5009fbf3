"""`mbproj export`: results as CSV tables, and scenes as models of other formats, for programs that read those."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.cli.completion import Folder, results_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.quantity import Corners
from mbproj.cli.study_options import force as force_option
from mbproj.errors import ExitCode, InputError, Problem

    from mbproj.calls.files import named, written

    if only_list:
        found = {table.name: table for table in tables(shown, corners)}
        click.echo("\n".join([named(found, name) for name in chosen] or found))
        return
    for path in written(shown, folder, chosen, file_format, corners, force=force).values():
        click.echo(path)
