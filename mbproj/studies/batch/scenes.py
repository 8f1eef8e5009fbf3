"""The scenes of a batch, found from paths, and the files for their results."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from mbproj.errors import InputError, Problem
from mbproj.outputs import make_folder
from mbproj.studies.batch.run import Task


def scene_paths(paths: Iterable[Path]) -> list[Path]:
    """The scene files that `paths` name: files, patterns (`*`, `?`, `[..]`, `**`: any directories), and directories.
    Not every shell expands patterns. A directory stands for its own *.yaml files, by name, without those of its
    subdirectories.

    The files come in the order of `paths`, each once. Raises InputError for a missing path, and for one without a
    scene.
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
    """A task for each scene, with a results file in `directory`. Scenes in several directories have their results in
    directories of the same names.

    Raises InputError where a directory cannot be made.
    """
    whole = [Path(os.path.realpath(scene)) for scene in scenes]
    common = Path(os.path.commonpath([path.parent for path in whole]))
    outputs = [directory / path.relative_to(common).with_suffix(".h5") for path in whole]
    counts = Counter(outputs)  # a.yaml and a.yml would have the same results file
    outputs = [
        output.with_name(f"{path.name}.h5") if counts[output] > 1 else output
        for output, path in zip(outputs, whole, strict=True)
    ]
    for output in outputs:
        make_folder(output.parent, "choose another directory")
    return [Task(scene, output, keep) for scene, output in zip(scenes, outputs, strict=True)]
