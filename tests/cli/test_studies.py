"""`mbproj compare`, `tradeoff`, `threshold`, `stability`, `verify`, `fit`, `optimise` and `sensitivity` as a user meets
them."""

from __future__ import annotations

import csv
import json
import shutil
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbproj import open_results
from tests.cli.commands import FIVE_BAR, SLIDER_CRANK, begun, kept, mbproj, succeeds
from tests.cli.examples import named
from tests.studies.design.scenes import BALL, table, written
from tests.studies.scenes import write
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
    done = succeeds("compare", SLIDER_CRANK, *options, folder=tmp_path)
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


@pytest.mark.parametrize(
    "study", ["batch", "compare", "recommend", "stability", "sweep", "threshold", "tradeoff", "verify"]
)
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
    fresh = succeeds("tradeoff", PENDULUM, *SMALL, "--fresh", folder=tmp_path)
    assert fresh.stdout != first.stdout  # its times are new


def test_what_stands_in_the_store_s_place_costs_a_line_and_no_study(tmp_path, undrawn):
    """Garbage in the file, and a file in place of the folder: a note each, and the same tables."""
    options = ("compare", PENDULUM, "--projections", "gpopm", "--until", "0.05", "--repeat", "1", "--json")
    (tmp_path / "cache" / "studies").mkdir(parents=True)
    (tmp_path / "cache" / "studies" / "store.sqlite3").write_text('{"key": 1}\ngarbage\n')
    first = mbproj(*options, folder=tmp_path)
    assert (first.returncode, first.stderr.count("\n")) == (0, 1)
    assert "is not as mbproj has written it (file is not a database): it is now 'store.aside'" in first.stderr
    shutil.rmtree(tmp_path / "cache")
    (tmp_path / "cache").write_text("a file")
    again = mbproj(*options, folder=tmp_path)
    assert (again.returncode, again.stderr.count("\n")) == (0, 1)
    assert again.stderr.startswith("note: results of studies are not stored: [Errno ")
    errors = [json.loads(done.stdout)["entries"][0]["error"] for done in (first, again)]
    assert errors[0] == errors[1]


def test_threshold(tmp_path, undrawn):
    done = succeeds("threshold", SLIDER_CRANK, "--duration", "0.4", "--repeat", "1", folder=tmp_path)
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
    of_sweeps = lambda: any(name.startswith("sweep") for name in kept(tmp_path / "cache"))  # noqa: E731
    running = begun("tradeoff", SLIDER_CRANK, "--until", "1", folder=tmp_path, when=of_sweeps)
    children = {pid for pid in _processes() if _parent(pid) == running.pid}
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=30)
    assert running.returncode == 130
    assert said.splitlines()[-1] == "interrupted"
    assert "Traceback" not in said
    assert children
    assert not any(_parent(pid) is not None for pid in children)
    assert of_sweeps()


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


# `mbproj stability` as a user meets it: table, figure, CSV, --json, interruption, bad input.

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
def test_bad_input_of_stability(tmp_path, arguments, said):
    done = mbproj("stability", str(ROOT / "mechanisms" / "five_bar.yaml"), *arguments, folder=tmp_path)
    assert (done.returncode, done.stdout, "Traceback" in done.stderr) == (2, "", False)
    assert said in done.stderr


@pytest.mark.full
def test_an_interrupted_map_resumes(tmp_path):
    """After Ctrl-C what was done is kept, and the study begins where it stopped."""
    arguments = ("stability", SLIDER_CRANK, "--vary", "step")
    running = begun(*arguments, folder=tmp_path, when=lambda: kept(tmp_path / "cache"))
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=30)
    assert (running.returncode, said.splitlines()[-1]) == (130, "interrupted")
    assert kept(tmp_path / "cache")[0] in ("none", "baumgarte", "gopm", "gpopm")


# `mbproj verify` as a user meets it: the table, --json, --store, exit codes.


