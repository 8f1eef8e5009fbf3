"""Linear blocks: transfer functions, filters, gains and state spaces, all as x' = A x + B u, y = C x + D u.

lead:    {transfer_function: {of: error, num: [0.1, 1], den: [0.01, 1]}}
smooth:  {filter: {of: pin.angle_dot, time: 10 ms, order: 2}}
force:   {gain: {of: [x, v], file: lqr.csv}}
seen:    {state_space: {of: [u, y], A: [[-1]], B: [[1, 2]], C: [[1]], D: [[0, 0]]}}
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import pi, sin
from pathlib import Path
from typing import Any, TypeAlias

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place, Problem
from mbproj.base.text import plain_number
from mbproj.functions.elements import Controller, Held, ScalarState, Signal
from mbproj.functions.program import Program
from mbproj.functions.standard import reading, weighted, within
from mbproj.scene.blocks.expectations import MEASURE
from mbproj.scene.blocks.expression_names import VALUE, unit_name
from mbproj.scene.expressions.dimensions import Inferred, describe
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.expressions.units import BARE
from mbproj.scene.fields.fields import NAME, Alternatives, Converted, Field, List, OneOf, Record, Text
from mbproj.scene.fields.quantities import Integer, Number
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, flow, from_value

# --- Blocks -----------------------------------------------------------------------------------------------------------
# Blocks: signals with states of their own, which the reader replaces by plain signals, states and controllers.


#: An expression and its dimension.
Input: TypeAlias = "tuple[Program, Inferred]"


@dataclass(frozen=True)
class Expanded:
    """The signals, states and controllers that replace a block."""

    signals: tuple[Signal, ...]
    states: tuple[ScalarState, ...] = ()
    controllers: tuple[Controller, ...] = ()


class ControlBlock(ABC):
    """A signal with states of its own."""

    @abstractmethod
    def expanded(self, name: str, unit: str | None) -> Expanded:
        """The signals, states and controllers that replace the block `name`. `unit` is the unit of its value, where the
        scene gives that. Raises Unfit for units that do not fit each other."""


def unit_like(of: Input, unit: str | None, *values: Value | None) -> str:
    """The unit of a block's value that has the dimension of its input `of`: `unit` where it is given, else the SI unit
    of that dimension, or of the `values`. Raises Unfit where the dimensions differ."""
    dimension = None if of[1].certain == BARE else of[1].certain
    for value in values:
        if value is None or value.dimension in (None, BARE):
            continue
        if dimension is not None and value.dimension is not None and not dimension.agrees(value.dimension):
            raise Unfit(f"has an input that is {describe(dimension)}, and a number that is {describe(value.dimension)}")
        dimension = dimension or value.dimension
    return unit_name(dimension) if unit is None else unit


def number_of(value: Value | None, otherwise: float) -> float:
    """The number of a value, or `otherwise` where it is left out."""
    return otherwise if value is None else value.number


# --- Linear blocks ----------------------------------------------------------------------------------------------------


Row: TypeAlias = tuple[float, ...]
Matrix: TypeAlias = tuple[Row, ...]
#: The highest degree of one transfer function: beyond it, round-off of the coefficients moves the poles too far.
HIGHEST_DEGREE = 10


@dataclass(frozen=True)
class StateSpace(ControlBlock):
    """A state space: x' = A x + B u, y = C x + D u from x = `initial`, with the inputs u = `of`. Several outputs have
    the names `outputs`."""

    of: tuple[Input, ...]
    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix
    initial: Row
    scale: float = 1.0
    outputs: tuple[str, ...] = ()
    unit: str = ""

    def expanded(self, name: str, unit: str | None) -> Expanded:
        u = [program for program, _ in self.of]
        x = [reading(f"{name}.x{at}") for at in range(1, len(self.A) + 1)]

        def combined(of_x: Row, of_u: Row) -> Any:
            return weighted([*zip(of_x, x, strict=True), *zip(of_u, u, strict=True)])

        unit = self.unit if unit is None else unit
        states = [
            ScalarState(f"{name}.x{at}", combined(*rows), start, self.scale)
            for at, (*rows, start) in enumerate(zip(self.A, self.B, self.initial, strict=True), 1)
        ]
        values = [combined(*rows) for rows in zip(self.C, self.D, strict=True)]
        shown = [f"{name}.{output}" for output in self.outputs] or [name]
        signals = [Signal(each, value, unit) for each, value in zip(shown, values, strict=True)]
        return Expanded(tuple(signals), tuple(states))


def _transfer_function(of: Input, num: Row, den: Row, initial: Row | None = None, scale: float = 1.0) -> StateSpace:
    """The transfer function in observer form: its first state is the output without the direct term D u. Raises Unfit
    where it has no such form, or a degree above HIGHEST_DEGREE."""
    if den[0] == 0.0:
        raise Unfit("has a 'den' that begins with 0", "the highest power of s stands first: leave the 0 out")
    n = len(den) - 1
    if len(num) > n + 1:
        raise Unfit(
            f"has a 'num' of degree {len(num) - 1} over a 'den' of degree {n}", "it would differentiate: add a lag"
        )
    if n > HIGHEST_DEGREE:
        raise Unfit(f"has the degree {n}, at most {HIGHEST_DEGREE}", "write it as several, one after another")
    a = [each / den[0] for each in den[1:]]
    d, *b = ([0.0] * (n + 1 - len(num))) + [each / den[0] for each in num]
    A = tuple(tuple(-a[i] if j == 0 else float(j == i + 1) for j in range(n)) for i in range(n))
    B = tuple((b[i] - a[i] * d,) for i in range(n))
    C = tuple(float(j == 0) for j in range(n))
    return StateSpace((of,), A, B, (C,), ((d,),), _start(initial, n), scale)


def _start(initial: Row | None, n: int) -> Row:
    if initial is not None and len(initial) != n:
        raise Unfit(f"has {len(initial)} initial values", f"it has {n} states")
    return initial or (0.0,) * n


def _filter(of: Input, time: float, order: int = 1, initial: Value | None = None, scale: float = 1.0) -> StateSpace:
    """Butterworth's low-pass filter: sections of second order, and one of first order where the order is odd. Each
    state has the unit of the signal."""
    n, w, start = order, 1.0 / time, number_of(initial, 0.0)
    A, B, x = [[0.0] * n for _ in range(n)], [[0.0] for _ in range(n)], [0.0] * n

    def follows(row: int, before: int | None) -> None:
        if before is None:
            B[row][0] = w
        else:
            A[row][before] = w

    last: int | None = None
    for pair in range(n // 2):
        at = 2 * pair
        A[at][at + 1], A[at + 1][at] = w, -w
        A[at + 1][at + 1] = -2.0 * w * sin(pi * (2 * pair + 1) / (2 * n))
        follows(at + 1, last)
        x[at], last = start, at
    if n % 2:
        A[n - 1][n - 1] = -w
        follows(n - 1, last)
        x[n - 1], last = start, n - 1
    C = tuple(float(at == last) for at in range(n))
    unit = unit_like(of, None, initial)
    return StateSpace((of,), tuple(map(tuple, A)), tuple(map(tuple, B)), (C,), ((0.0,),), tuple(x), scale, unit=unit)


def _gain(
    of: tuple[Input, ...],
    rows: Matrix | None = None,
    outputs: tuple[str, ...] | None = None,
    file: str | None = None,
) -> StateSpace:
    """The gain y = rows u. A `file` stands here only where it could not be read, which is reported; then zeros stand
    for its numbers. Raises Unfit where sizes do not match."""
    rows = ((0.0,) * len(of),) * len(outputs or "y") if rows is None else rows
    _shaped("rows", rows, None, len(of))
    return StateSpace(of, (), (), ((),) * len(rows), rows, (), outputs=_outputs(outputs, len(rows)))


def _state_space(
    of: tuple[Input, ...],
    A: Matrix | None = None,
    B: Matrix | None = None,
    C: Matrix | None = None,
    D: Matrix | None = None,
    initial: Row | None = None,
    scale: float = 1.0,
    outputs: tuple[str, ...] | None = None,
    file: str | None = None,
) -> StateSpace:
    """The state space of given matrices. A `file` stands here only where it could not be read, which is reported, or
    beside matrices, which is refused. Raises Unfit where matrices are missing or sizes do not match."""
    if file is not None:
        beside = [name for name, each in zip("ABCD", (A, B, C, D), strict=True) if each is not None]
        if beside:
            raise Unfit(f"has a 'file' and '{beside[0]}'", "keep one of them: the file has A, B, C and D")
        return _gain(of, None, outputs, file)
    if A is None or B is None or C is None:
        raise Unfit("lacks A, B or C", "give A, B, C and D, or a 'file' that 'mbproj linearize' wrote")
    n, p, q = len(A), len(of), len(C)
    _shaped("A", A, n, n)
    _shaped("B", B, n, p)
    _shaped("C", C, q, n)
    D = ((0.0,) * p,) * q if D is None else D
    _shaped("D", D, q, p)
    return StateSpace(of, A, B, C, D, _start(initial, n), scale, _outputs(outputs, q))


def _shaped(name: str, matrix: Matrix, rows: int | None, columns: int) -> None:
    for at, row in enumerate(matrix, 1):
        if len(row) != columns:
            raise Unfit(f"has {len(row)} numbers in row {at} of '{name}'", f"it needs {columns}, one a column")
    if rows is not None and len(matrix) != rows:
        raise Unfit(f"has {len(matrix)} rows in '{name}'", f"it needs {rows}")


def _outputs(names: tuple[str, ...] | None, count: int) -> tuple[str, ...]:
    """The names of `count` outputs: those given, else y1, y2, ..; none for a single output, which has the name of the
    block. Raises Unfit where the names are not as many, or not different."""
    if names is None:
        return () if count == 1 else tuple(f"y{at}" for at in range(1, count + 1))
    if len(names) != count:
        raise Unfit(f"has {len(names)} names of outputs", f"it has {count} outputs")
    if len(set(names)) < count:
        raise Unfit("has two outputs of one name", "give each its own")
    return names


def _name(text: str) -> str:
    if not NAME.fullmatch(text) or "-" in text:
        raise Unfit(f"is '{text}', which is no name", "a name has letters, digits and _")
    return text


ROW: Field[Any] = List(Number(None), None)
MATRIX: Field[Any] = List(ROW, None, "rows")
INPUTS: Field[Any] = Alternatives((Converted(VALUE, lambda value: (value,)), List(VALUE, None, "expressions")))
OUTPUTS: Field[Any] = List(Converted(Text(), _name), None, "names")
SCALE = Number(None, above=0.0)

LINEAR_BLOCKS: dict[str, Record[ControlBlock]] = {
    "transfer_function": Record(
        "a transfer function",
        {"of": VALUE, "num": ROW, "den": ROW, "initial": ROW, "scale": SCALE},
        _transfer_function,
        ("of", "num", "den"),
    ),
    "state_space": Record(
        "a state space",
        {
            "of": INPUTS,
            **dict.fromkeys("ABCD", MATRIX),
            "initial": ROW,
            "scale": SCALE,
            "outputs": OUTPUTS,
            "file": Text(),
        },
        _state_space,
        ("of",),
    ),
    "gain": Record(
        "a gain",
        {"of": INPUTS, "rows": MATRIX, "outputs": OUTPUTS, "file": Text()},
        _gain,
        ("of",),
        choices=(OneOf(("rows", "file"), needed=True),),
    ),
    "filter": Record(
        "a filter",
        {
            "of": VALUE,
            "time": Number("s", above=0.0),
            "order": Integer(1, 12),
            "initial": MEASURE,
            "scale": SCALE,
        },
        _filter,
        ("of", "time"),
    ),
}


# --- Blocks that are not linear, or that act at instants --------------------------------------------------------------
# A limited rate, a delay.
# Slow: {rate_limit: {of: wanted, rate: 5 V/s, time: 1 ms}} late: {delay: {of: pin.angle, time: 20 ms, period: 2 ms}}


#: The most samples that a delay may hold.
MOST_SAMPLES = 1000
#: How far a delay may be from a whole number of periods, relative to that number.
ROUND_OFF = 1e-9


@dataclass(frozen=True)
class RateLimit(ControlBlock):
    """A signal y that follows `of` with the rate y' = (of - y)/time, at most `rate` upwards and at most `falling`
    downwards."""

    of: Input
    rate: float
    falling: float
    time: float
    initial: Value | None
    scale: float

    def expanded(self, name: str, unit: str | None) -> Expanded:
        program, y = self.of[0], reading(f"{name}.y")
        wanted = weighted([(1.0 / self.time, program), (-1.0 / self.time, y)])
        unit = unit_like(self.of, unit, self.initial)
        start = number_of(self.initial, 0.0)
        state = ScalarState(f"{name}.y", within(wanted, -self.falling, self.rate), start, self.scale, unit)
        return Expanded((Signal(name, y, unit),), (state,))


@dataclass(frozen=True)
class Delay(ControlBlock):
    """The value that `of` had `count` periods ago, sampled at instants and held in between; `initial` before that."""

    of: Input
    count: int
    period: float
    initial: Value | None

    def expanded(self, name: str, unit: str | None) -> Expanded:
        unit, start = unit_like(self.of, unit, self.initial), number_of(self.initial, 0.0)
        names = [f"x{at}" for at in range(1, self.count + 1)]
        read = [self.of[0], *(reading(f"{name}.{each}") for each in names)]
        states = tuple(Held(each, program, start, unit) for each, program in zip(names, read, strict=False))
        controller = Controller(name, self.period, (Held("value", read[-1], start, unit),), states)
        return Expanded((Signal(name, reading(f"{name}.value"), unit),), controllers=(controller,))


def _rate_limit(
    of: Input, rate: float, time: float, falling: float | None = None, initial: Value | None = None, scale: float = 1.0
) -> RateLimit:
    return RateLimit(of, rate, rate if falling is None else falling, time, initial, scale)


def _delay(of: Input, time: float, period: float, initial: Value | None = None) -> Delay:
    periods = time / period
    count = round(periods)
    if count < 1 or abs(periods - count) > ROUND_OFF * periods:
        raise Unfit(f"delays by {time:g} s, which is {periods:g} periods", "give a whole number of periods, at least 1")
    if count > MOST_SAMPLES:
        raise Unfit(f"keeps {count} values, at most {MOST_SAMPLES}", "give a longer 'period'")
    return Delay(of, count, period, initial)


LIMITED_BLOCKS: dict[str, Record[ControlBlock]] = {
    "rate_limit": Record(
        "a limited rate",
        {
            "of": VALUE,
            "rate": Number(None, above=0.0),
            "time": Number("s", above=0.0),
            "falling": Number(None, above=0.0),
            "initial": MEASURE,
            "scale": Number(None, above=0.0),
        },
        _rate_limit,
        ("of", "rate", "time"),
    ),
    "delay": Record(
        "a delay",
        {"of": VALUE, "time": Number("s", above=0.0), "period": Number("s", above=0.0), "initial": MEASURE},
        _delay,
        ("of", "time", "period"),
    ),
}


# --- Matrices of blocks that stand in files ---------------------------------------------------------------------------
# `state_space: {of, file}` and `gain: {of, file}`.
# A file is read when the scene is, and its numbers take its place. So a results file has them inside, and a run can
# be repeated without the file.


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


# --- Blocks: signals with states of their own, which are replaced by plain signals and states -------------------------
# The reader, the schema and the reference use these tables; the rest of the program sees states, signals and
# controllers alone.


BLOCKS: dict[str, Record[ControlBlock]] = {**LIMITED_BLOCKS, **LINEAR_BLOCKS}
