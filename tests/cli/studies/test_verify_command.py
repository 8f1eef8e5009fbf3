"""`mbproj verify` as a user meets it: the table, --json, --store, exit codes."""

from __future__ import annotations

import json

import pytest

from mbproj import open_results
from tests.cli.commands import FIVE_BAR, mbproj
from tests.studies.scenes import write


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
    run = mbproj("run", str(path), "-q", folder=tmp_path)
    assert run.returncode == 0, run.stderr
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
    again = mbproj("rerun", "results.h5", "-o", "again.h5", "-q", folder=tmp_path)
    assert again.returncode == 0, again.stderr


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
