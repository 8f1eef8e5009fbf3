"""A page: one file without a network, whose numbers are those of the run and whose texts are texts."""

from __future__ import annotations

import re
import zlib
from base64 import b64decode

import numpy as np
import pytest

from mbproj import Trust, assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.pages.appearance.motion import motion_at
from mbproj.pages.data.pages import page_of, start_of
from mbproj.pages.page.three_js import three_js
from mbproj.pages.page.write import as_json, html
from mbproj.results import Poses, ResultsWriter, open_results
from mbproj.scene import read_scene_text
from tests.pages.runs import FIVE_BAR, HOSTILE, block_of, bytes_of, data_of, five_bar, recorded
from tests.support import Recorder as Kept


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return five_bar(tmp_path_factory.mktemp("page") / "five_bar.h5")


@pytest.fixture(scope="module")
def text(path):
    with open_results(path) as results:
        page = page_of([results], ["run"])
        return html(page.title, page.data, page.packer)


def test_ten_seconds_of_the_five_bar_are_less_than_a_megabyte(text):
    assert len(text.encode()) <= 1_000_000


def test_the_page_asks_for_nothing(text):
    ours = text.replace(three_js(), "")
    assert not re.search(r"https?:|//[a-z]+\.|\bsrc=|@import|url\(|fetch\(|XMLHttpRequest|WebSocket", ours)
    assert "default-src 'none'" in ours  # and a browser holds it to that
    assert "connect-src" not in ours


def test_positions_are_those_of_the_file_to_single_precision(path, text):
    (run,), packed = data_of(text)["runs"], bytes_of(text)
    with open_results(path) as results:
        time = block_of(packed, run["blocks"][run["time"]]).ravel()
        rows = np.array([np.argmin(np.abs(results.time - at)) for at in time])
        assert len(rows) == 601
        assert np.abs(time - results.time[rows]).max() <= 1e-7
        position = block_of(packed, run["blocks"][run["position"]]).reshape(601, 5, 3) + run["centre"]
        assert np.abs(position - results["bodies/position"][rows]).max() <= 5.0 * 2.0**-24
        turns = block_of(packed, run["blocks"][run["orientation"]]).reshape(601, 5, 4)
        recorded_turns = results["bodies/orientation"][rows]
        signs = np.sign(np.einsum("tnk,tnk->tn", turns, recorded_turns))[..., None]
        assert np.abs(turns - signs * recorded_turns).max() <= 2.0**-19
        assert np.einsum("tnk,tnk->tn", turns[1:], turns[:-1]).min() > 0.0  # no jump from Λ to -Λ


def test_series_are_those_of_the_file(path, text):
    (run,), packed = data_of(text)["runs"], bytes_of(text)
    groups = {(group["kind"], group["name"]): group for group in run["groups"]}
    with open_results(path) as results:
        time = block_of(packed, run["blocks"][run["time"]]).ravel()
        rows = np.array([np.argmin(np.abs(results.time - at)) for at in time])
        angles = groups["coordinates", "coordinate"]
        assert angles["owners"] == list(results.names("coordinates"))
        found = block_of(packed, run["blocks"][angles["block"]])
        assert np.allclose(found, results["joints/coordinate"][rows], rtol=0, atol=1e-4)
        violation = groups["joints", "violation"]
        shown = 10.0 ** block_of(packed, run["blocks"][violation["block"]])
        largest = results["joints/violation"].max(axis=0)
        assert np.allclose(shown.max(axis=0), largest, rtol=2e-3)  # no peak is lost between two frames
        force = block_of(packed, run["blocks"][groups["joints", "reaction force"]["block"]]).reshape(601, 5, 3)
        assert np.allclose(force, results["joints/reaction_force"][rows], rtol=0, atol=1e-5 * np.abs(force).max())


def test_texts_of_files_are_never_markup(tmp_path):
    scene = read_scene_text(HOSTILE, "hostile.yaml")
    with open_results(recorded(scene, tmp_path / "hostile.h5")) as results:
        page = page_of([results], ["<img onerror=alert(2)>"])
        text = html(page.title, page.data, page.packer)
    assert text.count("</script>") == 4  # data, numbers, three.js, ours
    assert "<script>alert" not in text
    assert "<img onerror" not in text
    assert data_of(text)["title"] == scene.title
    assert data_of(text)["runs"][0]["label"] == "<img onerror=alert(2)>"


