"""The errors of results files, each with a next step."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mbproj.errors import ExitCode, InputError, MbprojError, Problem
from mbproj.scene.text.suggestions import choose_from, did_you_mean

ELSEWHERE = "choose another file with -o"
#: What to do about a file that is damaged.
REPEAT = "repeat the run"
KINDS = {
    "bodies": "body",
    "markers": "marker",
    "joints": "joint",
    "coordinates": "joint coordinate",
    "forces": "force",
    "motions": "motion",
    "stops": "stop",
    "frictions": "dry friction",
    "states": "state",
    "signals": "signal",
    "tensions": "portion of a rope",
    "touching": "joint on a curve",
}


class OutputError(MbprojError):
    """The results could not be written (disk full, device gone). What was flushed before stays in OUT.part."""

    exit_code = ExitCode.FAILED


def cannot_write(path: Path, error: OSError) -> InputError:
    """A results file that cannot be created."""
    return InputError(Problem(f"cannot write '{path}': {error.strerror or error}", hint=ELSEWHERE))


def is_directory(path: Path) -> InputError:
    """A directory where a file is to be written."""
    return InputError(Problem(f"'{path}' is a directory", hint=f"give a file in it, e.g. {path / 'results.h5'}"))


def not_replaced(path: Path) -> InputError:
    """Somebody else's file where results are to be written."""
    message = f"'{path}' exists and is not a results file of mbproj, so it is not replaced"
    return InputError(Problem(message, hint=f"remove it, or {ELSEWHERE}"))


def not_replaced_for_damage(path: Path) -> InputError:
    """A damaged file where results are to be written: it may be somebody's only copy."""
    message = f"'{path}' exists and cannot be read as results of mbproj, so it is not replaced"
    return InputError(Problem(message, hint=f"remove it if you do not need it, or {ELSEWHERE}"))


def being_written(part: Path, writer: str | None) -> InputError:
    """OUT.part of a run that goes on."""
    who = f" ({writer})" if writer else ""
    return InputError(Problem(f"another run{who} is writing '{part}'", hint=f"wait for it, or {ELSEWHERE}"))


def not_ours(path: Path) -> InputError:
    """A file to read that is something else."""
    hint = "results are what 'mbproj run SCENE' writes"
    return InputError(Problem(f"'{path}' is not a results file of mbproj", hint=hint))


def damaged(path: Path, what: str) -> InputError:
    """A results file whose bytes are wrong."""
    return InputError(Problem(f"'{path}' is damaged: {what}", hint=REPEAT))


def no_such_name(kind: str, name: str, names: Sequence[str], where: str) -> InputError:
    """A name that the results do not have, with the nearest and those there are."""
    if not names:
        return InputError(Problem(f"no {KINDS[kind]} '{name}': {where} has no {kind}"))
    close, listed = did_you_mean(name, names), choose_from("", names, kind)
    return InputError(Problem(f"no {KINDS[kind]} '{name}' in {where}", hint=f"{close} ({listed})" if close else listed))


def status_of(error: BaseException | None) -> str:
    """How a run has ended, as its file says it."""
    if error is None:
        return "complete"
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, MbprojError):
        return f"failed: {error}"
    return f"failed: internal error: {type(error).__name__}: {error}"
