"""`mbproj plot` and `mbproj info`: what they print, write and refuse."""

from __future__ import annotations

import gc
import json

import numpy as np
import pytest
from matplotlib.figure import Figure

from mbproj.base.errors import InputError, SimulationError
from mbproj.commands import info, plot
from mbproj.results.layout import DATASETS
from mbproj.results.writer import ResultsWriter
from mbproj.show.figures.kinds import KINDS
from tests.cli.commands import invoked
from tests.results.pendulum_blocks import NAMES, NO_NAMES, block, record, scene, times


@pytest.fixture
def path(tmp_path):
    return record(tmp_path / "run.h5")


def test_plot_writes_all_kinds_and_prints_their_paths(tmp_path, path, monkeypatch):
    """Each file once; that each kind makes a picture is in test_kinds.py."""
    monkeypatch.setattr(Figure, "savefig", lambda figure, file, **_: file.write_bytes(b"picture"))
    code, out, err = invoked(plot.command, path, "-o", tmp_path / "new" / "pictures")
    expected = [
        tmp_path / "new" / "pictures" / f"run-{kind}.png"
        for kind in KINDS
        if kind
        not in ("trust", "mechanism", "loads", "stops", "ropes", "friction", "contacts", "ratios", "transmission")
    ]
    assert (code, out.split(), err) == (0, [str(picture) for picture in expected], "")
    assert all(picture.read_bytes() == b"picture" for picture in expected)


@pytest.mark.full
def test_a_figure_of_many_samples_is_freed_before_the_next_is_drawn(tmp_path, path, monkeypatch):
    """A figure is in circles of references: those of a million samples were all there until the last was drawn."""
    alive = []

    def saved(figure, *_, **__):
        alive.append(sum(isinstance(each, Figure) for each in gc.get_objects()))

    monkeypatch.setattr("mbproj.results.analysis.tables.MANY", 1)
    monkeypatch.setattr("mbproj.show.figures.style.save", saved)
    gc.collect()
    gc.disable()
    try:
        kinds = [f"--kind={kind}" for kind in ("energy", "steps", "violation", "coordinates")]
        code, _, _ = invoked(plot.command, path, *kinds, "-o", tmp_path)
    finally:
        gc.enable()
    assert code == 0
    assert len(alive) == 4
    assert set(alive) == {alive[0]}


def test_plot_the_kinds_asked_for(tmp_path, path, undrawn):
    code, out, _ = invoked(plot.command, path, "--kind", "energy", "--kind", "steps", "-o", tmp_path, "--format", "svg")
    assert (code, out.split()) == (0, [str(tmp_path / f"run-{kind}.svg") for kind in ("energy", "steps")])


def drawn(monkeypatch, *arguments) -> tuple:
    """What `plot` hands to the drawing function."""
    seen = []

    def draw(kind, results, labels, limit, times, corners=()):
        seen.append((kind, list(results), list(labels)))
        from matplotlib.figure import Figure

        return Figure()

    monkeypatch.setattr("mbproj.show.figures.kinds.draw", draw)
    assert invoked(plot.command, *arguments)[0] == 0
    return seen[0]


def test_plot_hands_over_window_names_and_labels(tmp_path, path, monkeypatch):
    other = record(tmp_path / "other.h5", block(times(301)))
    _, results, labels = drawn(
        monkeypatch,
        path,
        other,
        "-o",
        tmp_path,
        "--from",
        0.3,
        "--to",
        0.7,
        "--marker",
        "tip",
        "--joint",
        "A",
        "--label",
        "one",
        "--label",
        "two",
    )
    assert labels == ["one", "two"]
    for shown in results:
        assert np.array_equal(shown.time, times()[30:71])
        assert (shown.names("markers"), shown.names("joints")) == (("tip",), ("A",))


def test_plot_without_labels_takes_what_differs(tmp_path, path, monkeypatch):
    other = record(tmp_path / "other.h5")
    assert drawn(monkeypatch, path, other, "-o", tmp_path)[2] == ["run", "other"]


def test_plot_leaves_out_what_does_not_apply(tmp_path, undrawn):
    path = record(tmp_path / "run.h5", block(times(), NO_NAMES), names=NO_NAMES)
    _, out, err = invoked(plot.command, path, "-o", tmp_path)
    assert out.split() == [str(tmp_path / f"run-{kind}.png") for kind in ("violation", "energy", "steps")]
    assert err.splitlines() == [
        "note: no picture 'markers': the results have no markers",
        "note: no picture 'paths': the results have no markers",
        "note: no picture 'coordinates': the results have no joint coordinates",
        "note: no picture 'joints': the results have no joints",
        "note: no picture 'reactions': the results have no joints",
    ]
    with pytest.raises(InputError) as caught:
        invoked(plot.command, path, "--kind", "markers")
    assert str(caught.value) == (
        "error: --kind markers: the results have no markers; kinds that apply: violation, energy, steps"
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--marker", "Mite"], "no marker 'Mite' in the results; did you mean 'Mitte'? (markers: tip, Mitte)"),
        (["--joint", "K"], "no joint 'K' in the results; joints: A, Gelenk ä"),
        (["--kind", "energi"], "--kind: unknown kind 'energi'; did you mean 'energy'?"),
        (["--label", "a", "--label", "b"], "--label: 2 for 1 results; give one for each file, in their order, or none"),
        (["--from", "3"], "'RUN' has no sample from 3 s; its samples go from 0 s to 2 s"),
        (["--to", "-1"], "'RUN' has no sample to -1 s; its samples go from 0 s to 2 s"),
        (
            ["--from", "1.001", "--to", "1.002"],
            "'RUN' has no sample from 1.001 s to 1.002 s; its samples go from 0 s to 2 s",
        ),
        (["--from", "2", "--to", "1"], "--from 2 is not before --to 1; exchange them"),
        (
            ["-o", "RUN"],
            "'RUN' has the name of a file, but several files are written: a directory is asked for; "
            "give a directory; 'FOLDER' would do",
        ),
    ],
)
def test_plot_refuses(path, arguments, message):
    with pytest.raises(InputError) as caught:
        invoked(plot.command, path, *(str(path) if argument == "RUN" else argument for argument in arguments))
    said = str(caught.value).replace(str(path), "RUN").replace(str(path.parent), "FOLDER")
    assert said == f"error: {message}"


