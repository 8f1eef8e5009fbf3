"""Which scenes are meant by paths, and where their results go."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from mbproj.errors import InputError, Problem
from mbproj.studies.batch.result import Task


def scene_paths(paths: Iterable[Path]) -> list[Path]:
    """The files among `paths`, and of each directory its *.yaml, by name, not those of directories in it.

    In the order of `paths`, each once. Raises InputError for a path that is not there or a directory without scenes.
    """
    found: list[Path] = []
    problems: list[Problem] = []
    for path in paths:
        inside = sorted(path.glob("*.yaml")) if path.is_dir() else []
        if not path.exists():
            problems.append(Problem(f"there is no '{path}'", hint="give scene files, or directories of them"))
        elif path.is_dir() and not inside:
            problems.append(Problem(f"'{path}' has no *.yaml in it", hint="directories in it are to be named too"))
        found += inside or [path]
    if problems:
        raise InputError(problems)
    first = {path.resolve(): path for path in reversed(found)}
    return [path for path in dict.fromkeys(found) if first[path.resolve()] == path]


def tasks(scenes: Sequence[Path], directory: Path, keep: bool) -> list[Task]:
    """Each scene with its results file in `directory`: where they stand in several directories, so do their results.

    Raises InputError where a directory cannot be made.
    """
    whole = [scene.resolve() for scene in scenes]
    common = Path(os.path.commonpath([path.parent for path in whole]))
    outputs = [directory / path.relative_to(common).with_suffix(".h5") for path in whole]
    counts = Counter(outputs)  # a.yaml and a.yml are two scenes
    outputs = [
        output.with_name(f"{path.name}.h5") if counts[output] > 1 else output
        for output, path in zip(outputs, whole, strict=True)
    ]
    try:
        for output in outputs:
            output.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = Problem(f"cannot make '{directory}': {error.strerror or error}", hint="choose another directory")
        raise InputError(problem) from error
    return [Task(scene, output, keep) for scene, output in zip(scenes, outputs, strict=True)]