def test_json_escapes_what_a_parser_of_html_could_take_for_its_own():
    assert as_json({"a": "</script>&<!--"}) == '{"a":"\\u003c/script\\u003e\\u0026\\u003c!--"}'
    with pytest.raises(ValueError, match="not JSON compliant"):
        as_json({"a": float("nan")})


def test_a_scene_without_a_run_shows_its_start():
    scene = read_scene(FIVE_BAR)
    system = compile_system(scene)
    motion = motion_at(system, assemble(system, initial_guess(scene, system)).q)
    page = start_of(scene, motion, "five bars")
    (run,) = page.data["runs"]
    assert page.packer.blocks[run["position"]]["rows"] == 1
    assert run["groups"] == []
    assert motion.position[0, 4].tolist() == pytest.approx([4.5, 0.0, 0.0])


def test_two_runs_share_a_view_that_holds_both(path):
    with open_results(path) as one, open_results(path) as other:
        page = page_of([one, other.select(start=0.0, stop=1.0)], ["whole", "part"])
    assert [run["label"] for run in page.data["runs"]] == ["whole", "part"]
    with open_results(path) as one:
        alone = page_of([one], ["whole"])
    assert page.data["view"]["radius"] >= alone.data["view"]["radius"] * (1 - 1e-12)


def test_three_js_is_whole_and_has_its_licence():
    text = three_js()
    assert "SPDX-License-Identifier: MIT" in text
    assert text.startswith("/**")
    assert "WebGLRenderer=" in text or "WebGLRenderer" in text
    assert "</script" not in text.lower()
    assert len(text) < 1_000_000


def test_a_certified_run_says_from_when_on_it_is_not_to_be_trusted(tmp_path):
    scene = read_scene(FIVE_BAR, simulation={"duration": 1})
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    time = np.arange(101) * 0.01
    with ResultsWriter(tmp_path / "run.h5", scene, system.names.as_mapping(), certified=[1e-3]) as writer:
        simulate(system, state, settings_to_run(scene), writer)
        one, late = np.ones(1), np.full((1, 1), 0.5)
        error = np.where(time > 0.5, 2e-3, 0.0)[:, None]
        kept = Kept()
        simulate(system, state, settings_to_run(scene), kept)
        poses = Poses(kept["bodies/position"] + [0.0, 0.0, 0.002], kept["bodies/orientation"])
        poses.position[-1] = np.nan  # the better solution has ended
        points = ("tip",), np.array([1e-3])
        found = Trust(*points, time, error, 0.0 * error, late, late, late, one, one, ("",), "better", better=poses)
        writer.trust(found)
    with open_results(tmp_path / "run.h5") as results:
        page = page_of([results], ["run"], limit=1e-3)
        run, ghost = page.data["runs"]
        _, late_ghost = page_of([results.select(start=0.8)], ["run"], limit=1e-3).data["runs"]
        position = results["bodies/position"][51:100].reshape(49, -1)
        (lax,) = page_of([results], ["run"], limit=1e-2).data["runs"]
    assert run["trust"]["since"] == pytest.approx(0.51)
    assert run["trust"]["text"] == "not to be trusted from 0.51 s on: the error may exceed 0.001 m"
    assert lax["trust"]["since"] is None  # and then there is no ghost
    assert (ghost["label"], ghost["ghost"], ghost["from"]) == ("better solution", True, pytest.approx(0.51))
    block = ghost["blocks"][ghost["position"]]
    assert block["rows"] == 49
    assert late_ghost["blocks"][late_ghost["position"]]["rows"] == 20
    there = block_of(zlib.decompress(b64decode(page.packer.text())), block) + np.tile(ghost["centre"], 5)
    assert np.abs(there - position - np.tile([0.0, 0.0, 0.002], 5)).max() <= 5.0 * 2.0**-24
