"""Plug-ins: entries that other packages add to registries, by an entry point of the group `mbproj.plugins` or a call.

An entry point names a module that registers its entries when it is imported, or a function that does so when it is
called. The search for entry points takes 10 ms, so that names of mbproj itself are found without it.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager
from typing import Generic, TypeVar, final

from mbproj.base.errors import InputError, MbprojError, Place, Problem, warn_once

GROUP = "mbproj.plugins"
Entry = TypeVar("Entry")
#: The module that registered each plug-in, and the checksum of its code, by kind and name.
_origins: dict[tuple[str, str], tuple[str, str]] = {}

_looked_for: set[str] = set()


@final
class Registry(Mapping[str, Entry], Generic[Entry]):
    """Entries by name: those of mbproj, `builtin`, then those of plug-ins in the order of their registration. `kind`
    names an entry in messages, such as "projection method"."""

    def __init__(self, kind: str, builtin: Mapping[str, Entry]) -> None:
        self.kind, self.builtin, self._added = kind, builtin, dict[str, Entry]()

    def add(
        self, name: str, entry: Entry, made_of: Callable[..., object] | str, taken: Container[str] = frozenset()
    ) -> None:
        """Register the entry of a plug-in; `made_of` is its code, or the text of its data. A second entry of the same
        name replaces the first, as when a notebook's cell runs again. Raises InputError where the name is not valid, is
        mbproj's own, or is `taken`."""
        article = "an" if self.kind[0] in "aeiou" else "a"
        if not name.replace("-", "_").isidentifier() or name != name.lower():
            hint = "take small letters, digits and hyphens"
            raise InputError(Problem(f"'{name}' cannot be the name of {article} {self.kind}", hint=hint))
        if name in self.builtin or name in taken:
            raise InputError(Problem(f"mbproj has {article} {self.kind} '{name}' itself", hint="choose another name"))
        self._added[name] = entry
        _origins[self.kind, name] = (_caller() if isinstance(made_of, str) else made_of.__module__, _checksum(made_of))

    @property
    def added(self) -> Mapping[str, Entry]:
        """The entries of plug-ins alone."""
        load_installed()
        return self._added

    def __getitem__(self, name: str) -> Entry:
        if name in self.builtin:
            return self.builtin[name]
        load_installed()
        return self._added[name]

    def __iter__(self) -> Iterator[str]:
        load_installed()
        yield from (*self.builtin, *self._added)

    def __len__(self) -> int:
        load_installed()
        return len(self.builtin) + len(self._added)


def load_installed() -> None:
    """Import the plug-ins of installed packages, once a process. One that fails gives a warning; the others load."""
    if GROUP in _looked_for:  # a plug-in that reads a registry during its import calls this again
        return
    _looked_for.add(GROUP)
    from importlib.metadata import entry_points

    for point in entry_points(group=GROUP):
        try:
            plugin = point.load()
            if inspect.isfunction(plugin):
                plugin()
        except (Exception, SystemExit) as error:  # a plug-in that fails must not stop a run that does not use it
            warn_once(f"the plug-in '{point.name}' ({point.value}) does not work: {type(error).__name__}: {error}")


def installed() -> dict[str, dict[str, str]]:
    """The module of each plug-in, by its kind and name."""
    load_installed()
    modules: dict[str, dict[str, str]] = {}
    for (kind, name), (module, _) in _origins.items():
        modules.setdefault(kind, {})[name] = module
    return modules


def marks() -> list[list[str]]:
    """[kind, name, checksum of the code] of each plug-in, sorted: part of the keys under which results are stored, so
    that a result is used again only with the same code."""
    load_installed()
    return [[*key, checksum] for key, (_, checksum) in sorted(_origins.items())]


@contextmanager
def blamed(what: str, *meant: type[Exception]) -> Iterator[None]:
    """Turn an exception of a plug-in's code into an InputError that names it as `what` and says where it was raised.
    Exceptions of the types `meant` and those of mbproj pass unchanged."""
    try:
        yield
    except (Exception, SystemExit) as error:
        if isinstance(error, (MbprojError, *meant)):
            raise
        code = inspect.getinnerframes(error.__traceback__)[-1] if error.__traceback__ else None
        place = Place(code.filename, code.lineno) if code else None
        message = f"{what}, of a plug-in, has failed: {type(error).__name__}: {error}"
        raise InputError(Problem(message, place)) from error


def _caller() -> str:
    """The name of the module that has called mbproj."""
    frame = sys._getframe()
    while frame.f_back is not None and frame.f_globals["__name__"].partition(".")[0] == "mbproj":
        frame = frame.f_back
    return str(frame.f_globals["__name__"])


def _checksum(code: Callable[..., object] | str) -> str:
    """The SHA-256 of a plug-in's source: of its module, of `code` alone where the module has none, or of `code`'s repr
    where there is no source (in a prompt). A text is hashed as it is."""
    import hashlib  # with OpenSSL it takes 3 ms, which a run without plug-ins does not need

    if isinstance(code, str):
        return hashlib.sha256(code.encode()).hexdigest()
    for origin in (inspect.getmodule(code), code):
        try:
            return hashlib.sha256(inspect.getsource(origin).encode()).hexdigest()  # type: ignore[arg-type]
        except (OSError, TypeError):
            continue
    return hashlib.sha256(repr(code).encode()).hexdigest()
