"""Which scenes are meant by paths, and where their results go."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from mbproj.errors import InputError, Problem
from mbproj.outputs import make_folder
from mbproj.studies.batch.result import Task


def scene_paths(paths: Iterable[Path]) -> list[Path]:
    """The files among `paths`, those that a pattern matches (`*`, `?`, `[..]`, `**`: any directories), which not every
    shell looks up, and of each directory its *.yaml, by name, not those of directories in it.

    In the order of `paths`, each once. Raises InputError for what is not there, and for what has or matches no scene.
    """
    found: list[Path] = []
    problems: list[Problem] = []
    for path in paths:
        if path.is_dir():
            inside = sorted(path.glob("*.yaml"))
            wrong = Problem(f"'{path}' has no *.yaml in it", hint=f"for those below it give '{path}/**/*.yaml'")
        elif not path.exists() and any(letter in str(path) for letter in "*?["):
            root = Path(path.anchor)
            inside = sorted(match for match in root.glob(str(path.relative_to(root))) if match.is_file())
            wrong = Problem(f"no file matches '{path}'", hint="give scene files, or directories of them")
        else:
            inside = [path] if path.exists() else []
            wrong = Problem(f"there is no '{path}'", hint="give scene files, or directories of them")
        problems += [] if inside else [wrong]
        found += inside
    if problems:
        raise InputError(problems)
    first = {os.path.realpath(path): path for path in reversed(found)}
    return [path for path in dict.fromkeys(found) if first[os.path.realpath(path)] == path]


def tasks(scenes: Sequence[Path], directory: Path, keep: bool) -> list[Task]:
    """Each scene with its results file in `directory`: where they stand in several directories, so do their results.

    Raises InputError where a directory cannot be made.
    """
    whole = [Path(os.path.realpath(scene)) for scene in scenes]
    common = Path(os.path.commonpath([path.parent for path in whole]))
    outputs = [directory / path.relative_to(common).with_suffix(".h5") for path in whole]
    counts = Counter(outputs)  # a.yaml and a.yml are two scenes
    outputs = [
        output.with_name(f"{path.name}.h5") if counts[output] > 1 else output
        for output, path in zip(outputs, whole, strict=True)
    ]
    for output in outputs:
        make_folder(output.parent, "choose another directory")
    return [Task(scene, output, keep) for scene, output in zip(scenes, outputs, strict=True)]
