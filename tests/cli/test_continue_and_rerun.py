"""`continue` goes on from a results file, `rerun` makes the same run again, and `export` gives all numbers."""

from __future__ import annotations

import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

from mbproj import continue_run, open_results
from mbproj.base.errors import InputError
from mbproj.results.crash_safety import SLOTS
from mbproj.results.layout import DATASETS
from tests.cli.commands import SLIDER_CRANK, environment, mbproj, succeeds
from tests.crossed import full

# continue: goes on from a results file, or from the part that a kill left; what cannot be gone on with says why.

OPTIONS = ["--step", "5 ms", "--output-step", "0.01"]


def make(folder, name, duration, *arguments):
    succeeds("run", SLIDER_CRANK, "--duration", duration, "-q", "-o", name, *arguments, folder=folder)


def assert_same(first, second, start=0):
    """The second file is what the first has from some sample on."""
    first, second = open_results(first), open_results(second)
    for dataset in DATASETS:
        np.testing.assert_array_equal(first[dataset.path][start:], second[dataset.path], err_msg=dataset.path)
    assert second.settings.duration == first.settings.duration


@pytest.mark.parametrize(
    "options", [full(OPTIONS), ["--integrator", "dopri5", "--tolerance", "1e-8", "--output-step", "0.01"]]
)
def test_a_new_file_has_the_samples_that_follow(tmp_path, options):
    make(tmp_path, "short.h5", "0.1", *options)
    make(tmp_path, "long.h5", "0.3", *options)
    done = succeeds("continue", "short.h5", "--until", "0.3", folder=tmp_path)
    assert "0.3 s" in done.stdout
    count = len(open_results(tmp_path / "continued.h5").time)
    assert 20 <= count < 31
    assert_same(tmp_path / "long.h5", tmp_path / "continued.h5", 31 - count)


def test_append_puts_both_in_place_of_the_first(tmp_path):
    make(tmp_path, "run.h5", "0.1", *OPTIONS)
    make(tmp_path, "long.h5", "0.3", *OPTIONS)
    for until in ("0.2", "0.3"):
        succeeds("continue", "run.h5", "--until", until, "--append", "-q", folder=tmp_path)
    assert_same(tmp_path / "long.h5", tmp_path / "run.h5")


def test_append_into_another_file_leaves_the_first_as_it_was(tmp_path):
    make(tmp_path, "run.h5", "0.1", *OPTIONS)
    make(tmp_path, "long.h5", "0.2", *OPTIONS)
    before = (tmp_path / "run.h5").read_bytes()
    done = succeeds("continue", "run.h5", "--until", "0.2", "--append", "-o", "copy.h5", folder=tmp_path)
    assert "written to copy.h5" in done.stdout
    assert (tmp_path / "run.h5").read_bytes() == before
    assert_same(tmp_path / "long.h5", tmp_path / "copy.h5")
    with continue_run(tmp_path / "run.h5", until=0.2, append=True, output=tmp_path / "again.h5"):
        assert_same(tmp_path / "long.h5", tmp_path / "again.h5")
    assert (tmp_path / "run.h5").read_bytes() == before


@pytest.mark.full
def test_a_killed_run_is_finished(tmp_path):
    options = ["--step", "1e-4", "--output-step", "1e-3"]
    program = [sys.executable, "-c", "from mbproj.commands.main import main; main()"]
    process = subprocess.Popen(
        [*program, "run", SLIDER_CRANK, "--duration", "40", "-q", "-o", "run.h5", *options],
        cwd=tmp_path,
        env={**environment(), "MBPROJ_CACHE": str(tmp_path / "cache")},
    )
    part = tmp_path / "run.h5.part"
    for _ in range(600):
        time.sleep(0.05)
        if part.exists() and _has_a_state(tmp_path / "run.h5"):
            break
    process.kill()
    process.wait()
    killed = open_results(tmp_path / "run.h5")
    assert killed.checkpoint is not None
    until = f"{killed.time[-1] + 0.5:.1f}"
    succeeds("continue", "run.h5", "--until", until, "--append", "-q", folder=tmp_path)
    make(tmp_path, "long.h5", until, *options)
    assert_same(tmp_path / "long.h5", tmp_path / "run.h5")


def _has_a_state(path):
    try:
        return open_results(path).checkpoint is not None
    except InputError:
        return False  # it is just being created


def test_what_cannot_be_gone_on_with_says_why(tmp_path):
    make(tmp_path, "run.h5", "0.1", *OPTIONS)
    assert_refused(tmp_path, ["run.h5"], "--until: error: the run has already reached t = 0.1 s")
    assert_refused(tmp_path, ["run.h5", "--until", "0.05"], "--until: error: the run has already reached t = 0.1 s")
    assert_refused(
        tmp_path, ["run.h5", "--until", "1", "-o", "run.h5"], "--output: error: 'run.h5' is the results file"
    )
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        del file[SLOTS]
    assert_refused(tmp_path, ["run.h5", "--until", "1"], "error: 'run.h5' has no state to continue from")


