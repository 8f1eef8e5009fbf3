"""Runs the command line, or a program, in a process of its own, as a user does; see `fork_server.py`."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
import tempfile
from contextlib import closing
from functools import cache
from pathlib import Path
from threading import Lock

from tests.report_schema.reports import refuse_what_no_table_says
from tests.support import ROOT

FIVE_BAR = str(ROOT / "mechanisms" / "five_bar.yaml")
SLIDER_CRANK = str(ROOT / "mechanisms" / "spatial_slider_crank.yaml")


def environment() -> dict[str, str]:
    """Of another process: of this one's, what linear algebra goes by, or numbers differ by round-off, and what a
    sanitizer does."""
    kinds = ("OPENBLAS_", "OMP_", "LD_PRELOAD", "ASAN_", "UBSAN_")
    shared = {name: value for name, value in os.environ.items() if name.startswith(kinds)}
    return {"PYTHONPATH": str(ROOT), **shared}


def mbproj(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """`mbproj ARGUMENTS` in `folder`. What it prints as JSON is as the tables of facts say."""
    words = [str(each) for each in arguments]
    done = _run({"arguments": words}, folder)
    if "--json" in words and done.stdout.startswith(("{", "[")):
        refuse_what_no_table_says(words, json.loads(done.stdout))
    return done


def python(program: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """`python -c PROGRAM` in `folder`."""
    return _run({"program": program}, folder)


def _run(what: dict[str, object], folder: Path) -> subprocess.CompletedProcess[str]:
    with _ONE_AT_A_TIME, tempfile.TemporaryDirectory() as streams:
        paths = {name: Path(streams) / name for name in ("out", "err")}
        for path in paths.values():
            path.touch()
        request = {
            **what,
            "folder": str(folder),
            "environment": {"PYTHONPATH": str(ROOT), "MBPROJ_CACHE": str(folder / "cache")},
            **{name: str(path) for name, path in paths.items()},
        }
        server = _server()
        assert server.stdin is not None and server.stdout is not None
        server.stdin.write(json.dumps(request) + "\n")
        server.stdin.flush()
        code = int(server.stdout.readline())
        out, err = (path.read_text() for path in paths.values())
        return subprocess.CompletedProcess([*what], code, out, err)


_ONE_AT_A_TIME = Lock()


@cache
def _server() -> subprocess.Popen[str]:
    """`fork_server.py`, started once a test process. It ends when its standard input does."""
    program = [sys.executable, "-m", "tests.cli.fork_server"]
    return subprocess.Popen(
        program, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=environment()
    )


def kept(cache: Path) -> list[str]:
    """The names of what studies have kept in this folder for caches."""
    path = cache / "studies" / "store.sqlite3"
    if not path.exists():
        return []
    with closing(sqlite3.connect(path, timeout=30.0)) as database:
        try:
            return [name for (name,) in database.execute("SELECT item FROM kept ORDER BY item")]
        except sqlite3.OperationalError:  # its tables are still to be made
            return []
