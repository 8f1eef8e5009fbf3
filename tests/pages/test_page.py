"""A page: one file without a network, its samples and numbers those of the run; and `mbproj animate`."""

from __future__ import annotations

import re
import zlib
from base64 import b64decode

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from mbproj import Trust, read_scene, settings_to_run, simulate
from mbproj.base.errors import InputError
from mbproj.commands import animate
from mbproj.results.reader import open_results
from mbproj.results.trust import Poses
from mbproj.results.writer import ResultsWriter
from mbproj.scene.scene import read_scene_text
from mbproj.show.appearance.motion import motion_at
from mbproj.show.page import write as three_js_module
from mbproj.show.page.pages import page_of, start_of
from mbproj.show.page.series import (
    FEWEST,
    LARGEST,
    ORDERS,
    REFUSED,
    THINNED,
    Packer,
    frames_of,
    largest_between,
    step_of,
)
from mbproj.show.page.write import as_json, html, three_js
from tests.cli.commands import invoked
from tests.pages.runs import FIVE_BAR, HOSTILE, block_of, bytes_of, data_of, five_bar, recorded
from tests.support import Recorder as Kept
from tests.support import assembled


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
    system, state = assembled(scene)
    motion = motion_at(system, state.q)
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
    system, state = assembled(scene)
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


# Numbers survive packing to half a step, whatever they are.

NUMBERS = arrays(
    float,
    array_shapes(min_dims=2, max_dims=2, min_side=0, max_side=12),
    elements=st.floats(-1e6, 1e6) | st.just(np.nan) | st.just(np.inf),
)


def there_and_back(values: np.ndarray, step: float | np.ndarray) -> np.ndarray:
    packer = Packer()
    packer.add(np.ones((3, 2)), 1.0)  # something before it
    number = packer.add(values, step)
    return block_of(zlib.decompress(b64decode(packer.text())), packer.blocks[number])


@settings(max_examples=60, deadline=None)
@given(NUMBERS)
def test_each_number_is_off_by_half_a_step_at_most(values):
    step = step_of(values, 24)
    back = there_and_back(values, step)
    assert back.shape == values.shape
    finite = np.isfinite(values)
    assert np.array_equal(np.isfinite(back), finite)
    assert (np.abs(back - values) <= 0.5 * step * (1 + 1e-12))[finite].all()


def test_a_step_keeps_the_digits_that_were_asked_for():
    assert step_of(np.array([[3.0, 0.0, -100.0]]), 8).tolist() == [2.0**-6, 1.0, 2.0**-1]


def test_a_smooth_motion_takes_two_bytes_a_number_or_less():
    time = np.linspace(0.0, 10.0, 601)
    values = np.sin(2.0 * time[:, None] * np.arange(1, 9))
    packer = Packer()
    packer.add(values, 2.0**-24)
    assert packer.blocks[0]["order"] == max(ORDERS)
    assert len(b64decode(packer.text())) <= 2.0 * values.size


def test_what_is_too_large_for_its_step_is_no_number():
    values = np.array([[2.0 * LARGEST], [1.0]])
    assert np.isnan(there_and_back(values, 1.0)[0, 0])
    assert there_and_back(values, 1.0)[1, 0] == 1.0


@pytest.mark.parametrize("rows", [0, 1, 2, 3])
def test_few_rows(rows):
    values = np.arange(2.0 * rows).reshape(rows, 2)
    assert np.array_equal(there_and_back(values, 1.0), values)


# Which samples a page shows.


def test_a_dense_run_is_thinned_to_sixty_frames_a_second_and_says_so():
    time = np.linspace(0.0, 20.0, 20001)
    frames = frames_of(time, np.arange(20001), 5)
    assert len(frames.rows) == 1201
    assert (frames.rows[0], frames.rows[-1]) == (0, 20000)
    assert np.abs(np.diff(time[frames.rows]) - 1 / 60).max() <= 1e-3 + 1e-12  # as even as the samples are
    assert frames.remark == "1201 of 20001 samples are shown: more than a screen can show"


