"""`mbproj watch`: check, run and show a scene again at each save."""

from __future__ import annotations

import json
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import datetime
from hmac import compare_digest
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from itertools import count
from pathlib import Path
from secrets import token_urlsafe
from tempfile import TemporaryDirectory
from threading import Condition, Thread
from time import perf_counter, sleep
from typing import Any, NamedTuple

import click

from mbproj.base.errors import InputError, Place, Problem, SimulationError, message_and_code
from mbproj.commands.kinds import Count
from mbproj.commands.options import Part, explained, option, overrides, parameters, scene_options
from mbproj.commands.report.scene import assembled, checked
from mbproj.results.crash_safety import part_path
from mbproj.results.notes import Note
from mbproj.results.reader import open_own_results
from mbproj.scene.scene import Scene, read_scene
from mbproj.scene.settings import settings_to_run
from mbproj.show.page.pages import PageData, page_of
from mbproj.show.page.write import html, three_js, waiting
from mbproj.studies.record import record_run

EXAMPLES = (
    ("Print the address of a page that follows the file.", "mbproj watch five_bar.yaml"),
    ("Open it in the browser at once, and show the first second.", "mbproj watch five_bar.yaml --open --duration 1"),
)


@explained("watch", EXAMPLES)
@scene_options
@option(Part.OUTPUT, "--open", "opened", is_flag=True, help="Open the page in the browser.")
@option(
    Part.OUTPUT,
    "--port",
    type=Count(0, 65535),
    default=0,
    metavar="N",
    help="Port on this machine [default: a free one].",
)
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print the address and what is wrong, no line at each save.")
def command(scene: str, changes: tuple[str, ...], opened: bool, port: int, quiet: bool, **options: Any) -> None:
    """Runs SCENE each time it is saved, and shows it moving, until Ctrl-C.

    The page is served to this machine alone, at an address with a secret token. It keeps time and camera. Where the
    scene cannot be read or run, the last page stays, with the reason. Extra: pip install 'mbproj[animate]'.
    """

    path = Path(scene)
    if not path.is_file():
        raise InputError(Problem(f"'{scene}' is no file that can be watched", hint="give the file of a scene"))
    board = Board()
    try:
        server = Server(board, port)
    except OSError as error:
        raise InputError(Problem(f"port {port} cannot be used: {error.strerror}", Place("--port"))) from error
    try:
        click.echo(server.address)
        if opened:
            webbrowser.open(server.address)
        follow(path, parameters(changes), overrides(options), board, quiet=quiet)
    finally:
        server.close()


# --- A server of one page for one user of this machine ----------------------------------------------------------------
# On the loopback interface, behind a token, and nothing else.
# A page tells the browser its number. When another page is shown, the browser is told by an event and loads it.


LOOPBACK = "127.0.0.1"
#: The time between two messages to a browser where nothing happens, s. They show when a browser has gone.
HEARTBEAT = 5.0
#: The time limit for reading a request, s.
PATIENCE = 10.0


class ShownPage(NamedTuple):
    """The page for the browser, its number, and the problem that the scene has had since."""

    number: int
    problem: str
    page: bytes


class Board:
    """The page that is shown now. Threads that serve it wait here for the next one."""

    def __init__(self) -> None:
        self._changed, self._versions = Condition(), 0
        self.shown, self.closed = ShownPage(0, "", b""), False

    def show(self, shown: ShownPage) -> None:
        """Show another page from now on."""
        with self._changed:
            self.shown, self._versions = shown, self._versions + 1
            self._changed.notify_all()

    def close(self) -> None:
        """End the waits of all threads."""
        with self._changed:
            self.closed = True
            self._changed.notify_all()

    def wait_for_change(self, version: int) -> tuple[int, ShownPage] | None:
        """Wait until the shown page has another version than `version`; return its version and the page. None where
        that takes too long."""
        with self._changed:
            if not self._changed.wait_for(lambda: self.closed or self._versions != version, HEARTBEAT):
                return None
            return self._versions, self.shown


