"""What the streams of a command carry, and how Ctrl-C ends it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from mbproj import open_results, read_scene
from mbproj.results.writer import ResultsWriter
from mbproj.studies.record import Interrupted, record_run
from tests.cli.commands import FIVE_BAR, succeeds
from tests.crossed import some
from tests.support import ROOT

# stdout and stderr: nothing that is shown commands a terminal, every encoding does, a stream may be closed or full.

POSIX = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a POSIX shell")


def shell(line: str, folder, **variables: str) -> subprocess.CompletedProcess[bytes]:
    """A line for bash, in which `mbproj` is ours."""
    program = f"{sys.executable} -c 'from mbproj.commands.main import main; main()'"
    environment = {"PYTHONPATH": str(ROOT), "PATH": os.environ["PATH"], **variables}
    script = f'mbproj() {{ {program} "$@"; }}; {line}'
    return subprocess.run(["bash", "-c", script], capture_output=True, cwd=folder, env=environment, check=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("streams")
    succeeds("run", FIVE_BAR, "--duration", "0.05", "-q", "-o", "a.h5", folder=folder)
    return folder


@POSIX
def test_a_stdout_that_is_full_or_closed_is_said(folder):
    for where, reason in ((">/dev/full", b"No space left on device"), (">&-", b"Bad file descriptor")):
        done = shell(f"mbproj info a.h5 {where}", folder)
        assert (done.returncode, done.stderr) == (3, b"error: cannot write to stdout: " + reason + b"\n")


@POSIX
def test_a_stderr_that_is_full_or_closed_changes_nothing(folder):
    for where in ("2>/dev/full", "2>&-"):
        done = shell(f"mbproj export a.h5 --list {where}; echo $?; mbproj info no.h5 {where}; echo $?", folder)
        assert done.stdout.split()[-2:] == [b"0", b"2"]


@POSIX
def test_with_every_stream_closed_a_run_is_written_whole(folder):
    line = f"mbproj run {FIVE_BAR} --duration 0.05 -o closed.h5"
    done = shell(f"{line} <&- >&- 2>&-; echo $?; mbproj compare-results a.h5 closed.h5 | tail -1", folder)
    assert done.stdout == b"3\nthe same motion\n"


@POSIX
def test_a_reader_that_leaves_ends_neither_the_work_nor_the_exit_code(folder):
    text = (ROOT / "mechanisms" / "five_bar.yaml").read_text()
    (folder / "short.yaml").write_text(text.replace("below: 2.0e-13", "below: 2.0e-99"))
    done = shell("mbproj batch short.yaml short.yaml --junit r.xml | true; echo ${PIPESTATUS[0]}", folder)
    assert done.stdout == b"4\n"
    assert all(line.startswith(b"short.yaml: note: the energy") for line in done.stderr.splitlines())
    assert b'failures="1"' in (folder / "r.xml").read_bytes()


@POSIX
@pytest.mark.parametrize(
    ("encoding", "shown"), some([("latin-1", "|DeltaV|"), ("cp1252", "|DeltaV|"), ("utf-8", "|ΔV|")], 3, 1)
)
def test_every_encoding_can_show_a_summary(folder, encoding, shown):
    line = f"mbproj run {FIVE_BAR} --duration 0.05 -o again.h5"
    done = shell(line, folder, PYTHONIOENCODING=encoding)
    assert (done.returncode, done.stderr) == (0, b"")
    assert shown in done.stdout.decode(encoding)


@pytest.mark.full
@POSIX
def test_titles_paths_and_arguments_command_no_terminal(folder):
    text = (ROOT / "mechanisms" / "five_bar.yaml").read_text()
    lines = text.splitlines()
    at = next(number for number, line in enumerate(lines) if line.startswith("title:"))
    lines[at] = r'title: "\e]0;owned\a\x9b31m\r"'
    (folder / "bad.yaml").write_text("\n".join(lines) + "\n")
    done = shell(
        "mbproj run bad.yaml --duration 0.05 -o bad.h5; mbproj info bad.h5; mbproj info --json bad.h5; "
        "mbproj info $'\\e[31m.h5'; mbproj check bad.yaml --$'\\e[31m'; mbproj new $'\\e[31m'; mbproj check bad.yaml",
        folder,
    )
    assert rb"\u001b]0;owned\u0007\u009b31m\u000d" in done.stdout
    assert rb"\u001b[31m.h5" in done.stderr
    for printed in (done.stdout, done.stderr):
        assert not {0x1B, 0x07, 0x0D} & set(printed)
        assert b"\xc2\x9b" not in printed


@pytest.mark.full
@POSIX
def test_files_whose_names_are_no_text_are_files_like_others(folder):
    shell(f"cp {FIVE_BAR} $'x\\xff.yaml'", folder)
    commands = (
        "run $'x\\xff.yaml' --duration 0.05 -o $'x\\xff.h5' -q",
        "info $'x\\xff.h5'",
        "rerun -q $'x\\xff.h5'",
        "export $'x\\xff.h5' --table diagnostics",
        "run $'x\\xff.yaml' --duration 0.05 --json",
    )
    done = shell("; ".join(f"mbproj {command}; echo $?" for command in commands), folder)
    assert done.stderr == b""
    lines = done.stdout.splitlines()
    assert [line for line in lines if len(line) == 1] == [b"0"] * len(commands)
    assert b"x\xff-diagnostics.csv" in lines, "a program gets the name as it is"


@POSIX
def test_a_pipe_is_read_where_somebody_writes_into_it(folder):
    os.mkfifo(folder / "pipe")
    done = shell(f"mbproj check <(cat {FIVE_BAR}) | tail -1; mbproj check pipe; echo $?", folder)
    assert done.stdout == b"  can run\n2\n"
    assert done.stderr == b"pipe: error: this is a pipe that nobody writes into\n"


# Ctrl-C ends a command with 130 and "interrupted", from its first import to its last byte.

FIVE_BAR_FILE = ROOT / "mechanisms" / "five_bar.yaml"
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
            record_run(read_scene(FIVE_BAR_FILE, {}, {"duration": "0.05"}), tmp_path / "out.h5")
    finally:
        signal.signal(signal.SIGINT, before)
    assert caught.value.output == tmp_path / "out.h5"
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.h5"]
    with open_results(tmp_path / "out.h5") as results:
        at_start = moment == "__enter__"  # the signal ends it at its first look
        assert results.status == ("interrupted" if at_start else "complete")
        assert len(results.time) == 6


def test_the_part_of_a_run_says_that_it_is_being_written(tmp_path):
    scene = read_scene(FIVE_BAR_FILE, {}, {"duration": "0.05"})
    path: Path = tmp_path / "out.h5"
    seen: list[str] = []

    def look(time: float) -> None:
        with open_results(path) as results:
            seen.append(results.status)

    record_run(scene, path, progress=look)
    assert set(seen) == {"running"}
