"""Ctrl-C ends a command with 130 and "interrupted", from its first import to its last byte."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from mbproj import open_results, read_scene
from mbproj.results.writer import ResultsWriter
from mbproj.studies.record import Interrupted, record_run
from tests.support import ROOT

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"
#: The command `--version`, with a Ctrl-C where its imports come to click, or where Python itself ends.
HEAD = """
    import atexit, signal, sys
    from mbproj.__main__ import main
    signal.signal(signal.SIGINT, signal.default_int_handler)  # Python has none where its parent ignores SIGINT
    sys.argv = ["mbproj", "--version"]
"""
IN_IMPORTS = """
    class AtClick:
        def find_spec(name, path, target=None):
            if name == "click":
                signal.raise_signal(signal.SIGINT)
    sys.meta_path.insert(0, AtClick)
    main()
"""
AT_THE_END = """
    atexit.register(signal.raise_signal, signal.SIGINT)
    main()
"""


@pytest.mark.parametrize(("where", "code", "said"), [(IN_IMPORTS, 130, "interrupted\n"), (AT_THE_END, 0, "")])
def test_imports_are_interrupted_and_the_end_is_not(where, code, said):
    command = [sys.executable, "-c", textwrap.dedent(HEAD + where)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (code, said)


@pytest.mark.parametrize("moment", ["__enter__", "_finish", "_close"])
def test_a_file_is_made_and_closed_before_a_signal_ends_the_run(tmp_path, monkeypatch, moment):
    """An exception in the middle of it would leave the samples in OUT.part, without their end."""
    ready = getattr(ResultsWriter, moment)

    def signalled(writer: ResultsWriter, *arguments: object) -> object:
        signal.raise_signal(signal.SIGINT)
        return ready(writer, *arguments)

    monkeypatch.setattr(ResultsWriter, moment, signalled)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(Interrupted) as caught:
            record_run(read_scene(FIVE_BAR, {}, {"duration": "0.05"}), tmp_path / "out.h5")
    finally:
        signal.signal(signal.SIGINT, before)
    assert caught.value.output == tmp_path / "out.h5"
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.h5"]
    with open_results(tmp_path / "out.h5") as results:
        at_start = moment == "__enter__"  # the signal ends it at its first look
        assert results.status == ("interrupted" if at_start else "complete")
        assert len(results.time) == 6


def test_the_part_of_a_run_says_that_it_is_being_written(tmp_path):
    scene = read_scene(FIVE_BAR, {}, {"duration": "0.05"})
    path: Path = tmp_path / "out.h5"
    seen: list[str] = []

    def look(time: float) -> None:
        with open_results(path) as results:
            seen.append(results.status)

    record_run(scene, path, progress=look)
    assert set(seen) == {"running"}