class Server:
    """A server that serves a board until it is closed; `address` includes the token."""

    def __init__(self, board: Board, port: int = 0) -> None:
        """Raises OSError where the port is taken."""
        self.board, self._token = board, token_urlsafe(24)
        self._http = _Http((LOOPBACK, port), _Handler)
        self._http.board, self._http.token = board, self._token
        Thread(target=self._http.serve_forever, kwargs={"poll_interval": 0.1}, daemon=True).start()

    @property
    def address(self) -> str:
        """The address of the page."""
        return f"http://{LOOPBACK}:{self._http.server_port}/{self._token}/"

    def close(self) -> None:
        """End all threads."""
        self.board.close()
        self._http.shutdown()
        self._http.server_close()


class _Http(ThreadingHTTPServer):
    daemon_threads, block_on_close, allow_reuse_address = True, False, False
    board: Board
    token: str

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a browser that leaves in the middle of an answer."""


class _Handler(BaseHTTPRequestHandler):
    server: _Http
    server_version, sys_version, timeout = "mbproj", "", PATIENCE
    #: The text of an error message.
    error_message_format, error_content_type = "%(code)d %(message)s\n", "text/plain; charset=utf-8"

    def do_GET(self) -> None:
        port = self.server.server_port
        # Refuse other host names: another site may have made its name point to this machine.
        known = self.headers.get("Host") in (f"{LOOPBACK}:{port}", f"localhost:{port}")
        parts = self.path.split("/")
        may = len(parts) > 1 and compare_digest(parts[1].encode(), self.server.token.encode())
        if not known or not may:
            self.send_error(HTTPStatus.FORBIDDEN, "the address that mbproj watch has printed is needed")
        elif parts[2:] == [""]:
            self._page()
        elif parts[2:] == ["events"]:
            self._events()
        else:
            self.send_error(HTTPStatus.NOT_FOUND, "nothing else is served")

    def _start(self, kind: str) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("X-Frame-Options", "DENY")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.end_headers()

    def _page(self) -> None:
        self._start("text/html; charset=utf-8")
        self.wfile.write(self.server.board.shown.page)

    def _events(self) -> None:
        """Send the number of the page and its problem, now and at each change."""
        self._start("text/event-stream")
        version, board = -1, self.server.board
        while not board.closed:
            update = board.wait_for_change(version)
            if update is None:
                self.wfile.write(b":\n\n")
                continue
            version, shown = update
            said = json.dumps({"number": shown.number, "problem": shown.problem})
            self.wfile.write(f"data: {said}\n\n".encode())

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing: a line at each save is enough for a user."""


# --- The loop of `mbproj watch` ---------------------------------------------------------------------------------------
# Build at each save, then show the result in the browser and the terminal.
# A save is detected by a file's time, size and place on the disk, checked ten times a second.


#: The time between two checks, s. A save is over when two checks agree: some editors write in pieces.
LOOK = 0.05


class Saves:
    """The state of some files. `have_changed` tells whether it has changed since it was last taken."""

    def __init__(self, files: Iterable[Path]) -> None:
        self.files = tuple(files)
        self._taken = self._states()

    def take(self) -> None:
        """Take the current state of the files as known."""
        self._taken = self._states()

    def follow(self, files: Iterable[Path]) -> None:
        """Watch these files from now on. The known state of files already watched stays."""
        known = dict(zip(self.files, self._taken, strict=True))
        self.files = tuple(files)
        self._taken = tuple(known.get(path) or _state(path) for path in self.files)

    @property
    def have_changed(self) -> bool:
        """Whether a file has been saved since."""
        return self._states() != self._taken

    def wait(self) -> None:
        """Wait until a file is saved, and take its new state."""
        before = self._taken
        while True:
            sleep(LOOK)
            now = self._states()
            if now != self._taken and now == before:
                self._taken = now
                return
            before = now

    def _states(self) -> tuple[tuple[int, ...], ...]:
        return tuple(map(_state, self.files))


def _state(path: Path) -> tuple[int, ...]:
    """The state of a file; empty where it is missing, as an editor may be about to replace it."""
    try:
        status = path.stat()
    except OSError:
        return ()
    return status.st_mtime_ns, status.st_size, status.st_ino


