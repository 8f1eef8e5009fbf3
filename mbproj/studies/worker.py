"""The program of a worker (`mbproj.studies.workers`): reads a function, what its calls share, and then items."""

from __future__ import annotations

import os
import pickle
import sys


def main() -> None:
    """Answers each item with (result, None), or (None, the exception)."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a function prints is no answer
    try:
        function, shared = pickle.load(sys.stdin.buffer)
    except EOFError:  # the study was interrupted before it had sent them
        return
    while True:
        try:
            item = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        result, fault = None, None
        try:
            result = function(shared, item)
        except Exception as error:
            fault = error
        pickle.dump((result, fault), answers)
        answers.flush()


if __name__ == "__main__":
    main()