@pytest.mark.full
def test_the_table(tmp_path):
    done = mbproj("verify", FIVE_BAR, folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0].startswith("Five-bar pendulum")
    assert lines[1].split() == ["check", "what", "must", "hold", "measured", "allowed"]
    assert lines[-1] == "  19 hold, 1 do not apply, 0 fail; runs take the planar formulation"
    assert max(map(len, lines)) < 200
    done = mbproj("verify", FIVE_BAR, "--json", "--plot", "checks.svg", "--write-table", "checks.md", folder=tmp_path)
    assert json.loads(done.stdout)["files"] == ["checks.svg", "checks.md"]
    drawn = (tmp_path / "checks.svg").read_text(encoding="utf-8")
    assert "orthogonal" in drawn
    assert "turns" not in drawn  # the check that does not apply


def test_a_failing_check_ends_with_4(tmp_path):
    """With a loose stop test the joints are not closed to what the scene's own tolerance asks for after one pass."""
    path = write(tmp_path, "loose")
    options = ("--projection-tolerance", "1e-30", "--max-iterations", "1")
    done = mbproj("verify", str(path), *options, "--json", folder=tmp_path)
    found = json.loads(done.stdout)
    assert (done.returncode, found["holds"]) == (4, False)
    (closed,) = (check for check in found["checks"] if check["verdict"] == "failed")
    assert closed["name"] == "closed"
    assert closed["measured"] > closed["allowed"] == 1e-30
    table = mbproj("verify", str(path), *options, folder=tmp_path)
    assert (table.returncode, "FAILS; m or rad, " in table.stdout) == (4, True)


