"""`mbproj compare`, `tradeoff` and `threshold` as a user meets them."""

from __future__ import annotations

import csv
import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from mbproj.cli.main import STUDIES
from tests.cli.commands import SLIDER_CRANK, kept, mbproj
from tests.cli.examples import named
from tests.support import ROOT

PENDULUM = str(ROOT / "mechanisms" / "physical_pendulum.yaml")
SMALL = (
    "--projections",
    "gpopm,none",
    "--integrators",
    "dop853",
    "--until",
    "0.05",
    "--longest",
    "0.002",
    "--repeat",
    "1",
)


def test_compare(tmp_path):
    options = ("--projections", "none,gpopm", "--until", "0.2", "--repeat", "1", "-o", "out")
    done = mbproj("compare", SLIDER_CRANK, *options, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line.split()[0] for line in lines[1:3]] == ["none", "gpopm"]
    assert lines[3:] == ["out/spatial_slider_crank-compare.csv", "out/spatial_slider_crank-compare.png"]
    assert done.stderr.startswith("note: reference: dopri5, fixed steps of ")
    with (tmp_path / lines[3]).open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[1]["position_violation"]) <= 1e-13
    assert (tmp_path / lines[4]).stat().st_size > 50_000
    as_json = mbproj("compare", PENDULUM, "--until", "0.1", "--repeat", "1", "--json", folder=tmp_path)
    assert [entry["label"] for entry in _strict(as_json.stdout)["entries"]] == ["none", "baumgarte", "gopm", "gpopm"]


@pytest.mark.full
def test_json_of_a_comparison_with_runs_that_fail_is_json(tmp_path):
    """A failed run has no error and no drift: null, since JSON knows neither NaN nor infinity."""
    options = ("--projections", "none", "--steps", "0.01,1", "--until", "2", "--repeat", "1", "--json")
    done = mbproj("compare", SLIDER_CRANK, *options, "--write-table", "t.tex", folder=tmp_path)
    found = _strict(done.stdout)
    (failed,) = (entry for entry in found["entries"] if entry["failure"])
    assert failed["error"] is failed["energy_drift"] is None
    assert found["files"][-1] == "t.tex"
    (tmp_path / "t.tex").read_text(encoding="utf-8").encode("latin-1")  # what LaTeX's fonts for text have


@pytest.mark.parametrize("study", sorted(STUDIES - {"paper"}))
def test_every_study_resumes_or_is_quick_and_writes_json_tables_for_a_paper_and_a_figure(study):
    command, _ = named(study)
    known = {name for option in command.params for name in option.opts}
    assert {"--json", "--quiet", "--write-table", "--force", "--size"} <= known
    assert known & {"--plot", "--format"}
    assert study == "verify" or {"--fresh", "--jobs", "--scheduler"} <= known


@pytest.mark.full
def test_tradeoff_again_is_the_same(tmp_path):
    first, again = (mbproj("tradeoff", PENDULUM, *SMALL, folder=tmp_path) for _ in range(2))
    assert first.returncode == 0, first.stderr
    assert first.stdout == again.stdout
    assert "the cheapest setting for an error:" in first.stdout
    assert first.stdout.splitlines()[-3:] == [f"physical_pendulum-tradeoff.{ending}" for ending in ("csv", "h5", "png")]
    found = _strict(mbproj("tradeoff", PENDULUM, *SMALL, "--json", "--write-table", "t.md", folder=tmp_path).stdout)
    assert [found["trials"][index]["on_front"] for index in found["front"]] == [True] * len(found["front"])
    assert (tmp_path / "t.md").read_text(encoding="utf-8").count("\n") == len(found["trials"]) + 4
    fresh = mbproj("tradeoff", PENDULUM, *SMALL, "--fresh", folder=tmp_path)
    assert fresh.returncode == 0, fresh.stderr
    assert fresh.stdout != first.stdout  # its times are new


