"""`mbproj watch`: who may see the page, what a save makes of it, and what the browser keeps."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection, HTTPResponse
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from mbproj.commands.watch import Board, Saves, Server, ShownPage, Superseded, build
from mbproj.show.page.write import html, waiting
from tests.pages.browser import MISSING, browser
from tests.support import ROOT

FIVE_BAR = (ROOT / "mechanisms" / "five_bar.yaml").read_text(encoding="utf-8")
#: A shell starts what is in the background without Ctrl-C.
INTERRUPTED_AS_IN_A_TERMINAL = """\
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
from mbproj.cli.main import main
main()
"""
SHORT = {"duration": "0.2", "output_step": "0.02"}


@contextmanager
def served(board: Board) -> Iterator[str]:
    """The address of a server, while it runs."""
    server = Server(board)
    try:
        yield server.address
    finally:
        server.close()


def asked(address: str, path: str | None = None, method: str = "GET", host: str | None = None) -> HTTPResponse:
    """What the server of an address answers to a request for a path."""
    where = urlsplit(address)
    line = HTTPConnection(where.hostname or "", where.port, timeout=10)
    line.request(method, where.path if path is None else path, headers={} if host is None else {"Host": host})
    return line.getresponse()


def news(answer: HTTPResponse) -> dict[str, object]:
    """The next event of a stream."""
    while True:
        line = answer.readline().decode()
        if line.startswith("data: "):
            return json.loads(line.removeprefix("data: "))


@pytest.fixture
def scene(tmp_path) -> Path:
    path = tmp_path / "five_bar.yaml"
    path.write_text(FIVE_BAR, encoding="utf-8")
    return path


def test_the_page_is_served_under_its_token_and_nothing_else():
    board = Board()
    board.show(ShownPage(1, "", b"<p>secret</p>"))
    with served(board) as address:
        where = urlsplit(address)
        token = where.path.strip("/")
        assert (where.hostname, len(token) >= 32) == ("127.0.0.1", True)
        answer = asked(address)
        assert (answer.status, answer.read()) == (200, b"<p>secret</p>")
        assert answer.headers["Cache-Control"] == "no-store"
        assert answer.headers["Server"].strip() == "mbproj"
        refused = ["/", "/events", f"/{token[:-1]}/", f"/{token}x/events", "/../etc/passwd"]
        for path in refused:
            answer = asked(address, path)
            assert (answer.status, b"secret" in answer.read()) == (403, False), path
        for path in (f"/{token}", f"/{token}/results.h5", f"/{token}/../../etc/passwd", f"/{token}/?x=1"):
            assert asked(address, path).status == 404, path
        for method in ("POST", "PUT", "DELETE", "OPTIONS"):
            assert asked(address, method=method).status == 501
        assert asked(address, host="attacker.example").status == 403  # a name that leads here is none of ours
        assert asked(address, host=f"localhost:{where.port}").status == 200


def test_each_server_has_another_token():
    with served(Board()) as first, served(Board()) as second:
        assert urlsplit(first).path != urlsplit(second).path


def test_what_is_shown_is_told_at_once():
    board = Board()
    with served(board) as address:
        stream = asked(address, urlsplit(address).path + "events")
        assert stream.headers["Content-Type"] == "text/event-stream"
        assert news(stream) == {"number": 0, "problem": ""}
        board.show(ShownPage(1, "", b""))
        assert news(stream) == {"number": 1, "problem": ""}
        board.show(board.shown._replace(problem="line 3: <no>"))
        assert news(stream) == {"number": 1, "problem": "line 3: <no>"}


def test_a_save_is_seen_once_it_is_over(tmp_path):
    """Also where an editor replaces the file by another one."""
    path = tmp_path / "scene.yaml"
    path.write_text("a")
    saves = Saves([path])
    assert not saves.have_changed
    path.write_text("ab")
    assert saves.have_changed
    saves.wait()
    assert not saves.have_changed
    (tmp_path / "new").write_text("cd")
    (tmp_path / "new").replace(path)
    saves.wait()
    path.unlink()
    saves.wait()
    assert not saves.have_changed


def test_a_scene_that_cannot_be_run_says_why(scene, tmp_path):
    good = build(scene, {}, SHORT, tmp_path, lambda: False)
    assert (good.page is not None, good.problem, good.files) == (True, "", (scene,))
    assert "five_bar.yaml: 5 degrees of freedom, 0.2 of 0.2 s, joints closed to" in good.line
    scene.write_text(FIVE_BAR.replace("inertia:", "inertai:", 1), encoding="utf-8")
    wrong = build(scene, {}, SHORT, tmp_path, lambda: False)
    assert (wrong.page, "unknown key 'inertai'; did you mean 'inertia'?" in wrong.problem) == (None, True)
    assert wrong.line.endswith("five_bar.yaml: not run")


BREAKS = """\
mbproj: 1
gravity: [0, 0, 0]
bodies: {ball: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
forces: {push: {type: force, body: ball, force: ["exp(exp(t/(100 ms)))", 0, 0]}}
simulation: {duration: 2, step: 0.01}
"""


def test_a_run_that_fails_shows_what_it_computed(tmp_path):
    """Until the force is no number any more."""
    path = tmp_path / "scene.yaml"
    path.write_text(BREAKS, encoding="utf-8")
    found = build(path, {}, {}, tmp_path, lambda: False)
    assert found.problem.startswith("error: stopped at t = 0.59 s: the solution is no longer finite")
    assert found.page is not None
    assert " of 2 s" in found.line


def test_a_save_ends_a_run_that_goes_on(scene, tmp_path):
    with pytest.raises(Superseded):
        build(scene, {}, {}, tmp_path, lambda: True)
    assert build(scene, {}, SHORT, tmp_path, lambda: False).page is not None


def test_the_command_follows_the_file(scene):
    """A page at the start, another at a save; an error keeps it and is told in the page and the terminal."""
    line = [sys.executable, "-c", INTERRUPTED_AS_IN_A_TERMINAL, "watch", str(scene), "--duration", "0.2"]
    process = subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)
    try:
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        stream = asked(address, urlsplit(address).path + "events")
        while (first := news(stream))["number"] != 1:
            assert first["problem"] == ""
        page = asked(address).read()
        assert b"Five-bar" in page and b'"watched":1' in page
        scene.write_text(FIVE_BAR.replace("mbproj: 1", "mbproj: 1\ntilte: x"), encoding="utf-8")
        problem = news(stream)
        assert problem["number"] == 1
        assert "unknown key 'tilte'; did you mean 'title'?" in str(problem["problem"])
        assert asked(address).read() == page
        scene.write_text(FIVE_BAR.replace("Five-bar", "Other"), encoding="utf-8")
        assert news(stream) == {"number": 2, "problem": ""}
        assert b"Other" in asked(address).read()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20)
    finally:
        process.kill()
    assert [line.split(" ", 1)[1].split(",")[0] for line in out.splitlines()] == [
        "five_bar.yaml: 5 degrees of freedom",
        "five_bar.yaml: not run",
        "five_bar.yaml: 5 degrees of freedom",
    ]
    assert (process.returncode, "unknown key 'tilte'" in err, "Traceback" in err) == (130, True, False)


def test_what_cannot_be_watched_is_said(scene, tmp_path):
    line = [sys.executable, "-m", "mbproj", "watch"]
    done = subprocess.run([*line, "-"], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, "'-' is no file that can be watched" in done.stderr) == (2, True)
    with served(Board()) as address:
        port = str(urlsplit(address).port)
        done = subprocess.run([*line, str(scene), "--port", port], capture_output=True, text=True, check=False)
    assert (done.returncode, f"--port: error: port {port} cannot be used" in done.stderr) == (2, True)


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
def test_the_browser_keeps_time_and_camera(scene, tmp_path):
    """Of a page that follows another; and it says what is wrong over what it shows."""

    def page(number: int) -> ShownPage:
        found = build(scene, {}, SHORT, tmp_path, lambda: False).page
        assert found is not None
        return ShownPage(number, "", html(found.title, found.data, found.packer, number).encode())

    board = Board()
    board.show(ShownPage(0, "no such key <b>", waiting("five_bar.yaml").encode()))
    with served(board) as address, browser() as chromium:
        context = chromium.new_context(viewport={"width": 720, "height": 480})
        tab = context.new_page()
        complaints: list[str] = []
        tab.on("console", lambda message: complaints.append(message.text))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.goto(address)
        tab.wait_for_function("() => document.getElementById('problem').textContent === 'no such key <b>'")
        board.show(page(1))
        tab.wait_for_function("() => window.mbproj && window.mbproj.data.watched === 1")
        kept = """() => {
            const { player, eye, data, mode } = window.mbproj;
            const at = eye.target.toArray().map((x, i) => x + data.view.middle[i]);
            return [player.time, player.playing, player.speed, mode, ...eye.back.toArray(), eye.half, ...at];
        }"""
        tab.evaluate("""() => {
            const { player, eye } = window.mbproj;
            player.set(0.12);
            eye.turn(0.4, 0.2);
            eye.zoom(0.7);
            eye.pan(0.1, 0);
            for (const [menu, value] of [["colour", "violation"], ["speed", "0.1"]]) {
              document.getElementById(menu).value = value;
              document.getElementById(menu).onchange();
            }
        }""")
        before = tab.evaluate(kept)
        scene.write_text(FIVE_BAR.replace("Five-bar", "Longer"), encoding="utf-8")
        board.show(page(2))
        tab.wait_for_function("() => window.mbproj && window.mbproj.data.watched === 2")
        assert "Longer" in tab.title()
        assert tab.evaluate(kept) == pytest.approx(before)
        assert before[:4] == [0.12, False, 0.1, "violation"]
        board.show(board.shown._replace(problem="five_bar.yaml:3:1: error"))
        tab.wait_for_function("() => !document.getElementById('problem').hidden")
        assert tab.evaluate("() => window.mbproj.data.watched") == 2
        assert not complaints
        context.close()
