"""The program of a worker (`mbproj.studies.parallel.workers`): reads a function, what calls share, then items."""

from __future__ import annotations

import os
import pickle
import sys
import warnings
from queue import SimpleQueue
from threading import Thread
from typing import Any, BinaryIO

from mbproj.errors import MbprojWarning

#: The first answer: what an item takes counts from there, not from the start of the process.
READY = "ready"


def main() -> None:
    """Says READY, and answers each item with (result, None, notes), or (None, the exception, notes); notes are what
    mbproj warns of, which is for the caller to say."""
    notes = _kept_warnings()
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a function prints is no answer
    messages: SimpleQueue[Any] = SimpleQueue()
    Thread(target=_listen, args=(messages,), daemon=True).start()
    function, shared = messages.get()
    _answer(answers, READY)
    while True:
        item = messages.get()
        result, fault = None, None
        try:
            result = function(shared, item)
        except Exception as error:
            fault = error
        _answer(answers, (result, fault, list(notes)))
        notes.clear()


def _answer(answers: BinaryIO, what: Any) -> None:
    """Says it; where nobody listens any more the process ends."""
    data = pickle.dumps(what)
    try:
        answers.write(data)
        answers.flush()
    except OSError:
        os._exit(0)


def _kept_warnings() -> list[str]:
    """A list to which the texts of mbproj's own warnings go from now on; others are shown as before."""
    kept: list[str] = []
    others = warnings.showwarning

    def take(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if issubclass(category, MbprojWarning):
            kept.append(str(message))
        else:
            others(message, category, *place, **more)

    warnings.showwarning = take
    return kept


def _listen(messages: SimpleQueue[Any]) -> None:
    """Takes in what is sent. Ends the process, whatever it does, when nobody can send any more: when the one who waits
    for results was killed, for example."""
    while True:
        try:
            messages.put(pickle.load(sys.stdin.buffer))
        except (EOFError, OSError, pickle.UnpicklingError):  # a message may end in its middle, too
            os._exit(0)
