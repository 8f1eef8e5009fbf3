"""Runs that are killed: Python processes with the writer and the pendulum at hand."""

from __future__ import annotations

import subprocess
import sys
import textwrap

from tests.support import ROOT


def child(code: str, *arguments: str) -> subprocess.Popen:
    """A Python process with the writer and the pendulum at hand."""
    head = """
        import sys, time
        from mbproj.results import writer
        from mbproj.results.crash_safety import check_output
        from mbproj.results.writer import ResultsWriter
        from tests.results.pendulum_blocks import *
        def go(): print("go", flush=True)
    """
    script = textwrap.dedent(head) + textwrap.dedent(code)
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    return subprocess.Popen([sys.executable, "-c", script, *arguments], cwd=ROOT, text=True, **pipes)


WRITE_FOR_EVER = """
    writer.FLUSH_SECONDS = 0.0
    with ResultsWriter(sys.argv[1], scene(), NAMES) as recorder:
        go()
        for i in range(10**9):
            recorder.write(block(times(7) + 0.07 * i))
"""


def killed(code: str, path: object) -> None:
    """Runs `code` until it says "go", and kills it."""
    process = child(code, str(path))
    assert process.stdout.readline() == "go\n"
    process.kill()
    process.wait()
