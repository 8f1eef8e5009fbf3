"""The program of a worker (`mbproj.studies.workers`): reads a function, what its calls share, and then items."""

from __future__ import annotations

import os
import pickle
import sys
from queue import SimpleQueue
from threading import Thread
from typing import Any


def main() -> None:
    """Answers each item with (result, None), or (None, the exception)."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a function prints is no answer
    messages: SimpleQueue[Any] = SimpleQueue()
    Thread(target=_listen, args=(messages,), daemon=True).start()
    function, shared = messages.get()
    while True:
        item = messages.get()
        result, fault = None, None
        try:
            result = function(shared, item)
        except Exception as error:
            fault = error
        pickle.dump((result, fault), answers)
        answers.flush()


def _listen(messages: SimpleQueue[Any]) -> None:
    """Takes in what is sent. Ends the process, whatever it does, when nobody can send any more: when the one who waits
    for results was killed, for example."""
    while True:
        try:
            messages.put(pickle.load(sys.stdin.buffer))
        except EOFError:
            os._exit(0)
