"""A server of one page for one user of this machine: on the loopback interface, behind a token, and nothing else.

A page tells the browser its number. When another page is shown, the browser is told by an event and loads it.
"""

from __future__ import annotations

import json
from hmac import compare_digest
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from secrets import token_urlsafe
from threading import Condition, Thread
from typing import Any, NamedTuple

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

    def log_message(self, format: str, *given: Any) -> None:
        """Print nothing: a line at each save is enough for a user."""