def follow(path: Path, parameters: Mapping[str, str], options: Mapping[str, str], board: Board, *, quiet: bool) -> None:
    """Show the scene at each save, without end. Raises InputError where pages cannot be made here."""
    three_js()
    board.show(ShownPage(0, "", waiting(path.name).encode()))
    saves, numbers = Saves([path]), count(1)
    with TemporaryDirectory(prefix="mbproj-watch-") as folder:
        while True:
            try:
                built = build(path, parameters, options, Path(folder), lambda: saves.have_changed)
            except Superseded:
                saves.take()
                continue
            _tell(built, quiet=quiet)
            board.show(_next(board.shown, built, numbers))
            saves.follow(built.files or saves.files)
            saves.wait()


def _next(shown: ShownPage, built: Built, numbers: count[int]) -> ShownPage:
    """The new page, or the last page with the current problem."""
    if built.page is None:
        return shown._replace(problem=built.problem)
    number = next(numbers)
    page = html(built.page.title, built.page.data, built.page.packer, number)
    return ShownPage(number, built.problem, page.encode())


def _tell(built: Built, *, quiet: bool) -> None:
    if not quiet:
        click.echo(built.line)
        for note in built.notes:
            click.echo(note, err=True)
    if built.problem:
        click.echo(built.problem, err=True)


class Superseded(Exception):
    """The exception where the scene was saved again while it ran."""


class Built(NamedTuple):
    """The result of a save: a line on it, the page if there is one, the problem, and notes on possible mistakes.
    `files` are the files that the scene was read from, as far as they could be read."""

    line: str
    page: PageData | None
    problem: str = ""
    notes: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()


def build(
    path: Path,
    parameters: Mapping[str, str],
    options: Mapping[str, str],
    folder: Path,
    interrupted: Callable[[], bool],
) -> Built:
    """Read, check and run the scene; results go into `folder`. A run that fails gets a page of its samples so far.
    Raises Superseded as soon as `interrupted` returns True."""
    began, files = perf_counter(), tuple[Path, ...]()
    try:
        what = read_scene(str(path), parameters, options)
        files = (path, *_meshes(what, path.parent))
        page, said, notes, problem = _ran(what, path, folder / f"{path.stem}.h5", interrupted)
    except Superseded:
        raise
    except Exception as error:  # any error is shown: the next save may remove its cause
        message, _ = message_and_code(error)
        return Built(f"{_time()} {path.name}: not run", None, message, files=files)
    return Built(f"{_time()} {path.name}: {said}, {perf_counter() - began:.2f} s", page, problem, notes, files)


def _meshes(what: Scene, folder: Path) -> Iterator[Path]:
    for body in what.bodies:
        if body.appearance is not None and body.appearance.mesh is not None:
            yield folder / body.appearance.mesh.file


def _time() -> str:
    return datetime.now().strftime("%H:%M:%S")


def _ran(
    what: Scene, path: Path, results: Path, interrupted: Callable[[], bool]
) -> tuple[PageData, str, tuple[str, ...], str]:
    """Run the scene; return its page, a line on the run, notes, and the reason why it ended early."""
    checked_scene = checked(what, *assembled(what))
    if not checked_scene.can_run:
        raise InputError(list(checked_scene.problems))

    def progress(time: float) -> None:
        if interrupted():
            raise Superseded

    problem, violation = "", ""
    notes = [Note.on(note) for note in checked_scene.notes]
    for left in (results, part_path(results)):  # the writer would check a file that it replaces
        left.unlink(missing_ok=True)
    try:
        run = record_run(what, results, progress=progress)
        notes += run.notes
        violation = f", joints closed to {run.attributes['position_violation_max']:.1e}"
    except SimulationError as error:
        if error.output is None:
            raise
        problem, _ = message_and_code(error)
    with open_own_results(results) as opened:
        page = page_of([opened], [path.stem])
        until = float(opened.time[-1])
    freedoms = checked_scene.degrees_of_freedom
    free = "" if freedoms is None else f"{freedoms} degree{'s' * (freedoms != 1)} of freedom, "
    said = f"{free}{until:.4g} of {settings_to_run(what).duration:.4g} s{violation}"
    return page, said, tuple(dict.fromkeys(map(str, notes))), problem
