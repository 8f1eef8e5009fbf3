"""A process that has imported mbproj, and runs programs in forks of itself: a test need not import it anew.

Requests come as lines of JSON on standard input: the text of a `program`, `folder`, `environment`, and the files `out`
and `err` for the streams. The answer to each is a line with the exit code, negative where a signal ended the program.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import json
import os
import pkgutil
import sys
import tempfile
import traceback
import types
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import mbproj
from mbproj.studies.parallel import hand_out

#: What commands import when they need it, beside mbproj's own modules.
OTHERS = ("matplotlib.backends.backend_agg", "scipy.integrate", "scipy.optimize", "scipy.sparse.linalg", "scipy.stats")


def serve() -> dict[str, Any]:
    """Returns in each fork with the request, which it is to run; ends the server when there is nothing more to do."""
    for request in map(json.loads, sys.stdin):
        child = os.fork()
        if child == 0:
            become(request)
            return request  # type: ignore[no-any-return]
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)
    os._exit(0)


def become(request: dict[str, Any]) -> None:
    """Takes on the folder, the environment and the streams of a request."""
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    ways = {0: (os.devnull, os.O_RDONLY), 1: (request["out"], os.O_WRONLY), 2: (request["err"], os.O_WRONLY)}
    for number, (path, way) in ways.items():
        stream = os.open(path, way)
        os.dup2(stream, number)
        os.close(stream)
    sys.stdin, sys.stdout, sys.stderr = open(0), open(1, "w"), open(2, "w", buffering=1)  # noqa: SIM115
    hand_out.processors = lambda: 1  # the tests take all, and starting a worker takes longer than most studies here
    hand_out.in_parallel = in_this_process


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


def warm_up() -> None:
    """Makes what is made on first use, such as the fields of scenes: it takes half of a short run."""
    from mbproj.commands.main import mbproj as commands

    scene = Path(__file__).parents[2] / "mechanisms" / "five_bar.yaml"
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["run", str(scene), "--duration", "20 ms", "-o", f"{folder}/results.h5", "--quiet"]
        commands.main(arguments, standalone_mode=False)


def run(request: dict[str, Any]) -> int:
    """The program as `python -c` runs it; the exit code."""
    try:
        run_program(request["program"])
    except SystemExit as end:
        return int(end.code or 0)
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


def run_program(text: str) -> None:
    """Runs it as the main module, which imports from its folder."""
    sys.argv, sys.path[:0] = ["-c"], [""]
    sys.modules["__main__"] = module = types.ModuleType("__main__")
    exec(compile(text, "<string>", "exec"), vars(module))


if __name__ == "__main__":
    preload()
    warm_up()
    gc.collect()
    gc.freeze()  # pages that nobody writes to are shared with the forks
    code = run(serve())
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # taking all modules down would take longer than most commands
