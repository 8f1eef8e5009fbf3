"""The errors of results files, each with a next step."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mbproj.base.errors import ExitCode, InputError, MbprojError, Problem, choose_from, did_you_mean

ELSEWHERE = "choose another file with -o"
#: The hint for a damaged file.
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
    """The error of results that cannot be written (disk full, device gone). OUT.part has all that was flushed
    before."""

    exit_code = ExitCode.FAILED


def cannot_write(path: Path, error: OSError) -> InputError:
    """The error of a results file that cannot be created."""
    return InputError(Problem(f"cannot write '{path}': {error.strerror or error}", hint=ELSEWHERE))


def is_directory(path: Path) -> InputError:
    """The error of a directory where a file is to be written."""
    return InputError(Problem(f"'{path}' is a directory", hint=f"give a file in it, e.g. {path / 'results.h5'}"))


def not_replaced(path: Path) -> InputError:
    """The error of a file that mbproj did not write, where results are to be written."""
    message = f"'{path}' exists and is not a results file of mbproj, so it is not replaced"
    return InputError(Problem(message, hint=f"remove it, or {ELSEWHERE}"))


def not_replaced_for_damage(path: Path) -> InputError:
    """The error of a damaged file where results are to be written: it may be somebody's only copy."""
    message = f"'{path}' exists and cannot be read as results of mbproj, so it is not replaced"
    return InputError(Problem(message, hint=f"remove it if you do not need it, or {ELSEWHERE}"))


def being_written(part: Path, writer: str | None) -> InputError:
    """The error of an OUT.part that another run is writing; `writer` names its process, if known."""
    who = f" ({writer})" if writer else ""
    return InputError(Problem(f"another run{who} is writing '{part}'", hint=f"wait for it, or {ELSEWHERE}"))


def just_begun(part: Path) -> InputError:
    """The error of an OUT.part that has nothing to read yet."""
    return InputError(Problem(f"a run is writing '{part}', and has no samples yet", hint="wait for it"))


def not_ours(path: Path) -> InputError:
    """The error of a file to read that is no results file."""
    hint = "results are what 'mbproj run SCENE' writes"
    return InputError(Problem(f"'{path}' is not a results file of mbproj", hint=hint))


def damaged(path: Path, what: str) -> InputError:
    """The error of a results file whose bytes are wrong."""
    return InputError(Problem(f"'{path}' is damaged: {what}", hint=REPEAT))


def no_such_name(kind: str, name: str, names: Sequence[str], where: str) -> InputError:
    """The error of a name that the results do not have; its hint has the nearest name, or those that exist."""
    if not names:
        return InputError(Problem(f"no {KINDS[kind]} '{name}': {where} has no {kind}"))
    close, listed = did_you_mean(name, names), choose_from("", names, kind)
    return InputError(Problem(f"no {KINDS[kind]} '{name}' in {where}", hint=f"{close} ({listed})" if close else listed))


def status_of(error: BaseException | None) -> str:
    """The status of a run in its file, from the exception that ended it; None: it is complete."""
    if error is None:
        return "complete"
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, MbprojError):
        return f"failed: {error}"
    return f"failed: internal error: {type(error).__name__}: {error}"
