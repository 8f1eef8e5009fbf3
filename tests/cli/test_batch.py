"""`mbproj batch` as a pipeline sees it: exit codes, the table, JUnit's XML, JSON, and what Ctrl-C leaves."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree
from xml.etree import ElementTree as Xml

import h5py
import pytest

from mbproj.base.errors import ExitCode
from mbproj.commands.report.junit import junit
from mbproj.kernel import core
from mbproj.results.file.checksums import stamp_attributes
from mbproj.studies.batch import SceneResult
from tests.cli.commands import mbproj
from tests.crossed import full
from tests.studies.scenes import HOLDS, SHORT, failing, hanging, write, wrong
from tests.support import ROOT

#: What the pendulum runs in here.
PLANAR = "full" if core() is None else "planar"


def test_table_messages_and_exit_code(tmp_path: Path) -> None:
    for name, expect in (("a", HOLDS), ("b", SHORT + HOLDS), ("c", "")):
        write(tmp_path, name, expect)
    done = mbproj("batch", ".", folder=tmp_path)
    words = [" ".join(line.split()) for line in done.stdout.splitlines()]
    assert words[0] == "scene result hold time error against what is allowed"
    assert words[1].startswith("a.yaml holds 1 of 1 ")
    assert words[1].endswith(" falls: -0.07 ≤ -0.001 m")
    assert words[2].startswith("b.yaml falls short 1 of 2 ")
    assert words[2].endswith(" rises: -0.07, not ≥ 0.001 m")
    assert words[3].startswith("c.yaml ran ")
    assert words[4].endswith("1 as expected, 1 short of it, 0 failed, 1 without expectations; 2 of 3 expectations hold")
    assert (done.returncode, done.stderr) == (4, "")
    assert not list(tmp_path.glob("*.h5*"))


@pytest.mark.full
def test_what_is_complete_is_not_run_again(tmp_path: Path) -> None:
    """But checked: against what the scene expects now. A scene that has changed, or a damaged file, runs again, and so
    does what other code has made. All run again with --fresh."""
    for name in ("a", "b", "c"):
        write(tmp_path, name, HOLDS)

    def batch(*more: str) -> dict[str, tuple[str, int]]:
        done = mbproj("batch", ".", "--keep", "kept", *more, "--json", folder=tmp_path)
        kept = {path.stem: path.stat().st_mtime_ns for path in (tmp_path / "kept").glob("*.h5")}
        scenes = json.loads(done.stdout)["scenes"]
        return {Path(each["scene"]).stem: (each["result"], kept[Path(each["scene"]).stem]) for each in scenes}

    first = batch()
    assert batch() == first
    with h5py.File(tmp_path / "kept" / "a.h5", "r+") as file:
        file.attrs["follows_from"] = "other code"
        stamp_attributes(file)
    changed = batch()
    assert [changed[name][1] > first[name][1] for name in "abc"] == [True, False, False]
    first = changed
    write(tmp_path, "b", HOLDS + SHORT)
    damaged = bytearray((tmp_path / "kept" / "c.h5").read_bytes())
    damaged[len(damaged) // 2] ^= 255
    (tmp_path / "kept" / "c.h5").write_bytes(damaged)
    again = batch()
    assert again["a"] == first["a"]
    assert again["b"][0] == "falls short"
    assert all(again[name][1] > first[name][1] for name in ("b", "c"))
    fresh = batch("--fresh")
    assert all(fresh[name][1] > again[name][1] for name in "abc")
    earlier = mbproj("batch", ".", "--resume", folder=tmp_path)
    assert (earlier.returncode, "No such option '--resume'; give --keep" in earlier.stderr) == (2, True)


def test_it_draws_how_much_of_the_allowed_errors_is_used(tmp_path: Path) -> None:
    write(tmp_path / "some", "a", HOLDS + SHORT)
    write(tmp_path / "none", "b")
    done = mbproj("batch", "some", "none", "--plot", "shares.svg", "--size", "120", folder=tmp_path)
    assert (done.returncode, done.stderr) == (4, "shares.svg\n")
    assert (tmp_path / "shares.svg").read_text(encoding="utf-8").startswith("<?xml")
    done = mbproj("batch", "some", "--plot", "shares.svg", "--write-table", "t.md", "--json", folder=tmp_path)
    assert json.loads(done.stdout)["files"] == ["shares.svg", "t.md"]
    done = mbproj("batch", "none", "--plot", "no.png", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "note: no expectation to draw\n")
    assert mbproj("batch", "none", "--plot", "no.gif", folder=tmp_path).returncode == 2


@pytest.mark.parametrize(
    ("make", "message"),
    [(wrong, "error: unknown key 'mas'; did you mean 'mass'?"), (failing, "failing.yaml: stopped at t = ")],
)
def test_a_scene_that_cannot_run_goes_before_one_that_falls_short(
    tmp_path: Path, make: Callable[[Path], Path], message: str
) -> None:
    make(tmp_path)
    write(tmp_path, "short", SHORT)
    done = mbproj("batch", ".", "--jobs", "1", folder=tmp_path)
    assert done.returncode == 3
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_junit_xml(tmp_path: Path) -> None:
    write(tmp_path / "d", "a", HOLDS + SHORT)
    failing(tmp_path / "d", "b")
    done = mbproj("batch", "d", "--junit", "report.xml", folder=tmp_path)
    assert done.returncode == 3
    root = ElementTree.parse(tmp_path / "report.xml").getroot()
    assert (root.tag, root.get("tests"), root.get("failures"), root.get("errors")) == ("testsuites", "4", "1", "1")
    first, second = root
    assert [suite.get("name") for suite in root] == ["d/a.yaml", "d/b.yaml"]
    counts = [[suite.get(key) for key in ("tests", "failures", "errors", "skipped")] for suite in root]
    assert counts == [["3", "1", "0", "0"], ["1", "0", "1", "0"]]
    cases = [(case.get("classname"), case.get("name"), [child.tag for child in case]) for case in root.iter("testcase")]
    assert cases == [
        ("d.a", "runs", []),
        ("d.a", "falls", []),
        ("d.a", "rises", ["failure"]),
        ("d.b", "runs", ["error"]),
    ]
    ran_in = [[(item.get("name"), item.get("value")) for item in suite.iter("property")] for suite in root]
    assert ran_in == [[("formulation", PLANAR)]] * 2  # the one that failed, too
    failure = first.find("testcase/failure")
    assert failure is not None
    assert failure.get("message") == "-0.07, not ≥ 0.001 m"
    assert "marker end, position z at 0.1 s\nexpected: ≥ 0.001 m\nfound: -0.070" in (failure.text or "")
    error = second.find("testcase/error")
    assert error is not None
    assert (error.get("message") or "").startswith("stopped at t = ")
    assert all(float(case.get("time", "nan")) >= 0.0 for case in root.iter("testcase"))


#: What the schema of Jenkins' xUnit plugin (junit-10.xsd) lets each element have of what is written.
SCHEMA = {
    "testsuites": {"name", "time", "tests", "failures", "errors"},
    "testsuite": {"name", "tests", "failures", "errors", "time", "skipped", "timestamp"},
    "testcase": {"name", "time", "classname", "file"},
    "properties": set(),
    "property": {"name", "value"},
    "failure": {"type", "message"},
    "error": {"type", "message"},
    "skipped": {"type", "message"},
}


def test_the_xml_has_nothing_that_schemas_do_not_know(tmp_path: Path) -> None:
    write(tmp_path, "a", HOLDS + SHORT)
    wrong(tmp_path, "b")
    mbproj("batch", ".", "--junit", "report.xml", folder=tmp_path)
    root = ElementTree.parse(tmp_path / "report.xml").getroot()
    assert {element.tag for element in root.iter()} == set(SCHEMA) - {"skipped"}
    for element in root.iter():
        assert set(element.keys()) <= SCHEMA[element.tag], element.tag


def test_a_pattern_that_the_shell_does_not_look_up(tmp_path: Path) -> None:
    write(tmp_path, "a", HOLDS)
    write(tmp_path / "d" / "e", "b", HOLDS)
    done = mbproj("batch", "**/*.yaml", folder=tmp_path)
    assert [line.split()[0] for line in done.stdout.splitlines()[1:-1]] == ["a.yaml", "d/e/b.yaml"]
    none = mbproj("batch", "**/*.yml", folder=tmp_path)
    assert (none.returncode, none.stdout, none.stderr) == (
        2,
        "",
        "error: no file matches '**/*.yml'; give scene files, or directories of them\n",
    )


def test_json_and_kept_results(tmp_path: Path) -> None:
    write(tmp_path, "a", HOLDS)
    done = mbproj("batch", "a.yaml", "--json", "--keep", "out/results", folder=tmp_path)
    found = json.loads(done.stdout)
    assert (found["exit_code"], found["hold"], found["not_run"]) == (0, 1, [])
    (scene,) = found["scenes"]
    assert (scene["result"], scene["output"], scene["formulation"]) == ("holds", "out/results/a.h5", PLANAR)
    (expectation,) = scene["expectations"]
    assert (expectation["name"], expectation["holds"], expectation["below"]) == ("falls", True, -0.001)
    assert expectation["measured"] == pytest.approx(-0.5 * (0.5 * 9.81 / 0.35) * 0.1**2, abs=1e-4)
    assert mbproj("info", "out/results/a.h5", folder=tmp_path).returncode == 0


def test_bad_options_are_refused_before_anything_runs(tmp_path: Path) -> None:
    write(tmp_path, "a")
    (tmp_path / "taken").touch()
    for options, message in (
        (["nowhere"], "error: there is no 'nowhere'; give scene files, or directories of them\n"),
        (["a.yaml", "--timeout", "1e300"], "--timeout: error: '--timeout' must be at most 1e+09, found 1e+300\n"),
        (["x" * 5000], f"error: '{'x' * 5000}': File name too long; give another path\n"),
        (["a.yaml", "--timeout", "3 m"], "--timeout: error: '--timeout' is in s, this is a length, in m\n"),
        (
            ["a.yaml", "--junit", "no/x.xml"],
            "error: the directory 'no' of 'no/x.xml' does not exist; create it, or choose another file with --junit\n",
        ),
        (
            ["a.yaml", "--keep", "taken"],
            "error: cannot make the directory 'taken': File exists; choose another directory\n",
        ),
    ):
        done = mbproj("batch", *options, folder=tmp_path)
        assert (done.returncode, done.stderr) == (2, message)
        assert "a.yaml  " not in done.stdout


def children(pid: int) -> list[int]:
    """Those that any thread of the process has started."""
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    return [int(child) for each in tasks for child in each.read_text().split()]


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().split(")")[1].split()[0] != "Z"
    except OSError:
        return False


def wait_for(condition: object, seconds: float = 30.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():  # type: ignore[operator]
            return True
        time.sleep(0.05)
    return False


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize(
    "number", [signal.SIGINT, full(signal.SIGTERM), full(signal.SIGKILL)], ids=["int", "term", "kill"]
)
def test_no_process_is_left_behind(tmp_path: Path, number: signal.Signals) -> None:
    """Ctrl-C, a pipeline that is cancelled, or a kill: what was done is reported, but for the last."""
    write(tmp_path, "a", HOLDS)
    hanging(tmp_path, "b")
    program = [
        sys.executable,
        "-c",
        "from mbproj.commands.main import main; main()",
        "batch",
        ".",
        "--junit",
        "r.xml",
        "-j",
        "1",
    ]
    run = subprocess.Popen(
        program,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert run.stdout is not None
    lines = [run.stdout.readline() for _ in range(2)]
    assert lines[1].startswith("a.yaml  holds")
    processes = children(run.pid)
    assert processes
    run.send_signal(number)
    output, errors = run.communicate(timeout=60)
    assert wait_for(lambda: not any(alive(process) for process in processes))
    if number == signal.SIGKILL:
        return
    assert run.returncode == 130
    assert output.splitlines()[0].split() == ["b.yaml", "not", "run"]
    assert errors == "interrupted\n"
    suites = ElementTree.parse(tmp_path / "r.xml").getroot()
    assert [(suite.get("name"), suite.get("skipped")) for suite in suites] == [("a.yaml", "0"), ("b.yaml", "1")]
    assert [child.tag for case in suites[1] for child in case] == ["skipped"]


# JUnit's XML is XML, whatever a path or a message holds.


def test_what_xml_cannot_say_and_what_commands_a_terminal_can_be_read():
    scene, message = Path("a\x1b[31m\udcff.yaml"), "\x1b]0;t\x07 \ufffe <&>\nsecond"
    text = junit([SceneResult(scene, ExitCode.FAILED, message, (), 1.0)], [Path("b\x00\x7f.yaml")])
    root = Xml.fromstring(text.encode())
    assert root[0].get("name") == "a\\u001b[31m?.yaml"
    error = root[0][0].find("error")
    assert error is not None and error.get("message") == "\\u001b]0;t\\u0007 ? <&>"
    assert error.text == "\\u001b]0;t\\u0007 ? <&>\nsecond"
    assert root[1].get("name") == "b\\u0000\\u007f.yaml"
