"""A run is recorded in one place; its notes are the same values in the command, the file and Python."""

from __future__ import annotations

import ast
import json
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest

import mbproj
from mbproj import InputError, SimulationError, open_results, read_scene
from mbproj.base.errors import MbprojWarning
from mbproj.studies.record import Interrupted, record_run
from tests.cli.commands import mbproj as command
from tests.ropes.scenes import LOAD, UP
from tests.ropes.scenes import scene as roped
from tests.support import ROOT

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"
PACKAGE = ROOT / "mbproj"
#: Who asks for the motion of a mechanism without recording it, each with a recorder of its own.
UNRECORDED = {
    "linear/states.py",
    "studies/certify.py",
    "studies/compare.py",
    "studies/measure/solve.py",
    "studies/paper.py",
    "studies/stability.py",
    "studies/verify/short_runs.py",
}


def called_in(path: Path) -> Iterator[str]:
    """The names of the functions and classes that a module calls."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            yield name


def callers(name: str) -> set[str]:
    naming = (path for path in PACKAGE.rglob("*.py") if f"{name}(" in path.read_text(encoding="utf-8"))
    return {path.relative_to(PACKAGE).as_posix() for path in naming if name in called_in(path)}


def test_one_place_compiles_assembles_and_records():
    assert callers("ResultsWriter") == {"studies/record.py"}
    assert callers("simulate") == {"studies/record.py"} | UNRECORDED
    assert callers("record_run") == {
        "commands/run.py",
        "commands/execute.py",
        "commands/watch.py",
        "studies/batch.py",
        "studies/sweep/run.py",
    }


def drifting(folder: Path) -> Path:
    """The five-bar in steps of 50 ms with Baumgarte's terms, whose energy drifts and whose joints open."""
    text = FIVE_BAR.read_text(encoding="utf-8").partition("expect:")[0]
    (folder / "drifts.yaml").write_text(text, encoding="utf-8")
    return folder / "drifts.yaml"


LOOSE = {"projection": "baumgarte", "formulation": "reduced", "step": 0.05, "duration": 3}


def test_python_warns_once_of_what_the_command_says_and_the_file_keeps(tmp_path):
    path, output = drifting(tmp_path), tmp_path / "out.h5"
    words = [f"--{name}={value}" for name, value in LOOSE.items()]
    done = command("run", path.name, *words, "-o", "said.h5", folder=tmp_path)
    with pytest.warns(MbprojWarning) as warned:
        results = mbproj.run(path, output=output, **LOOSE)
    notes = results.notes
    assert any("the energy drifted by" in note.text and note.doubts_motion for note in notes)
    assert any("this is not the mechanism's motion" in note.text and note.doubts_motion for note in notes)
    assert done.stderr.splitlines() == [str(note) for note in notes]
    assert [str(each.message) for each in warned] == ["\n".join(note.text for note in notes if note.doubts_motion)]
    assert Path(warned[0].filename) == Path(__file__)
    with open_results(tmp_path / "said.h5") as said:
        assert said.notes == notes
    told = command("info", "said.h5", folder=tmp_path).stdout
    assert all(note.text in told for note in notes)
    printed = json.loads(command("run", path.name, *words, "-o", "a.h5", "--json", folder=tmp_path).stdout)
    assert [note["text"] for note in printed["notes"]] == [note.text for note in notes]
    results.close()


def test_a_motion_that_nothing_puts_in_doubt_warns_of_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with mbproj.run(FIVE_BAR, duration=0.05) as results:
            assert results.notes == ()


def test_a_rope_that_pushes_is_in_the_file_too(tmp_path):
    (tmp_path / "pushing.yaml").write_text(roped(LOAD + UP, duration=0.3).replace("20 ms", "0.5 ms"))
    run = record_run(read_scene(tmp_path / "pushing.yaml"), tmp_path / "out.h5")
    assert run.ropes
    (note,) = [note for note in run.notes if "no rope does" in note.text]
    assert note.doubts_motion
    with open_results(tmp_path / "out.h5") as results:
        assert results.notes == run.notes


def test_notes_that_were_changed_are_damage(tmp_path):
    import h5py

    path = tmp_path / "out.h5"
    record_run(read_scene(FIVE_BAR, {}, {"duration": "0.05"}), path)
    with h5py.File(path, "r+") as file:
        file.attrs["notes"] = json.dumps([{"text": 3}])
    with open_results(path) as results, pytest.raises(InputError, match="'notes' holds no notes"):
        _ = results.notes


def test_what_is_wrong_with_the_output_is_said_before_the_start_is_sought(tmp_path, monkeypatch):
    def sought(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("mbproj.studies.record.start_of", sought)
    with pytest.raises(InputError, match="does not exist"):
        record_run(read_scene(FIVE_BAR), tmp_path / "nowhere" / "out.h5")


def test_a_run_that_is_interrupted_says_where_its_samples_are(tmp_path):
    def interrupt(time: float) -> None:
        if time > 0.0:
            raise KeyboardInterrupt

    scene = read_scene(FIVE_BAR, {}, {"duration": "2"})
    with pytest.raises(Interrupted) as interrupted:
        record_run(scene, tmp_path / "out.h5", progress=interrupt)
    assert interrupted.value.output == tmp_path / "out.h5"
    with open_results(tmp_path / "out.h5") as results:
        assert results.status == "interrupted"


def test_a_run_that_fails_says_where_its_samples_are(tmp_path):
    def fail(time: float) -> None:
        raise SimulationError(time, "a test ends it")

    with pytest.raises(SimulationError) as failed:
        record_run(read_scene(FIVE_BAR, {}, {"duration": "2"}), tmp_path / "out.h5", progress=fail)
    assert failed.value.output == tmp_path / "out.h5"
    with open_results(tmp_path / "out.h5") as results:
        assert results.status.startswith("failed")