def assert_refused(folder, arguments, message):
    done = mbproj("continue", *arguments, folder=folder)
    assert done.returncode == 2
    assert done.stderr.startswith(message), done.stderr
    assert "Traceback" not in done.stderr


def test_a_torn_slot_leaves_the_older_state(tmp_path):
    """As a kill leaves it that comes while a state is written."""
    make(tmp_path, "run.h5", "0.1", *OPTIONS)
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        slots = file[SLOTS]
        del slots.attrs["crc32"]
        used = int(np.argmax(np.any(slots[...] != 0, axis=1)))
        slots[used, 40] ^= 255
    assert open_results(tmp_path / "run.h5").checkpoint is None


def test_what_holds_no_run_is_not_old(tmp_path):
    assert mbproj("equilibrium", SLIDER_CRANK, "-o", "rest.h5", folder=tmp_path).returncode in (0, 3)
    done = mbproj("continue", "rest.h5", folder=tmp_path)
    assert done.returncode == 2
    assert "'rest.h5' holds no run that could be continued" in done.stderr, done.stderr


def test_a_time_that_lies_ahead_is_advised(tmp_path):
    make(tmp_path, "short.h5", "0.1", *OPTIONS)
    done = mbproj("continue", "short.h5", "--until", "0.02", folder=tmp_path)
    assert "the run has already reached t = 0.1 s; say until when it is to go on, e.g. --until 0.2" in done.stderr


# export: all numbers, to the last digit. rerun: the same run, to the last bit, from the results file alone.


def make_a(folder, *arguments: str) -> None:
    succeeds("run", SLIDER_CRANK, "--duration", "0.1", "-q", "-o", "a.h5", *arguments, folder=folder)


def read(path):
    lines = path.read_text().splitlines()
    return lines[0].split(","), np.array([[float(x) for x in line.split(",")] for line in lines[1:]])


def test_export_writes_a_table_for_each_thing(tmp_path):
    make_a(tmp_path)
    done = mbproj("export", "a.h5", "-o", "csv", folder=tmp_path)
    names = ["body-crank", "body-rod", "body-slider", "marker-slider", "joint-A", "joint-B", "joint-C", "joint-D"]
    assert done.stdout.split() == [f"csv/a-{name}.csv" for name in [*names, "diagnostics", "loads"]]
    headings, values = read(tmp_path / "csv" / "a-body-rod.csv")
    assert headings[:5] == ["time (s)", "position_x (m)", "position_y (m)", "position_z (m)", "orientation_0 (1)"]
    assert len(headings) == 1 + 3 + 4 + 4 * 3
    results = open_results(tmp_path / "a.h5")
    np.testing.assert_array_equal(values[:, 0], results.time)
    np.testing.assert_array_equal(values[:, 1:4], results.body("rod").position)
    headings, values = read(tmp_path / "csv" / "a-joint-C.csv")
    assert headings[-4:] == ["angle_1 (rad)", "angle_1_speed (rad/s)", "angle_2 (rad)", "angle_2_speed (rad/s)"]
    np.testing.assert_array_equal(values[:, -4], results.coordinate("C.angle_1").value)


def test_export_of_chosen_tables(tmp_path):
    make_a(tmp_path)
    listed = mbproj("export", "a.h5", "--list", folder=tmp_path).stdout.split()
    assert listed[0] == "body-crank"
    done = mbproj("export", "a.h5", "--table", "diagnostics", folder=tmp_path)
    assert done.stdout == "a-diagnostics.csv\n"
    wrong = mbproj("export", "a.h5", "--table", "body-crnk", folder=tmp_path)
    assert (wrong.returncode, wrong.stderr) == (
        2,
        "error: there is no table 'body-crnk'; did you mean 'body-crank'?\n",
    )


def test_rerun_is_the_same_to_the_last_bit_without_the_scene_file(tmp_path):
    settings = ["--projection", "mmopm", "--alpha", "1e5", "--step", "5 ms", "--output-step", "0.01"]
    make_a(tmp_path, "--set", "speed=7", *settings)
    succeeds("rerun", "a.h5", "-o", "b.h5", folder=tmp_path)
    first, second = open_results(tmp_path / "a.h5"), open_results(tmp_path / "b.h5")
    for dataset in DATASETS:
        np.testing.assert_array_equal(first[dataset.path], second[dataset.path], err_msg=dataset.path)
    assert (second.settings, second.overrides) == (first.settings, first.overrides)
    assert second.settings.projection.alpha == 1e5


def test_rerun_does_not_overwrite_what_it_repeats(tmp_path):
    make_a(tmp_path)
    before = (tmp_path / "a.h5").read_bytes()
    done = mbproj("rerun", "a.h5", "-o", "a.h5", folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("--output: error: 'a.h5' is the results file to repeat")
    assert (tmp_path / "a.h5").read_bytes() == before


def test_files_that_are_no_results(tmp_path):
    (tmp_path / "x.h5").write_bytes(b"not HDF5 at all")
    for command in ("export", "rerun", "info", "plot"):
        done = mbproj(command, "x.h5", folder=tmp_path)
        assert done.returncode == 2
        assert "error: 'x.h5'" in done.stderr
        assert "Traceback" not in done.stderr
