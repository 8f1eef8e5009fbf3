"""The program of a worker (`mbproj.studies.parallel.workers`): it reads a function, the shared data, then items."""

from __future__ import annotations

import os
import pickle
import sys
import warnings
from queue import SimpleQueue
from threading import Thread
from typing import Any, BinaryIO

from mbproj.base.errors import MbprojWarning

#: The first answer. The time of an item counts from it, not from the start of the process.
READY = "ready"


def main() -> None:
    """Answer READY, then each item with (result, None, notes), or (None, the exception, notes). The notes are mbproj's
    warnings, which the caller shows."""
    notes = _collected_warnings()
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # printed text of a function must not mix with the answers
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
    """Send an answer; end the process where nobody reads it any more."""
    data = pickle.dumps(what)
    try:
        answers.write(data)
        answers.flush()
    except OSError:
        os._exit(0)


def _collected_warnings() -> list[str]:
    """A list to which mbproj's own warnings are added from now on; other warnings are shown as before."""
    messages: list[str] = []
    others = warnings.showwarning

    def take(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if issubclass(category, MbprojWarning):
            messages.append(str(message))
        else:
            others(message, category, *place, **more)

    warnings.showwarning = take
    return messages


def _listen(messages: SimpleQueue[Any]) -> None:
    """Put all messages into the queue. End the process, whatever it does, when the sender is gone: it may have been
    killed."""
    while True:
        try:
            messages.put(pickle.load(sys.stdin.buffer))
        except (EOFError, OSError, pickle.UnpicklingError):  # a message may break off, too
            os._exit(0)
