"""Matrices of blocks that stand in files: `state_space: {of, file}` and `gain: {of, file}`.

A file is read when the scene is, and its numbers take its place. So a results file has them inside, and a run can be
repeated without the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from mbproj.errors import Place, Problem
from mbproj.plain_number import plain_number
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, flow, from_value

#: The matrices that a file gives, by the kind of block that names it.
MATRICES = {"state_space": ("A", "B", "C", "D"), "gain": ("rows",)}
#: Rows and columns of a matrix, and bytes of a file of numbers, at most.
LARGEST, MOST_BYTES = 200, 4_000_000
WROTE = "'mbproj linearize SCENE -o model.h5' writes one"


class _Unfit(Exception):
    """The error of a file that cannot be read: the fault, and a hint."""


def with_matrices(root: MappingNode, scene: Path | None) -> tuple[MappingNode, Mapping[str, str], list[Problem]]:
    """Return the document with the numbers of files in it, these changes as texts by path, as --set takes them, and the
    problems found."""
    signals = root.values.get("signals")
    if not isinstance(signals, MappingNode):
        return root, {}, []
    values, changes, problems = dict(signals.values), dict[str, str](), list[Problem]()
    for name, node in signals.values.items():
        for kind, block in _with_file(node):
            file = block.values["file"]
            try:
                filled = _filled(block, _read(file, kind, scene), file.place)
            except _Unfit as error:
                problems.append(Problem(f"'file' {error.args[0]}", file.place, error.args[1]))
                continue
            assert isinstance(node, MappingNode)
            values[name] = replace(node, values={**node.values, kind: filled})
            changes[f"signals.{name}"] = flow(values[name])
    if not changes:
        return root, {}, problems
    return replace(root, values={**root.values, "signals": replace(signals, values=values)}), changes, problems


def _with_file(node: Node) -> Iterator[tuple[str, MappingNode]]:
    """The kind and the block of a signal that names a file. A block that has numbers as well is refused later, where it
    is read."""
    for kind, matrices in MATRICES.items():
        block = node.values.get(kind) if isinstance(node, MappingNode) else None
        if isinstance(block, MappingNode) and "file" in block.values and block.values.keys().isdisjoint(matrices):
            yield kind, block


def _filled(block: MappingNode, matrices: Mapping[str, object], place: Place) -> MappingNode:
    """The block with these matrices in place of its key `file`."""
    values: dict[str, Node] = {key: node for key, node in block.values.items() if key != "file"}
    values |= {key: from_value(matrix, place) for key, matrix in matrices.items()}
    return MappingNode(values, {key: block.keys.get(key, place) for key in values}, block.place)


def _read(file: Node, kind: str, scene: Path | None) -> Mapping[str, list[list[float]]]:
    if not isinstance(file, ScalarNode) or not file.text.strip():
        raise _Unfit("is no path", "give the path of a file, from the folder of the scene on")
    path = _inside(file.text, scene)
    matrices = _numbers(path) if kind == "gain" else _model(path)
    for name, matrix in matrices.items():
        if max(len(matrix), *map(len, matrix), 0) > LARGEST:
            raise _Unfit(f"has more than {LARGEST} rows or columns in {name}", "reduce the model first")
    return matrices


def _inside(text: str, scene: Path | None) -> Path:
    """The path of the file. Raises _Unfit where it is not in the scene's folder or below: a scene from somebody else
    must not open other files."""
    if scene is None:
        raise _Unfit("needs a scene that is a file itself", "give the matrices in its place")
    folder = scene.parent
    try:
        path, top = (folder / text).resolve(strict=True), folder.resolve()
    except (OSError, RuntimeError, ValueError):
        raise _Unfit(f"'{text}' is not there", f"its path begins at the scene's folder, '{folder}'") from None
    if not path.is_relative_to(top):
        raise _Unfit(f"'{text}' is outside of the scene's folder", f"copy it to '{folder}'")
    if not path.is_file() or path.stat().st_size > MOST_BYTES:
        raise _Unfit(f"'{text}' is no file of at most {MOST_BYTES} bytes", WROTE)
    return path


def _numbers(path: Path) -> Mapping[str, list[list[float]]]:
    """The rows of a text file of numbers with commas or blanks between them. Raises _Unfit where it has other text."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
        cells = [line.replace(",", " ").split() for line in lines if line.strip() and line[0] != "#"]
        rows = [[*map(plain_number, row)] for row in cells]
    except (OSError, ValueError) as error:
        raise _Unfit(f"'{path.name}' is no table of numbers: {error}", "write it with numpy.savetxt, say") from None
    if not rows:
        raise _Unfit(f"'{path.name}' has no numbers", "give a row for each output, a number for each input")
    return {"rows": rows}


def _model(path: Path) -> Mapping[str, list[list[float]]]:
    """The matrices A, B, C, D of a linear model in an HDF5 file. Raises _Unfit where it has none."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return {name: _matrix(file, name) for name in MATRICES["state_space"]}
    except (OSError, KeyError) as error:
        raise _Unfit(f"'{path.name}' is no linear model in HDF5: {error}", WROTE) from None


def _matrix(file: object, name: str) -> list[list[float]]:
    """A matrix of the file. Raises _Unfit for soft or external links, which may lead to another file."""
    import h5py

    assert isinstance(file, h5py.File)
    links = [file.get(path, getlink=True) for path in ("model", f"model/{name}")]
    dataset = file[f"model/{name}"] if all(type(link) is h5py.HardLink for link in links) else None
    if not isinstance(dataset, h5py.Dataset) or dataset.ndim != 2 or dataset.dtype.kind != "f" or dataset.external:
        raise _Unfit(f"'{Path(file.filename).name}' has no matrix {name}", WROTE)
    if max(dataset.shape) > LARGEST:
        raise _Unfit(f"has more than {LARGEST} rows or columns in {name}", "reduce the model first")
    matrix: list[list[float]] = dataset[()].tolist()
    return matrix
