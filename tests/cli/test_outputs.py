"""Commands replace what mbproj wrote, and nothing else unless told to; a path that cannot be written is refused before
the work."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys

import h5py
import numpy as np
import pytest

from tests.cli.commands import FIVE_BAR, SLIDER_CRANK, mbproj, succeeds
from tests.crossed import some
from tests.support import ROOT


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("outputs")
    succeeds("run", SLIDER_CRANK, "--duration", "0.05", "-q", "-o", "a.h5", folder=folder)
    return folder / "a.h5"


COMMANDS = {
    "export": (["export", "a.h5", "--table", "body-rod"], "a-body-rod.csv"),
    "plot": (["plot", "a.h5", "--kind", "energy", "--format", "svg"], "a-energy.svg"),
    "schema": (["schema", "-o", "s.json"], "s.json"),
    "batch": (["batch", "short.yaml", "--junit", "r.xml"], "r.xml"),
    "new": (["new", "pendulum", "-o", "p.yaml"], "p.yaml"),
}


def test_no_directory_gets_the_name_of_a_picture(tmp_path, run):
    done = mbproj("plot", run, "-o", "figures/p.png", folder=tmp_path)
    assert done.returncode == 2
    assert "'figures/p.png' has the name of a file" in done.stderr and "'figures' would do" in done.stderr
    assert not (tmp_path / "figures").exists()


@pytest.mark.parametrize("name", some(COMMANDS, 3))
def test_a_file_of_somebody_else_is_replaced_with_force_alone(tmp_path, run, name):
    arguments, written = COMMANDS[name]
    shutil.copy(run, tmp_path / "a.h5")
    assert mbproj("new", "pendulum", "--length", "1", "-o", "short.yaml", folder=tmp_path).returncode == 0
    (tmp_path / written).write_text("mine: 1\n")
    refused = mbproj(*arguments, folder=tmp_path)
    assert refused.returncode == 2, refused.stderr
    assert f"error: '{written}' exists and is not " in refused.stderr and "give --force" in refused.stderr
    assert (tmp_path / written).read_text() == "mine: 1\n"
    assert mbproj(*arguments, "--force", folder=tmp_path).returncode == 0
    assert (tmp_path / written).read_text() != "mine: 1\n"
    again = mbproj(*arguments, folder=tmp_path)
    assert again.returncode == (2 if name == "new" else 0), again.stderr


def test_junit_never_replaces_the_scene(tmp_path):
    assert mbproj("new", "pendulum", "-o", "p.yaml", folder=tmp_path).returncode == 0
    before = (tmp_path / "p.yaml").read_bytes()
    done = mbproj("batch", "--junit", "p.yaml", "p.yaml", folder=tmp_path)
    assert (done.returncode, (tmp_path / "p.yaml").read_bytes()) == (2, before)


def test_a_study_refuses_before_it_works(tmp_path):
    (tmp_path / "five_bar-compare.csv").write_text("mine\n")
    done = mbproj("compare", FIVE_BAR, "--until", "1e6 s", folder=tmp_path)  # it would take hours
    assert done.returncode == 2
    assert "'five_bar-compare.csv' exists and is not a CSV table of mbproj" in done.stderr


def test_files_with_dots_in_their_names_export_to_different_tables(tmp_path, run):
    for name in ("run.a.h5", "run.b.h5"):
        shutil.copy(run, tmp_path / name)
        done = mbproj("export", name, "--table", "diagnostics", folder=tmp_path)
        assert done.stdout == f"{name[:5]}-diagnostics.csv\n"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_pipes_in_place_of_outputs_block_nobody(tmp_path, run):
    shutil.copy(run, tmp_path / "a.h5")
    assert mbproj("new", "pendulum", "-o", "short.yaml", folder=tmp_path).returncode == 0
    for arguments, written in COMMANDS.values():
        os.mkfifo(tmp_path / written)
        done = mbproj(*arguments, "--force", folder=tmp_path)
        assert (done.returncode, "is a pipe or a device, not a file" in done.stderr) == (2, True), done.stderr


def test_storing_a_verification_touches_no_other_file(tmp_path, run):
    shutil.copy(run, tmp_path / "a.h5")
    (tmp_path / "precious").write_text("mine")
    (tmp_path / "a.h5.verify").symlink_to("precious")
    scene = [SLIDER_CRANK, "--duration", "0.05"]
    succeeds("verify", *scene, "--store", "a.h5", folder=tmp_path)
    assert (tmp_path / "precious").read_text() == "mine"
    assert (tmp_path / "a.h5.verify").is_symlink()
    assert "\nverification\n" in mbproj("info", "a.h5", folder=tmp_path).stdout
    assert stat.S_IMODE((tmp_path / "a.h5").stat().st_mode) == stat.S_IMODE(run.stat().st_mode)


def test_a_scene_that_was_changed_meanwhile_is_not_written_over(tmp_path):
    from mbproj import read_scene
    from mbproj.base.errors import InputError
    from mbproj.studies.recommend import write_back

    path = tmp_path / "five_bar.yaml"
    shutil.copy(FIVE_BAR, path)
    scene = read_scene(path)
    path.write_text(path.read_text() + "# mine\n")
    with pytest.raises(InputError, match="has changed since it was read"):
        write_back(scene, scene.settings)
    assert path.read_text().endswith("# mine\n")


def test_names_in_results_lead_out_of_no_folder(tmp_path, run):
    shutil.copy(run, tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        names = [b"x/../../../T", *file["joints/names"][1:]]
        del file["joints/names"]
        file["joints/names"] = np.array(names)
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a-joint-x").mkdir()
    before = sorted(tmp_path.rglob("*"))
    done = mbproj("export", "a.h5", "-o", "in", folder=tmp_path)
    assert done.returncode == 2, done.stdout
    assert sorted(tmp_path.rglob("*")) == before


def test_a_name_that_is_no_text_and_a_screen_that_matplotlib_does_not_know(tmp_path):
    scene, picture, results = (os.fsdecode(b"\xff" + name) for name in (b".yaml", b".png", b".h5"))
    shutil.copy(FIVE_BAR, tmp_path / scene)
    program = [
        sys.executable,
        "-c",
        "from mbproj.commands.main import main; main()",
        "check",
        scene,
        "--picture",
        picture,
    ]
    surroundings = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "nonsense"}
    done = subprocess.run(program, cwd=tmp_path, env=surroundings, capture_output=True)
    assert (done.returncode, done.stderr) == (0, b"")
    assert mbproj("run", scene, "-q", "--duration", "0.02", "-o", results, folder=tmp_path).returncode == 0
    assert all((tmp_path / name).is_file() for name in (picture, results))


# A path that cannot be written is refused before the work, by every command that writes one.

BEFORE = {
    "verify-plot": ("verify", FIVE_BAR, "--plot", "nowhere/v.png"),
    "run": ("run", FIVE_BAR, "-o", "nowhere/a.h5"),
    "accuracy": ("run", FIVE_BAR, "--accuracy", "1e-3", "-o", "nowhere/a.h5"),
    "branches": ("branches", FIVE_BAR, "--picture", "nowhere/a.png"),
    "check": ("check", FIVE_BAR, "--picture", "nowhere/a.html"),
    "curve": ("curve", FIVE_BAR, "-o", "nowhere/a.csv"),
    "compare": ("compare", FIVE_BAR, "--write-table", "nowhere/a.csv"),
    "modes": ("modes", FIVE_BAR, "-o", "nowhere/m.h5"),
    "linearize": ("linearize", FIVE_BAR, "--inputs", "a", "--outputs", "b", "-o", "nowhere/m.h5"),
    "equilibrium": ("equilibrium", FIVE_BAR, "-o", "nowhere/e.h5"),
    "import": ("import", "none.xml", "-o", "nowhere/a.yaml"),
    "export": ("export", FIVE_BAR, "--mjcf", "nowhere/a.xml"),
    "loads": ("loads", FIVE_BAR, "-o", "nowhere/a.csv"),
    "animate": ("animate", FIVE_BAR, "-o", "nowhere/a.html"),
    "batch": ("batch", FIVE_BAR, "--junit", "nowhere/x.xml"),
    "recommend": ("recommend", FIVE_BAR, "--error", "1e-3", "--plot", "nowhere/x.png"),
    "tradeoff": ("tradeoff", FIVE_BAR, "--write-table", "nowhere/x.tex"),
    "info": ("info", "none.h5", "--loads", "--write-table", "nowhere/x.csv"),
}


@pytest.mark.parametrize("words", BEFORE.values(), ids=BEFORE)
def test_a_path_in_a_folder_that_is_not_there_is_refused_before_the_work(words, tmp_path):
    """What is asked for is wrong, too, or would take long: only the path is looked at."""
    done = mbproj(*words, folder=tmp_path)
    assert done.returncode == 2 and not done.stdout
    assert "the directory 'nowhere' of" in done.stderr
    assert "does not exist" in done.stderr and "traceback" not in done.stderr.lower()
    assert list(tmp_path.iterdir()) == []
