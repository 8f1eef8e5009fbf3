"""The engine of the studies: items go out to workers, and each result is stored under its name as it comes.

A study names its items and a function of each. It gets their results by name, from the store or from workers. So an
interrupted study resumes, and nothing is computed twice.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from mbproj.studies.parallel import hand_out
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent, with_words
from mbproj.studies.store import decoded, encoded, forget, key_of, read, write


class Study:
    """The results of a study by name, of the type `kind` with arrays of these `sizes`; `where` its work is done; and
    `tell`, which is called with a phase, the number of items done, and that of all.

    The key of a study is `what` (any JSON data) and the machine, because results contain times. Without `what` results
    are in memory only; with `fresh` earlier results are dropped."""

    def __init__(
        self,
        what: Any = None,
        kind: Any = Any,
        where: Where = 1,
        fresh: bool = False,
        tell: Tell = silent,
        **sizes: int,
    ) -> None:
        self.where, self.tell = where, tell
        self._key = None if what is None else key_of([platform.node(), what])
        self.results: dict[str, Any] = {}
        if self._key is not None and fresh:
            forget(self._key)
        elif self._key is not None:
            for name, data in read(self._key).items():
                with suppress(ValueError):
                    self.results[name] = decoded(data, kind, **sizes)

    def add(self, name: str, result: Any) -> None:
        """Stores a result; it is on the disk when this returns."""
        self.results[name] = result
        if self._key is not None:
            write(self._key, name, encoded(result))

    def one(self, name: str, compute: Callable[[], Any]) -> Any:
        """The result of this name: as stored, or by `compute` in this process."""
        if name not in self.results:
            self.add(name, compute())
        return self.results[name]

    def each(
        self,
        function: Callable[[Any, Any], Any],
        shared: Any,
        items: Mapping[str, Any],
        phase: str,
        best: Callable[[Any], tuple[Any, str]] | None = None,
        where: Where = None,
    ) -> list[Any]:
        """The results function(shared, item) of all items, whose names are keys of the mapping, in their order.

        `best` returns the rank of a result and words on it; the words of the least rank are added to the phase. `where`
        replaces that of the study."""
        missing = [name for name in items if name not in self.results]
        ranked = [] if best is None else [best(self.results[name]) for name in items if name in self.results]

        def say() -> None:
            done = sum(name in self.results for name in items)
            self.tell(with_words(phase, min(ranked)[1]) if ranked else phase, done, len(items))

        say()
        work = hand_out.in_parallel(function, shared, [items[name] for name in missing], where or self.where)
        for number, result in work:
            self.add(missing[number], result)
            ranked += [] if best is None else [best(result)]
            say()
        return [self.results[name] for name in items]