def test_stored_with_the_results_and_shown_by_info(tmp_path):
    path = write(tmp_path, "swing")
    succeeds("run", str(path), "-q", folder=tmp_path)
    before = mbproj("info", "results.h5", folder=tmp_path).stdout
    assert "\nverification\n" not in before
    for _ in range(2):  # the second takes the place of the first
        done = mbproj("verify", str(path), "--store", "results.h5", folder=tmp_path)
        assert (done.returncode, done.stderr) == (0, "stored in results.h5\n")
    info = mbproj("info", "results.h5", folder=tmp_path).stdout
    assert "\n".join(done.stdout.splitlines()[1:]) in info
    assert json.loads(mbproj("info", "results.h5", "--json", folder=tmp_path).stdout)["verification"]["holds"] is True
    with open_results(tmp_path / "results.h5") as results:
        found = results.verification
        assert found is not None
        assert len(found.checks) == 20
        assert len(results.time) == 21
    assert sorted(each.name for each in tmp_path.glob("results*")) == ["results.h5"]
    succeeds("rerun", "results.h5", "-o", "again.h5", "-q", folder=tmp_path)


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("missing.h5", "cannot store in 'missing.h5': there is none yet; mbproj run SCENE -o missing.h5"),
        ("text.h5", "'text.h5' is not a results file of mbproj"),
        ("other.h5", "'other.h5' holds results of another scene, or of other parameters"),
    ],
)
def test_what_cannot_be_stored_is_said_before_anything_is_computed(tmp_path, file, said):
    (tmp_path / "text.h5").write_text("not HDF5")
    other = write(tmp_path, "other", "", "mass: 1", "mass: 2")
    assert mbproj("run", str(other), "-q", "-o", "other.h5", folder=tmp_path).returncode == 0
    done = mbproj("verify", str(write(tmp_path, "swing")), "--store", file, folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert done.stderr.startswith("--store: error: ")


def test_a_scene_that_cannot_run_is_refused_as_by_run(tmp_path):
    path = write(tmp_path, "light", "", "mass: 1, inertia: [0.1, 0.1, 0.1]", "mass: 0, inertia: [0, 0, 0]")
    for command in ("run", "verify"):
        done = mbproj(command, str(path), folder=tmp_path)
        assert (done.returncode, done.stdout, "Traceback" in done.stderr) == (2, "", False)
        assert "the joints leave a motion that moves no mass" in done.stderr


# `mbproj fit`, `optimise` and `sensitivity` on the command line: what they print and write, and their exit codes.

FAR = "maximise: {far: {body: ball, quantity: position, component: x, at: end}}\n"
VARY = "vary: {parameters.angle: [0.1, 1.5]}\nstarts: 1\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("MBPROJ_CACHE", str(tmp_path / "cache"))
    times = np.linspace(0.0, 1.0, 11)
    table(tmp_path / "flight.csv", time__s=times, position_x__m=10.0 * np.cos(0.5) * times)
    return tmp_path


def test_fit_prints_writes_and_goes_on(folder, undrawn):
    written(folder, BALL, VARY + "match: {flight: {body: ball, through: flight.csv}}\n")
    first = succeeds("fit", "design.yaml", "-j", "1", folder=folder)
    assert "least_squares, because all that is wanted are residuals" in first.stdout
    assert "flight: 11 points, off by " in first.stdout
    assert {path.name for path in (folder / "design-design").iterdir()} == {
        *("best.yaml", "starts.csv", "design.json", "design.png")
    }
    again = json.loads(mbproj("fit", "design.yaml", "-j", "1", "--json", folder=folder).stdout)
    assert again["reused"] == 1
    assert again["numbers"]["parameters.angle"]["value"] == pytest.approx(0.5, rel=1e-9)


@pytest.mark.full
def test_a_design_is_drawn_again_from_its_folder(folder):
    written(folder, BALL, VARY + "match: {flight: {body: ball, through: flight.csv}}\n")
    assert mbproj("fit", "design.yaml", "-j", "1", "-q", folder=folder).returncode == 0
    done = succeeds("plot", "design-design", "-o", "pictures", "--format", "svg", folder=folder)
    names = [f"design-design-{kind}.svg" for kind in ("fit", "convergence", "correlation")]
    assert [line.rpartition("/")[2] for line in done.stdout.split()] == names
    assert "flight" in (folder / "pictures" / names[0]).read_text()
    for options, said in (
        (("--kind", "front"), "--kind front: the design has one goal alone"),
        (("--kind", "heat"), "unknown kind 'heat' of a design"),
        (("--marker", "tip"), "--marker is for results of runs"),
    ):
        wrong = mbproj("plot", "design-design", *options, folder=folder)
        assert (wrong.returncode, said in wrong.stderr) == (2, True), wrong.stderr
    (folder / "design-design" / "design.json").write_text('{"format": "mbproj design 1", "matches": 3}')
    damaged = mbproj("plot", "design-design", folder=folder)
    assert damaged.returncode == 2
    assert "design.json: error: it is not what mbproj wrote of a design" in damaged.stderr


def test_a_constraint_that_is_not_kept_is_exit_code_3(folder):
    limit = "subject_to: {high: {body: ball, quantity: position, component: z, at: end, at_least: 100 m}}\n"
    written(folder, BALL, VARY + FAR + limit)
    done = mbproj("optimise", "design.yaml", "-j", "1", folder=folder)
    assert done.returncode == 3
    assert "note: no design keeps all constraints" in done.stderr


def test_each_command_names_the_other(folder):
    written(folder, BALL, VARY + FAR)
    done = mbproj("fit", "design.yaml", folder=folder)
    assert done.returncode == 2
    assert "it matches nothing; use: mbproj optimise design.yaml" in done.stderr


def test_what_somebody_else_wrote_is_not_replaced(folder):
    written(folder, BALL, VARY + FAR)
    (folder / "design-design").mkdir()
    (folder / "design-design" / "best.yaml").write_text("mine\n")
    done = mbproj("optimise", "design.yaml", folder=folder)
    assert done.returncode == 2
    assert "best.yaml" in done.stderr
    assert (folder / "design-design" / "best.yaml").read_text() == "mine\n"


def test_sensitivity_is_a_table(folder):
    (folder / "scene.yaml").write_text(BALL)
    done = mbproj("sensitivity", "scene.yaml", "--of", "far", "--to", "angle", "--json", folder=folder)
    (row,) = json.loads(done.stdout)["slopes"]
    assert (row["measure"], row["number"], row["unit"]) == ("far", "angle", "m/rad")
    assert row["elasticity"] == pytest.approx(-np.tan(1.0), rel=1e-9)
