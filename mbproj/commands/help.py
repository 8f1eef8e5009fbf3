"""`mbproj help`: the guide, in the terminal or as web pages."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import click

from mbproj.base.errors import InputError
from mbproj.commands.options import FolderPath, Part, explained, one_of, option
from mbproj.guide.pages import KINDS, GuidePage, page_of, pages, search

#: The most sections that a search shows.
MOST_HITS = 12
EXAMPLES = (
    ("Show a page: ten minutes from nothing to a mechanism.", "mbproj help getting_started"),
    ("Find the pages in which both words stand.", "mbproj help redundant reactions"),
    ("Write the whole guide as web pages.", "mbproj help --html guide"),
)


@explained("help", EXAMPLES)
@click.argument("words", metavar="[TOPIC | WORDS]...", nargs=-1, shell_complete=one_of(pages))
@option(
    Part.OUTPUT,
    "--html",
    "site",
    type=FolderPath(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Write the whole guide as web pages into DIR.",
)
@click.pass_context
def command(context: click.Context, words: tuple[str, ...], site: Path | None) -> None:
    """Shows the guide: its topics, one TOPIC, or the sections that contain WORDS."""
    if site is not None:
        from mbproj.guide.pages import write_site

        click.echo(f"written: {write_site(site)}", err=True)
    elif not words:
        click.echo(contents())
    elif (page := page_of(words)) is not None:
        show(page)
    elif len(words) == 1 and (asked := _command(context, words[0])) is not None:
        click.echo(asked.get_help(click.Context(asked, info_name=words[0], parent=context.parent)))
    else:
        click.echo(matching_sections(words))


def contents() -> str:
    """The list of topics, by kind of page."""
    width = max((len(topic) for topic in pages()), default=0)
    lines = []
    for kind, title in KINDS.items():
        of_kind = (page for page in pages().values() if page.kind == kind)
        lines += [title, *(f"  {page.topic:{width}}  {page.title}" for page in of_kind), ""]
    return "\n".join([*lines, "Show a page with `mbproj help TOPIC`; search all pages with `mbproj help WORDS`."])


def show(page: GuidePage) -> None:
    """Show a page, in a pager where there is a terminal."""
    from mbproj.guide.pages import rendered

    if sys.stdout.isatty():
        click.echo_via_pager(rendered(page, shutil.get_terminal_size().columns, colours=True))
    else:
        click.echo(rendered(page), nl=False)


def matching_sections(words: tuple[str, ...]) -> str:
    """The sections that contain the words. Raises InputError where none does."""
    hits = search(words)
    if not hits:
        raise InputError(f"no page of the guide has {' or '.join(map(repr, words))}; `mbproj help` lists the topics")
    few = hits[0].words < len({word.casefold() for word in words})
    lines = ["No section has all of these words; these have most of them:"] if few else []
    lines += [f"{hit.page.topic}: {hit.section}\n    {hit.line}" for hit in hits[:MOST_HITS]]
    more = len(hits) - MOST_HITS
    return "\n".join([*lines, *([f"and {more} more"] if more > 0 else []), "Show a page with `mbproj help TOPIC`."])


def _command(context: click.Context, name: str) -> click.Command | None:
    group = context.parent.command if context.parent else None
    return group.get_command(context, name) if isinstance(group, click.Group) else None
