"""Linear blocks: transfer functions, filters, gains and state spaces, all as x' = A x + B u, y = C x + D u.

lead:    {transfer_function: {of: error, num: [0.1, 1], den: [0.01, 1]}}
smooth:  {filter: {of: pin.angle_dot, time: 10 ms, order: 2}}
force:   {gain: {of: [x, v], file: lqr.csv}}
seen:    {state_space: {of: [u, y], A: [[-1]], B: [[1, 2]], C: [[1]], D: [[0, 0]]}}
"""

from __future__ import annotations

from math import pi, sin
from typing import Any, TypeAlias

from mbproj.dataclass import dataclass
from mbproj.elements.controlled import ScalarState, Signal
from mbproj.functions.standard import reading, weighted
from mbproj.scene.blocks.control.blocks.block import ControlBlock, Expanded, Given, number_of, unit_like
from mbproj.scene.blocks.control.expression import VALUE
from mbproj.scene.blocks.expectations import MEASURE
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.fields.choices import Alternatives
from mbproj.scene.fields.containers import NAME, OneOf, Record
from mbproj.scene.fields.fields import Converted, Field, List, Text
from mbproj.scene.fields.quantities import Integer, Number
from mbproj.scene.fields.reading import Unfit

Row: TypeAlias = tuple[float, ...]
Matrix: TypeAlias = tuple[Row, ...]
#: The highest degree of one transfer function: beyond it, round-off of the coefficients moves the poles too far.
HIGHEST_DEGREE = 10


@dataclass(frozen=True)
class StateSpace(ControlBlock):
    """A state space: x' = A x + B u, y = C x + D u from x = `initial`, with the inputs u = `of`. Several outputs have
    the names `outputs`."""

    of: tuple[Given, ...]
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

        own = self.unit if unit is None else unit
        states = [
            ScalarState(f"{name}.x{at}", combined(*rows), start, self.scale)
            for at, (*rows, start) in enumerate(zip(self.A, self.B, self.initial, strict=True), 1)
        ]
        values = [combined(*rows) for rows in zip(self.C, self.D, strict=True)]
        shown = [f"{name}.{output}" for output in self.outputs] or [name]
        signals = [Signal(each, value, own) for each, value in zip(shown, values, strict=True)]
        return Expanded(tuple(signals), tuple(states))


def _transfer_function(of: Given, num: Row, den: Row, initial: Row | None = None, scale: float = 1.0) -> StateSpace:
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


def _filter(of: Given, time: float, order: int = 1, initial: Value | None = None, scale: float = 1.0) -> StateSpace:
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
    of: tuple[Given, ...],
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
    of: tuple[Given, ...],
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
