"""Runs the command line as a user does, in this process, and a program in another: see `fork_server.py`."""

from __future__ import annotations

import gc
import io
import json
import os
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import cache
from pathlib import Path
from threading import Lock

import click
import pytest
from click.testing import CliRunner

from tests.cli.fork_server import in_this_process
from tests.cli.reports import refuse_what_no_table_says
from tests.support import ROOT

FIVE_BAR = str(ROOT / "mechanisms" / "five_bar.yaml")
SLIDER_CRANK = str(ROOT / "mechanisms" / "spatial_slider_crank.yaml")


def environment() -> dict[str, str]:
    """Of another process: of this one's, what linear algebra goes by, or numbers differ by round-off, and what a
    sanitizer does."""
    kinds = ("OPENBLAS_", "OMP_", "LD_PRELOAD", "ASAN_", "UBSAN_")
    shared = {name: value for name, value in os.environ.items() if name.startswith(kinds)}
    return {"PYTHONPATH": str(ROOT), **shared}


def mbproj(*arguments: object, folder: Path) -> subprocess.CompletedProcess[str]:
    """`mbproj ARGUMENTS` in `folder`, in this process, without the start of another. What it prints as JSON is as the
    tables of facts say."""
    from mbproj.commands.main import main

    words = [str(each) for each in arguments]
    with _as_a_process(words, folder) as (out, err), pytest.raises(SystemExit) as end:
        main()
    done = subprocess.CompletedProcess(words, int(end.value.code or 0), _text(out), _text(err))
    if "--json" in words and done.stdout.startswith(("{", "[")):
        refuse_what_no_table_says(words, json.loads(done.stdout))
    return done


def begun(*arguments: object, folder: Path, when: Callable[[], object]) -> subprocess.Popen[str]:
    """`mbproj ARGUMENTS` in a process of its own, which has come to where `when()` holds; for at most two minutes."""
    program = [sys.executable, "-c", "from mbproj.commands.main import main; main()", *map(str, arguments)]
    variables, pipe = environment() | {"MBPROJ_CACHE": str(folder / "cache")}, subprocess.PIPE
    process = subprocess.Popen(program, cwd=folder, env=variables, stdout=pipe, stderr=pipe, text=True)
    deadline = time.monotonic() + 120.0
    while not when() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    return process


def succeeds(*arguments: object, folder: Path) -> subprocess.CompletedProcess[str]:
    """`mbproj ARGUMENTS` in `folder`, which ends with 0."""
    done = mbproj(*arguments, folder=folder)
    assert done.returncode == 0, done.stderr
    return done


def invoked(command: click.Command, *arguments: object) -> tuple[int, str, str]:
    """The exit code, stdout and stderr of a command that is called as a function; its InputError passes through."""
    result = CliRunner().invoke(command, [str(argument) for argument in arguments], catch_exceptions=False)
    return result.exit_code, result.stdout, result.stderr


@contextmanager
def _as_a_process(words: list[str], folder: Path) -> Iterator[tuple[io.BytesIO, io.BytesIO]]:
    """With the arguments, the folder, the environment and the streams of a command; afterwards all is as it was, also
    what a command changes of its process. Studies run their cases here."""
    out, err, threshold, handler = io.BytesIO(), io.BytesIO(), gc.get_threshold(), signal.getsignal(signal.SIGINT)
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings(), Path(os.devnull).open() as nothing:
        _filter_as_python_does()
        patch.chdir(folder)
        for name in list(os.environ):
            patch.delenv(name)
        for name, value in (environment() | {"MBPROJ_CACHE": str(folder / "cache")}).items():
            patch.setenv(name, value)
        patch.setattr(sys, "argv", ["mbproj", *words])
        patch.setattr(sys, "stdin", nothing)
        patch.setattr(sys, "stdout", io.TextIOWrapper(out, "utf-8"))
        patch.setattr(sys, "stderr", io.TextIOWrapper(err, "utf-8"))
        patch.setattr(sys, "unraisablehook", sys.unraisablehook)
        patch.setattr("mbproj.studies.parallel.hand_out.processors", lambda: 1)
        patch.setattr("mbproj.studies.parallel.hand_out.in_parallel", in_this_process)
        try:
            yield out, err
        finally:
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
                stream.detach()
            gc.set_threshold(*threshold)
            signal.signal(signal.SIGINT, handler)


def _filter_as_python_does() -> None:
    """Each warning once a place and a process; what concerns developers alone is not shown."""
    warnings.resetwarnings()
    for category in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
        warnings.simplefilter("ignore", category)


def _text(stream: io.BytesIO) -> str:
    return io.TextIOWrapper(io.BytesIO(stream.getvalue()), "utf-8").read()


def python(program: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """`python -c PROGRAM` in `folder`."""
    with _ONE_AT_A_TIME, tempfile.TemporaryDirectory() as streams:
        paths = {name: Path(streams) / name for name in ("out", "err")}
        for path in paths.values():
            path.touch()
        request = {
            "program": program,
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
        return subprocess.CompletedProcess(["python", "-c", program], code, out, err)


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
