"""Completion of arguments in a shell: scenes, results, folders, one of several words, a list of words."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

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


class Words(click.types.StringParamType):
    """A word of a registry. The registry is read only where its words are shown, because a search for plug-ins takes
    time."""

    def __init__(self, words: Collection[str]) -> None:
        self._words = words

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """The words, as the help shows the values of an option."""
        return "|".join(self._words)

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """The words that begin with `incomplete`."""
        return [CompletionItem(word) for word in self._words if word.startswith(incomplete)]


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
        given, comma, last = incomplete.rpartition(",")
        left = [word for word in words() if word not in given.split(",")]
        return [f"{given}{comma}{word}" for word in left if word.startswith(last)]

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
