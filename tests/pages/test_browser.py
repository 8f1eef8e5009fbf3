"""The page in a real browser: it draws, it moves, it asks for nothing, it answers keys and fingers, it can be read."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.results.reader import open_results
from mbproj.scene.scene import read_scene_text
from mbproj.show.page.pages import page_of
from mbproj.show.page.write import html
from tests.crossed import full
from tests.pages.browser import LAPTOP, MISSING, PHONE, SMALL, Opened, browser
from tests.pages.runs import HOSTILE, five_bar, recorded

pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING or "there is a browser")


def written(folder, name, results, labels):
    """A page of results, as a file."""
    page = page_of(results, labels)
    path = folder / f"{name}.html"
    path.write_text(html(page.title, page.data, page.packer), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def chromium():
    with browser() as opened:
        yield opened


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("browser")


@pytest.fixture(scope="module")
def results(folder):
    with open_results(five_bar(folder / "five_bar.h5", duration=3)) as opened:
        yield opened


@pytest.fixture(scope="module")
def path(folder, results):
    return written(folder, "five_bar", [results], ["five bars"])


@pytest.fixture(scope="module")
def shown(chromium, path):
    page = Opened(chromium, path, SMALL)
    yield page
    page.close()


def test_it_draws_with_live_graphics_and_asks_for_nothing(shown, path):
    assert shown.run("return page.renderer.getContext().isContextLost()") is False
    assert shown.run("return page.renderer.getContext().getParameter(7938)").startswith("WebGL 2")
    assert shown.requests == [path.as_uri()]
    assert shown.complaints == []
    colours = np.frombuffer(shown.pixels(), np.uint8).reshape(-1, 3)
    assert len(np.unique(colours, axis=0)) > 50


def test_scrubbing_moves_pixels_and_comes_back(shown):
    shown.at(0.0)
    before = shown.pixels()
    slider = shown.page.locator("#time")
    slider.evaluate("(it) => { it.value = 5000; it.dispatchEvent(new Event('input')); }")
    shown.settle()
    assert shown.run("return page.player.time") == pytest.approx(1.5)
    assert shown.pixels() != before
    shown.at(0.0)
    assert shown.pixels() == before


def test_bodies_are_where_the_file_has_them(shown, results):
    times = shown.run("return Array.from({ length: page.runs[0].frames }, (_, row) => page.runs[0].time(row))")
    for row in (0, len(times) // 3, len(times) - 1):
        sample = int(np.argmin(np.abs(results.time - times[row])))
        shown.at(times[row])
        script = """
            const { middle } = page.data.view;
            return page.shown[0].figure.bodies.map((body) => body.position.toArray().map((x, i) => x + middle[i]));
        """
        there = np.array(shown.run(script))
        assert np.abs(there - results["bodies/position"][sample]).max() <= 5.0 * 2.0**-23
        marker = shown.run("return page.shown[0].trails.items[0].mesh.position.toArray()")
        tip = np.array(marker) + shown.run("return page.data.view.middle")
        assert np.abs(tip - results["markers/position"][sample, 0]).max() <= 1e-5  # orientations have 19 digits


def test_keys_play_step_and_turn(shown):
    shown.at(0.0)
    press = shown.page.keyboard.press
    shown.page.locator("#scene").click(position={"x": 5, "y": 200})
    press("ArrowRight")
    assert shown.run("return page.player.time") == pytest.approx(shown.run("return page.runs[0].time(1)"))
    press("End")
    assert shown.run("return page.player.time") == pytest.approx(3.0)
    press("Home")
    press("Space")
    shown.page.wait_for_function("() => window.mbproj.player.time > 0.02")
    press("Space")
    assert shown.run("return page.player.playing") is False
    shown.run("page.player.set(0)")
    shown.settle()
    before = shown.pixels()
    press("4")  # from the right: a line
    shown.settle()
    assert shown.run("return page.eye.back.toArray()") == pytest.approx([1, 0, 0])
    assert shown.pixels() != before
    press("0")
    shown.settle()
    assert shown.pixels() == before


def test_a_click_shows_the_numbers_of_the_file(shown, results):
    row = shown.run("return page.runs[0].rowAt(1.0).row")
    time = shown.run("return page.runs[0].time(given)", row)
    shown.at(time)
    shown.run("page.select({ kind: 'joints', name: 'C', run: 0 })")
    shown.settle()
    text = shown.page.locator("#panel").inner_text()
    sample = int(np.argmin(np.abs(results.time - time)))
    angle = results.coordinate("C.angle").value[sample]
    assert "C (revolute)" in text
    assert f"{angle:.4f}".rstrip("0")[:6] in text
    shown.page.get_by_role("button", name="close the numbers").click()
    assert shown.page.locator("#panel").is_hidden()


def test_colours_of_violation_change_the_picture_and_say_what_they_mean(shown):
    shown.at(1.0)
    before = shown.pixels()
    shown.page.locator("#colour").select_option("violation")
    shown.settle()
    assert shown.pixels() != before
    assert "m or rad" in shown.page.locator("#scale").inner_text()
    shown.page.locator("#colour").select_option("bodies")


def test_every_control_has_a_name(shown):
    script = """
        const bare = [...document.querySelectorAll("button, select, input, summary, canvas")].filter((each) =>
            !(each.getAttribute("aria-label") || each.textContent.trim() || each.labels?.length
              || each.getAttribute("aria-hidden")));
        return bare.map((each) => each.outerHTML);
    """
    assert shown.run(script) == []


@pytest.mark.parametrize("size", [full(LAPTOP), PHONE], ids=["laptop", "phone"])
def test_it_can_be_read(chromium, path, size):
    page = Opened(chromium, path, size, touch=size is PHONE)
    script = """
        const boxes = [...document.querySelectorAll("#controls > *, #title, #time, #chart, #scene")]
            .filter((each) => each.offsetParent && each.clientWidth).map((each) => each.getBoundingClientRect());
        const texts = [...document.querySelectorAll("button, select, #title, #clock")];
        return {
            outside: boxes.filter((box) => box.left < 0 || box.right > innerWidth || box.bottom > innerHeight).length,
            smallest: Math.min(...texts.map((each) => parseFloat(getComputedStyle(each).fontSize))),
            scene: document.getElementById("scene").clientHeight / innerHeight,
        };
    """
    found = page.run(script)
    assert found["outside"] == 0
    assert found["smallest"] >= 12
    assert found["scene"] >= 0.45
    page.close()


@pytest.mark.full
def test_fingers_turn_and_zoom(chromium, path):
    page = Opened(chromium, path, PHONE, touch=True)
    touch = page.context.new_cdp_session(page.page)

    def fingers(kind, *places):
        points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    before = page.run("return page.eye.back.toArray()")
    fingers("touchStart", (200, 300))
    for x in (220, 250, 280):
        fingers("touchMove", (x, 320))
    fingers("touchEnd")
    assert np.linalg.norm(np.array(page.run("return page.eye.back.toArray()")) - before) > 0.1
    half = page.run("return page.eye.half")
    fingers("touchStart", (150, 300), (250, 300))
    for spread in (20, 40, 60):
        fingers("touchMove", (150 - spread, 300), (250 + spread, 300))
    fingers("touchEnd")
    assert page.run("return page.eye.half") < 0.7 * half
    page.close()


def test_a_title_that_is_markup_is_shown_as_text(chromium, folder):
    scene = read_scene_text(HOSTILE, "hostile.yaml")
    with open_results(recorded(scene, folder / "hostile.h5")) as results:
        page = Opened(chromium, written(folder, "hostile", [results], ["<b>run</b>"]))
    assert page.page.locator("#title").inner_text() == scene.title
    assert page.page.title() == scene.title
    assert page.page.locator("script").count() == 4
    assert page.complaints == []
    page.close()


@pytest.mark.full
def test_a_second_run_is_a_ghost_and_its_distance_is_charted(chromium, folder, results):
    with open_results(five_bar(folder / "open.h5", duration=3, projection="none", step=0.02)) as other:
        page = Opened(chromium, written(folder, "both", [results, other], ["closed", "open"]))
        page.at(2.0)
        name = "tip, open: distance"
        assert name in page.run("return [...page.chart.choices.keys()]")
        found = page.run(
            "const [line] = page.chart.choices.get(given).lines; const run = page.runs[line.run];"
            "return run.value(line.group, line.column, run.rowAt(2.0))",
            name,
        )
        tips = [each.marker("tip").position[np.argmin(np.abs(each.time - 2.0))] for each in (results, other)]
        assert found == pytest.approx(np.linalg.norm(tips[0] - tips[1]), abs=2e-5)
        page.run("page.runs[1].from = 1.5")  # as that of a better solution
        shown = []
        for time in (1.4, 1.6):
            page.at(time)
            shown.append(page.run("return page.shown[1].root.visible"))
        page.page.locator("#more summary").click()
        page.page.get_by_label("Ghosts").uncheck()
        page.settle()
        assert [*shown, page.run("return page.shown[1].root.visible")] == [False, True, False]
        assert page.complaints == []
    page.close()
