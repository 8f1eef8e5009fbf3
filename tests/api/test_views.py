"""Results for others: every number of a run is in the tables, the pictures and the page of a notebook."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest

import mbproj
from mbproj.results.views import AXES, columns
from tests.support import ROOT

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"


@pytest.fixture(scope="module")
def results():
    with mbproj.run(ROOT / "mechanisms" / "five_bar.yaml", duration=0.05) as found:
        yield found


def test_columns_hold_every_number_once(results):
    found = list(columns(results.datasets, results.names, results.__getitem__))
    assert len({each[:3] for each in found}) == len(found)
    whole = sum(results[each.path].size for each in results.datasets if each.path != "time")
    assert sum(each.values.size for each in found) == whole
    by_name = {each[:3]: each for each in found}
    assert np.array_equal(by_name["markers", "tip", "position_z"].values, results.marker("tip").position[:, 2])
    assert by_name["joints", "A", "reaction_force_x"].unit == "N"


def test_every_symbol_of_the_layout_has_a_dimension():
    from mbproj.results.layout import DATASETS, LATER

    assert {each.symbol for each in (*DATASETS, *LATER) if each.symbol} == set(AXES)


def test_pandas(results):
    pytest.importorskip("pandas")
    frame = results.to_pandas()
    assert np.array_equal(frame["markers"]["tip"]["position_x"], results.marker("tip").position[:, 0])
    assert frame.index.name == "time"
    assert frame.attrs["units"]["joints", "A", "reaction_torque_x"] == "N m"


def test_xarray(results):
    pytest.importorskip("xarray")
    found = results.to_xarray()
    tip = found.markers_position.sel(marker="tip", axis="z")
    assert np.array_equal(tip, results.marker("tip").position[:, 2])
    assert found.joints_reaction_force.dims == ("time", "joint", "axis")
    assert set(found.coordinate_unit.values) == {"rad"}


def test_what_is_missing_is_said(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install 'mbproj\[tables\]'"):
        results.to_pandas()


def test_pictures_are_of_what_is_named(results):
    drawn = results.plot.reactions("A")
    assert "of A" in drawn.axes[0].get_ylabel()
    line = results.plot.markers("tip").axes[0].lines[0]
    assert np.array_equal(line.get_xdata(), results.time)
    assert drawn._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(AttributeError, match="did you mean 'reactions'"):
        results.plot.reaction("A")
    with pytest.raises(mbproj.InputError, match="the results have no motions"):
        results.plot.motions()
    with pytest.raises(mbproj.InputError, match="takes no names"):
        results.plot.energy("A")
    with pytest.raises(mbproj.InputError, match="no sample in this window"):
        results.plot.energy(start=1)


def test_the_page_is_that_of_the_command(results, tmp_path):
    pytest.importorskip("trimesh")
    page = results.animate()
    assert page.html.lower().startswith("<!doctype html>")
    assert page._repr_html_().startswith('<iframe srcdoc="&lt;!')
    assert page.save(tmp_path / "page.html").read_text(encoding="utf-8") == page.html


def test_an_open_file_is_open_to_others(results):
    """Another process reads it with h5py's defaults while it is open here."""
    code = f"import h5py; print(h5py.File({str(results.path)!r}, 'r')['time'].shape[0])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) == len(results.time)


#: Calls with an argument that has to be a text.
TEXTS = {
    "marker": lambda results, value: results.marker(value),
    "joint": lambda results, value: results.joint(value),
    "a dataset": lambda results, value: results[value],
    "constant": lambda results, value: results.constant(value),
    "a column": lambda _, value: mbproj.check(FIVE_BAR).table[value],
    "schema": lambda _, value: mbproj.schema(value),
    "new": lambda _, value: mbproj.new(value),
    "read_scene_text": lambda _, value: mbproj.read_scene_text(value),
    "export_model": lambda _, value: mbproj.export_model(FIVE_BAR, value),
}


@pytest.mark.parametrize("call", TEXTS)
@pytest.mark.parametrize("value", [["tip"], b"tip", np.array([1.0, 2.0]), None, 3, (1, 2)], ids=repr)
def test_what_is_no_text_is_said_in_words(results, call, value):
    with pytest.raises(TypeError, match=rf"is a text, found {type(value).__name__}|mapping is a text, found"):
        TEXTS[call](results, value)


@pytest.mark.parametrize("value", [["tip"], b"x", np.array([1.0, 2.0]), 3])
@pytest.mark.parametrize("function", [mbproj.run, mbproj.check, mbproj.compare, mbproj.export_model])
def test_parameters_are_a_mapping(function, value):
    with pytest.raises(TypeError, match=f"parameters are a mapping of names and values, found {type(value).__name__}"):
        function(FIVE_BAR, parameters=value)


def test_names_and_paths_are_those_of_something():
    with pytest.raises(TypeError, match="names are a text or a list of texts, found int"):
        mbproj.compare(FIVE_BAR, projections=3)
    with pytest.raises(mbproj.InputError, match="no scene is given; give files, folders or patterns"):
        mbproj.batch([])


@pytest.mark.parametrize("copied", [pickle.dumps, copy.deepcopy])
def test_results_are_an_open_file_and_not_copied(results, copied):
    with pytest.raises(TypeError, match=r"results are an open file, .*: pass its path on"):
        copied(results)
