"""A process that has imported mbproj, and runs command lines in forks of itself: a test need not import it anew.

Requests come as lines of JSON on standard input: `arguments`, `folder`, `environment`, and the files `out` and `err`
for the streams. The answer to each is a line with the exit code, negative where a signal ended the command.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import json
import os
import pkgutil
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import mbproj
from mbproj.studies.parallel import bundles, hand_out

#: What commands import when they need it, beside mbproj's own modules.
OTHERS = ("matplotlib.backends.backend_agg", "scipy.integrate", "scipy.optimize", "scipy.sparse.linalg", "scipy.stats")


def serve() -> None:
    """Returns in each fork, which is to run the command line, and in the server when there is nothing more to do."""
    for request in map(json.loads, sys.stdin):
        child = os.fork()
        if child == 0:
            become(request)
            return
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)
    os._exit(0)


def become(request: dict[str, Any]) -> None:
    """Takes on the folder, the environment, the streams and the arguments of a request."""
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    ways = {0: (os.devnull, os.O_RDONLY), 1: (request["out"], os.O_WRONLY), 2: (request["err"], os.O_WRONLY)}
    for number, (path, way) in ways.items():
        stream = os.open(path, way)
        os.dup2(stream, number)
        os.close(stream)
    sys.stdin, sys.stdout, sys.stderr = open(0), open(1, "w"), open(2, "w", buffering=1)  # noqa: SIM115
    sys.argv = ["mbproj", *request["arguments"]]
    hand_out.processors = lambda: 1  # the tests take all, and starting a worker takes longer than most studies here
    bundles.in_parallel = in_this_process


def in_this_process(
    function: Callable[[Any, Any], Any], shared: Any, items: Iterable[Any], *_: object
) -> Iterator[tuple[int, Any]]:
    """`in_parallel` without another process, also where an item may be lost."""
    return hand_out.in_parallel(function, shared, items, 1)


def preload() -> None:
    """Imports all modules of mbproj but the kernel's extension, which commands load themselves."""
    for name in OTHERS:
        importlib.import_module(name)
    for module in pkgutil.walk_packages(mbproj.__path__, "mbproj."):
        if "._core" not in module.name:
            importlib.import_module(module.name)


def run() -> int:
    """The command line as `mbproj` runs it; the exit code."""
    from mbproj.cli import main

    try:
        main()
    except SystemExit as end:
        return int(end.code or 0)
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


if __name__ == "__main__":
    preload()
    gc.collect()
    gc.freeze()  # pages that nobody writes to are shared with the forks
    serve()
    code = run()
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # taking all modules down would take longer than most commands
