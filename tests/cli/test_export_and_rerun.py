"""export: all numbers, to the last digit. rerun: the same run, to the last bit, from the results file alone."""

from __future__ import annotations

import numpy as np

from mbproj import open_results
from mbproj.results.layout import DATASETS
from tests.cli.commands import SLIDER_CRANK, mbproj


def make(folder, *arguments: str) -> None:
    done = mbproj("run", SLIDER_CRANK, "--duration", "0.1", "-q", "-o", "a.h5", *arguments, folder=folder)
    assert done.returncode == 0, done.stderr


def read(path):
    lines = path.read_text().splitlines()
    return lines[0].split(","), np.array([[float(x) for x in line.split(",")] for line in lines[1:]])


def test_export_writes_a_table_for_each_thing(tmp_path):
    make(tmp_path)
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
    make(tmp_path)
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
    make(tmp_path, "--set", "speed=7", *settings)
    done = mbproj("rerun", "a.h5", "-o", "b.h5", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    first, second = open_results(tmp_path / "a.h5"), open_results(tmp_path / "b.h5")
    for dataset in DATASETS:
        np.testing.assert_array_equal(first[dataset.path], second[dataset.path], err_msg=dataset.path)
    assert (second.settings, second.overrides) == (first.settings, first.overrides)
    assert second.settings.projection.alpha == 1e5


def test_rerun_does_not_overwrite_what_it_repeats(tmp_path):
    make(tmp_path)
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