def test_plot_without_samples(tmp_path):
    path = tmp_path / "run.h5"
    with pytest.raises(KeyboardInterrupt), ResultsWriter(path, scene(), NAMES):
        raise KeyboardInterrupt
    with pytest.raises(InputError) as caught:
        invoked(plot.command, path)
    assert str(caught.value) == f"error: '{path}' holds no samples; its status: interrupted"


def test_a_failed_run_is_drawn_with_a_note(tmp_path, undrawn):
    path = tmp_path / "run.h5"
    with pytest.raises(SimulationError), ResultsWriter(path, scene(), NAMES) as recorder:
        recorder.write(block(times()))
        raise SimulationError(2.0, "diverged")
    _, out, err = invoked(plot.command, path, "--kind", "energy", "-o", tmp_path)
    assert out == f"{tmp_path}/run-energy.png\n"
    assert err == f"note: '{path}': failed: stopped at t = 2 s: diverged\n"


def test_the_part_of_a_run_is_drawn_with_a_note(tmp_path, path, undrawn):
    part = path.rename(tmp_path / "run.h5.part")
    _, out, err = invoked(plot.command, path, "--kind", "energy", "-o", tmp_path)
    assert out == f"{tmp_path}/run-energy.png\n"
    assert err == f"note: '{part}' is incomplete: its run was killed, or still goes on\n"
    assert "(partial: the run was killed or still goes on)" in invoked(info.command, path)[1]


def test_info_as_text(path):
    code, out, _ = invoked(info.command, path)
    assert code == 0
    shown = [line.split() for line in out.splitlines()]
    for expected in (
        "title Pendulum of 9.8/9 m",
        "status complete",
        "size 1 bodies, 2 joints with 1 coordinates, 2 markers",
        "samples 201, t = 0 s to 2 s",
        "work 200 steps, 0 rejected steps, 800 evaluations, 200 projections, 0 projection failures",
        "iterations 400 position, 200 velocity",
        "largest |C| 2e-15 at t = 1.57 s",
        "largest joint angle 6.67e-16 rad in 'A' at t = 1.57 s",
        "energy drift 2e-06 J, relative 2.35e-06",
        "projection.method gpopm",
        "--set length 9.8/9",
        "integration_seconds 0.5 s",
        "joints/reaction_force (201, 2, 3) N",
    ):
        assert expected.split() in shown, expected


def test_info_as_json(path):
    code, out, _ = invoked(info.command, path, "--json")
    found = json.loads(out)
    assert code == 0
    assert found["settings"]["projection"]["method"] == "gpopm"
    assert (found["status"], found["partial"], found["samples"]) == ("complete", False, 201)
    assert found["energy_drift"] == pytest.approx(2e-6)
    assert found["names"]["joints"] == ["A", "Gelenk ä"]
    assert found["attributes"]["integration_seconds"] == 0.5
    assert list(found["datasets"]) == [dataset.path for dataset in DATASETS]
    assert found["datasets"]["bodies/orientation"] == {"shape": [201, 1, 4], "unit": "1"}


def test_info_of_a_run_that_diverged_is_json_all_the_same(tmp_path):
    wild = block(times())
    wild["diagnostics/energy_balance"][-1] = np.inf
    wild["diagnostics/position_violation"][-1] = np.nan
    _, out, _ = invoked(info.command, record(tmp_path / "run.h5", wild), "--json")
    found = json.loads(out, parse_constant=lambda name: pytest.fail(name))
    assert found["energy_drift"] is None
    assert (found["position_violation_max"], found["position_violation_time"]) == (None, 2.0)


def test_info_without_samples(tmp_path):
    with ResultsWriter(tmp_path / "run.h5", scene(path=None), NAMES):
        pass
    out = invoked(info.command, tmp_path / "run.h5")[1]
    assert "samples  none" in out
    assert "scene    (not from a file)" in out


def test_info_of_no_results(tmp_path):
    with pytest.raises(InputError, match="there is no results file"):
        invoked(info.command, tmp_path / "no.h5")