def test_what_stands_in_the_store_s_place_costs_a_line_and_no_study(tmp_path, undrawn):
    """Garbage in the file, and a file in place of the folder: a note each, and the same tables."""
    options = ("compare", PENDULUM, "--projections", "gpopm", "--until", "0.05", "--repeat", "1", "--json")
    (tmp_path / "cache" / "studies").mkdir(parents=True)
    (tmp_path / "cache" / "studies" / "store.sqlite3").write_text('{"key": 1}\ngarbage\n')
    first = mbproj(*options, folder=tmp_path)
    assert (first.returncode, first.stderr.count("\n")) == (0, 1)
    assert "is not what mbproj has kept there (file is not a database): it is now 'store.aside'" in first.stderr
    shutil.rmtree(tmp_path / "cache")
    (tmp_path / "cache").write_text("a file")
    again = mbproj(*options, folder=tmp_path)
    assert (again.returncode, again.stderr.count("\n")) == (0, 1)
    assert again.stderr.startswith("note: results of studies are not stored: [Errno ")
    errors = [json.loads(done.stdout)["entries"][0]["error"] for done in (first, again)]
    assert errors[0] == errors[1]


def test_threshold(tmp_path, undrawn):
    done = mbproj("threshold", SLIDER_CRANK, "--duration", "0.4", "--repeat", "1", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "* recommended: --threshold " in done.stdout
    assert (tmp_path / "spatial_slider_crank-threshold.png").exists()
    again = mbproj("threshold", SLIDER_CRANK, "--duration", "0.4", "--repeat", "1", "--json", folder=tmp_path)
    found = _strict(again.stdout)
    assert [row["recommended"] for row in found["trials"]].index(True) == found["recommended"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("compare", PENDULUM, "--projections", "gpom"), "unknown projection method 'gpom'; did you mean 'gpopm'"),
        (("compare", PENDULUM, "--steps", "0.01,x"), "--steps: error: "),
        (("compare", PENDULUM, "--steps", "0.3,0.7", "--until", "2"), "the steps do not meet before 2.1 s"),
        (("compare", PENDULUM, "--tolerances", "1e-6"), "--tolerances: error: rk4: no error estimate, which"),
        (("tradeoff", PENDULUM, "--at", "ende"), "there is no 'ende' among the markers; did you mean 'end'"),
        (("tradeoff", PENDULUM, "--integrators", "rk5"), "unknown integrator 'rk5'"),
        (("threshold", PENDULUM, "--projection", "none"), "'none' makes no projections"),
        (("tradeoff", "nothing.yaml"), "nothing.yaml"),
    ],
)
def test_bad_input(tmp_path, arguments, said):
    done = mbproj(*arguments, folder=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.full
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
def test_an_interrupted_study_leaves_no_process_and_resumes(tmp_path):
    program = [sys.executable, "-c", "from mbproj.cli import main; main()", "tradeoff", SLIDER_CRANK, "--until", "1"]
    environment = {"PYTHONPATH": str(ROOT), "MBPROJ_CACHE": str(tmp_path / "cache")}
    running = subprocess.Popen(program, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120.0
    while not any(name.startswith("sweep") for name in kept(tmp_path / "cache")) and time.monotonic() < deadline:
        time.sleep(0.05)
    children = {pid for pid in _processes() if _parent(pid) == running.pid}
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=30)
    assert running.returncode == 130
    assert said.splitlines()[-1] == "interrupted"
    assert "Traceback" not in said
    assert children
    assert not any(_parent(pid) is not None for pid in children)
    assert any(name.startswith("sweep") for name in kept(tmp_path / "cache"))


def _strict(text: str) -> dict[str, Any]:
    """An object of JSON without NaN and infinity."""
    return json.loads(text, parse_constant=lambda name: pytest.fail(name))


def _processes() -> list[int]:
    """All of them that can be seen."""
    return [int(place.name) for place in Path("/proc").iterdir() if place.name.isdigit()]


def _parent(pid: int) -> int | None:
    """The parent of a process that is there."""
    try:
        return int(Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[1])
    except OSError:
        return None
