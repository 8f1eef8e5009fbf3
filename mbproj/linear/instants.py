"""Small motions of a mechanism with sampled controllers: their change from one round of instants to the next.

Between instants x' = A x, in which the controllers' outputs are constant. At an instant x⁺ = J x: outputs depend on
values just before it. A round is the shortest time after which all instants recur. Over it x changes by the product of
all exp(A Δt) and J (Franklin, Powell and Workman 1998). The motion dies away where all eigenvalues are below 1.
"""

from __future__ import annotations

from fractions import Fraction
from math import lcm

import numpy as np

from mbproj.base.arrays import Array, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.derivatives import row_motion, slopes_by_channels
from mbproj.linear.kinks import refuse_bends
from mbproj.linear.reference import LinearReference
from mbproj.linear.state_space import LinearModel, Outputs, assembled, inputs_named
from mbproj.model.channels import Actions, ChannelKind


@dataclass(frozen=True, eq=False)
class Round:
    """The change over a round of instants: `matrix` (x, x), of the linear model's states by their scales, in `time`
    s."""

    matrix: Array
    time: float

    @property
    def multipliers(self) -> Numbers:
        """The factors of small motions in a round, the largest first."""
        eigenvalues = np.linalg.eigvals(self.matrix)
        return np.asarray(eigenvalues[np.argsort(-np.abs(eigenvalues), kind="stable")])


def round_of(reference: LinearReference) -> Round:
    """Return the round of a mechanism at rest. Raises InputError where it has no controller or no linear part there, or
    where periods have no common multiple. Raises it also where `linearize` has no model of the mechanism."""
    system = reference.system
    if not system.actions.size:
        raise InputError(Problem("the scene has no controller", hint="`mbproj modes` knows its small motions"))
    refuse_bends(reference)
    model = assembled(reference, inputs_named(reference, []), _set_by(reference))
    first, scale = len(model.A) - system.states.size, np.ones(len(model.A))
    scale[first:] = system.states.scale
    A = model.A * scale / scale[:, None]
    jumps = [
        _jump(model, system.actions, action, first) * scale / scale[:, None] for action in range(system.actions.size)
    ]
    time = _common(system.actions.period)
    return Round(_product(A, jumps, _instants(system.actions, time), time), time)


def _set_by(reference: LinearReference) -> Outputs:
    """Return the values that actions give to states, as outputs of the linear model."""
    system, motion = reference.system, reference.motion
    actions, channels, count = system.actions, system.channels, len(reference.system.actions.state)
    instant, rows = motion.instant(system), row_motion(system.coordinates, motion.carried())
    slopes = np.array([slopes_by_channels(actions.programs, entry, instant.values()) for entry in range(count)])
    by = {
        kind: slopes @ ((channels.kind == kind)[:, None] & (channels.index[:, None] == np.arange(size))).astype(float)
        for kind, size in (
            (ChannelKind.COORDINATE, system.coordinates.size),
            (ChannelKind.RATE, system.coordinates.size),
            (ChannelKind.STATE, system.states.size),
        )
    }
    G, G_dot = rows.G.dense(), rows.G_dot.dense()
    return Outputs(
        tuple(system.names.states[state] for state in actions.state),
        tuple(system.names.state_units[state] for state in actions.state),
        by[ChannelKind.COORDINATE] @ G + by[ChannelKind.RATE] @ G_dot,
        by[ChannelKind.RATE] @ G,
        np.zeros((count, system.joints.size)),
        by[ChannelKind.STATE],
    )


def _jump(model: LinearModel, actions: Actions, action: int, first: int) -> Array:
    """Return J of an action, which sets all its states at once."""
    jump, entries = np.eye(len(model.A)), list(actions.sets(action))
    jump[first + actions.state[entries]] = model.C[entries]
    return jump


def _common(period: Array) -> float:
    """Return the shortest time that is a multiple of all periods, in s."""
    shortest = float(period.min())
    ratios = [Fraction(each / shortest).limit_denominator(THRESHOLDS.largest_ratio) for each in period.tolist()]
    off = max(abs(float(ratio) * shortest / each - 1.0) for ratio, each in zip(ratios, period.tolist(), strict=True))
    unit = lcm(*(ratio.denominator for ratio in ratios))
    times = lcm(*(int(ratio * unit) for ratio in ratios))
    if off > THRESHOLDS.same_written or sum(times / float(ratio * unit) for ratio in ratios) > THRESHOLDS.most_of_round:
        said = f"the periods {', '.join(f'{each:.6g} s' for each in np.unique(period))} have no short common multiple"
        raise InputError(Problem(said, hint="give periods that are multiples of each other"))
    return shortest * times / unit


def _instants(actions: Actions, time: float) -> list[tuple[float, list[int]]]:
    """Return the instants of a round that begins with the last controller's first, each with its actions in order."""
    begin, near = float(actions.first.max()), THRESHOLDS.same_written * float(actions.period.min())
    instants: list[tuple[float, list[int]]] = []
    for at, due in sorted(actions.instants(begin, begin + time - 2.0 * near, near).items()):
        if instants and at - begin - instants[-1][0] <= near:
            instants[-1][1].extend(due)
        else:
            instants.append((at - begin, [*due]))
    return [(at, sorted(due)) for at, due in instants]


def _product(A: Array, jumps: list[Array], instants: list[tuple[float, list[int]]], time: float) -> Array:
    """Return the matrix of the change over a round."""
    from scipy.linalg import expm

    product, known = np.eye(len(A)), dict[float, Array]()
    ends = [*(at for at, _ in instants[1:]), time]
    for (at, actions), end in zip(instants, ends, strict=True):
        for action in actions:
            product = jumps[action] @ product
        gap = float(f"{end - at:.12g}")
        known[gap] = known[gap] if gap in known else expm(A * gap)
        product = known[gap] @ product
    return product
