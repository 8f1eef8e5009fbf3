"""`mbproj stability` as a user meets it: table, figure, CSV, --json, interruption, bad input."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
import time

import pytest

from tests.cli.commands import SLIDER_CRANK, kept, mbproj
from tests.studies.scenes import write
from tests.support import ROOT

FEW = ("--points", "5", "--duration", "1")


def test_table_figure_and_csv(tmp_path, undrawn):
    options = (*FEW, "--projections", "none,gpopm", "--from", "0.001", "--to", "0.02", "-o", "out")
    done = mbproj("stability", SLIDER_CRANK, "--vary", "step", *options, folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0] == "Spatial slider-crank (Zhang, Liu & Liu 2015, sect. 5.2): step (s); its own 0.01; rk4, 1 s"
    assert lines[2].split() == ["method", "from", "to", "state", "first", "bad"]
    assert [line.split()[0] for line in lines if line.startswith(("none", "gpopm"))] == ["none", "gpopm"]
    stem = "out/spatial_slider_crank-stability-step"
    assert lines[-2:] == [f"{stem}.csv", f"{stem}.png"]
    assert (tmp_path / lines[-1]).exists()
    with (tmp_path / lines[-2]).open() as file:
        rows = list(csv.DictReader(file))
    assert {row["projection"] for row in rows} == {"none", "gpopm"}
    assert all(float(row["open_by"]) < 2e-12 for row in rows if row["projection"] == "gpopm")
    again = mbproj("stability", SLIDER_CRANK, "--vary", "step", *options, folder=tmp_path)
    assert again.stdout == done.stdout
    other = mbproj("stability", SLIDER_CRANK, "--vary", "step", *options, "--points", "6", folder=tmp_path)
    assert (other.returncode, other.stdout == done.stdout) == (0, False)  # another study, with values of its own


def test_json_of_baumgartes_limit(tmp_path, undrawn):
    path = write(tmp_path, "slow", "", "step: 0.01", "step: 1e-4")
    done = mbproj("stability", str(path), "--vary", "baumgarte-gain", "--points", "6", "--json", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    found = json.loads(done.stdout)
    (change,) = found["methods"]["baumgarte"]["limits"]
    assert change["value"] == pytest.approx(found["analytic"], rel=0.02)
    assert found["analytic"] == pytest.approx(27853, abs=1)
    table = mbproj("stability", str(path), "--vary", "baumgarte-gain", "--points", "6", folder=tmp_path)
    assert "theory: α h = 2.785, the real stability limit of rk4" in table.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--vary", "stiffness"), "--vary: error: no force of the scene has a 'stiffness' to vary; add a spring"),
        (("--vary", "sped"), "--vary: error: unknown quantity 'sped'; did you mean 'speed'"),
        (("--vary", "penalty", "--projections", "gopm"), "'gopm' has no 'alpha' to vary"),
        (("--vary", "step", "--projection", "gopm"), "'--projections'"),
        (("--vary", "step", "--from", "-1"), "--from"),
        (("--vary", "step", "--from", "x"), "--from"),
        ((), "Missing option '--vary'"),
    ],
)
def test_bad_input(tmp_path, arguments, said):
    done = mbproj("stability", str(ROOT / "mechanisms" / "five_bar.yaml"), *arguments, folder=tmp_path)
    assert (done.returncode, done.stdout, "Traceback" in done.stderr) == (2, "", False)
    assert said in done.stderr


@pytest.mark.full
def test_an_interrupted_map_resumes(tmp_path):
    """After Ctrl-C what was done is kept, and the study begins where it stopped."""
    program = [
        sys.executable,
        "-c",
        "from mbproj.commands.main import main; main()",
        "stability",
        SLIDER_CRANK,
        "--vary",
        "step",
    ]
    environment = {"PYTHONPATH": str(ROOT), "MBPROJ_CACHE": str(tmp_path / "cache")}
    running = subprocess.Popen(program, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120.0
    while not kept(tmp_path / "cache") and time.monotonic() < deadline:
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=30)
    assert (running.returncode, said.splitlines()[-1]) == (130, "interrupted")
    assert kept(tmp_path / "cache")[0] in ("none", "baumgarte", "gopm", "gpopm")