def test_a_short_run_keeps_its_samples_and_full_keeps_all():
    time = np.linspace(0.0, 0.08, 801)
    assert len(frames_of(time, np.arange(801), 5).rows) == FEWEST + 1
    assert len(frames_of(time, np.arange(801), 5, full=True).rows) == 801
    assert frames_of(time, np.arange(801), 5, full=True).remark == ""


def test_a_large_mechanism_gets_fewer_frames_and_is_told_why():
    time = np.linspace(0.0, 100.0, 6001)
    frames = frames_of(time, np.arange(6001), 1000)
    assert len(frames.rows) == THINNED // 7000
    assert frames.remark.endswith("the page would be too large for a browser with more")


def test_what_no_browser_opens_is_refused():
    time = np.linspace(0.0, 100.0, 10001)
    with pytest.raises(InputError, match=r"10001 frames of 1000 bodies are 70 million numbers.*leave --full out"):
        frames_of(time, np.arange(10001), 1000, full=True)
    with pytest.raises(InputError, match="bodies are more than a browser shows"):
        frames_of(time, np.arange(10001), REFUSED // 14 + 1)


def test_samples_without_a_pose_are_not_shown():
    whole = np.array([0, 1, 5, 6])
    assert frames_of(np.arange(7.0), whole, 1).rows.tolist() == [0, 1, 5, 6]


def test_no_peak_between_two_frames_is_lost():
    values = np.array([[1.0], [9.0], [2.0], [np.nan], [3.0]])
    assert largest_between(values, np.arange(5), np.array([0, 2, 4])).ravel().tolist() == [1.0, 9.0, 3.0]


# `mbproj animate`: what it writes, prints and refuses.


@pytest.fixture
def run_path(tmp_path):
    return five_bar(tmp_path / "run.h5", duration=0.5)


def test_the_page_stands_beside_the_results(run_path):
    code, out, err = invoked(animate.command, run_path)
    assert (code, out, err) == (0, f"{run_path.with_suffix('.html')}\n", "")
    assert run_path.with_suffix(".html").read_text(encoding="utf-8").startswith("<!doctype html>")


def test_a_page_of_ours_is_replaced_and_no_other_file(run_path, tmp_path):
    invoked(animate.command, run_path)
    assert invoked(animate.command, run_path)[0] == 0
    other = tmp_path / "mine.html"
    other.write_text("<html>mine</html>")
    with pytest.raises(InputError, match=r"mine.html' exists and is not a page of mbproj"):
        invoked(animate.command, run_path, "-o", other)
    assert invoked(animate.command, run_path, "-o", other, "--force")[0] == 0


def test_a_scene_shows_its_start_alone(run_path, tmp_path):
    code, out, err = invoked(animate.command, FIVE_BAR, "-o", tmp_path / "start.html")
    assert (code, out) == (0, f"{tmp_path / 'start.html'}\n")
    assert "the start, assembled; nothing was run" in err
    with pytest.raises(InputError, match="is a scene, and scenes are shown alone"):
        invoked(animate.command, run_path, FIVE_BAR, "-o", tmp_path / "both.html")


def test_two_results_with_labels(run_path, tmp_path):
    assert (
        invoked(animate.command, run_path, run_path, "-o", tmp_path / "two.html", "--label", "a", "--label", "b")[0]
        == 0
    )
    with pytest.raises(InputError, match="--label: 1 for 2 files"):
        invoked(animate.command, run_path, run_path, "--label", "a")


def test_a_window_without_a_sample_is_refused(run_path):
    with pytest.raises(InputError, match=r"has no sample from 7 s"):
        invoked(animate.command, run_path, "--from", 7)


def test_the_name_of_a_page_ends_in_html(run_path, tmp_path):
    with pytest.raises(InputError, match=r"'.*run.txt' is not the name of a page or film"):
        invoked(animate.command, run_path, "-o", tmp_path / "run.txt")


def test_without_the_extra_one_line_says_how_to_install_it(run_path, monkeypatch):
    monkeypatch.setattr(three_js_module, "find_spec", lambda name: None)
    with pytest.raises(InputError) as error:
        invoked(animate.command, run_path)
    (problem,) = error.value.problems
    assert problem.message == "a page needs three.js, which comes with trimesh"
    assert problem.hint == "install it with: pip install 'mbproj[animate]'"
    assert not run_path.with_suffix(".html").exists()
