"""Pinocchio from Python: articulated bodies for trees, constrained dynamics for loops, with SciPy's DOP853 or RK4.

Pinocchio computes accelerations and leaves integration to its user (https://github.com/stack-of-tasks/pinocchio):
`aba` for open chains, `initConstraintDynamics` once and then `constraintDynamics` with a 3D contact between the two
bodies for a loop. The loop is not stabilised: nothing is gained by it at these tolerances (gains only add a stiff
term).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp

from peers import problem
from peers.peer import (
    NotConverged,
    Observation,
    Peer,
    Setting,
    ode_label,
    seconds_of,
    steps_per_interval,
    tolerance_label,
    tolerances,
)
from peers.pinocchio_models import chain_model, slider_crank_model
from peers.problem import FIVE_BAR, LENGTH, Array, Mechanism

Derivative = Callable[[float, Array], Array]


class Chain:
    """The open chain as an ODE of (q, v)."""

    def __init__(self, links: int) -> None:
        self.model = chain_model(links)
        self.data, self.zero = self.model.createData(), np.zeros(links)
        self.links, self.start = links, np.zeros(2 * links)

    def derivative(self, t: float, y: Array) -> Array:
        n = self.links
        return np.concatenate((y[n:], pin.aba(self.model, self.data, y[:n], y[n:], self.zero)))

    def measure(self, states: Array) -> Observation:
        tips = []
        for state in states:
            pin.forwardKinematics(self.model, self.data, state[: self.links])
            tips.append(self.data.oMi[self.links].act(np.array([LENGTH, 0.0, 0.0]))[[0, 2]])
        return Observation(np.array(tips))


class SliderCrank:
    """The slider-crank as an ODE of (q, v), its loop kept closed at acceleration level."""

    def __init__(self) -> None:
        self.model, ball, velocities = slider_crank_model()
        self.data, self.zero = self.model.createData(), np.zeros(4)
        self.balls = pin.StdVec_RigidConstraintModel([ball])
        self.ball_data = pin.StdVec_RigidConstraintData([ball.createData()])
        pin.initConstraintDynamics(self.model, self.data, self.balls, self.ball_data)
        self.accuracy = pin.ProximalSettings(1e-14, 0.0, 1)  # the ball's rows are independent: one exact solve
        self.start = np.concatenate((np.zeros(4), velocities))

    def derivative(self, t: float, y: Array) -> Array:
        v = y[4:]
        a = pin.constraintDynamics(
            self.model, self.data, y[:4], v, self.zero, self.balls, self.ball_data, self.accuracy
        )
        return np.concatenate((v, a))

    def measure(self, states: Array) -> Observation:
        openings = []
        for state in states:
            pin.forwardKinematics(self.model, self.data, state[:4])
            ends = [
                self.data.oMi[side].act(place.translation)
                for side, place in (
                    (self.balls[0].joint1_id, self.balls[0].joint1_placement),
                    (self.balls[0].joint2_id, self.balls[0].joint2_placement),
                )
            ]
            openings.append(float(np.linalg.norm(ends[0] - ends[1])))
        return Observation(problem.SliderCrank.SLIDER[0] + states[:, 1], max(openings))


def _rk4(derivative: Derivative, y: Array, h: float, steps: int) -> Array:
    for _ in range(steps):
        k1 = derivative(0.0, y)
        k2 = derivative(0.0, y + 0.5 * h * k1)
        k3 = derivative(0.0, y + 0.5 * h * k2)
        k4 = derivative(0.0, y + h * k3)
        y = y + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    return y


def _system(mechanism: Mechanism) -> Chain | SliderCrank:
    return Chain(5) if mechanism is FIVE_BAR else SliderCrank()


def _dop853(mechanism: Mechanism) -> Iterator[Setting]:
    system = _system(mechanism)
    for tolerance in tolerances(2, 13):
        solve = partial(
            solve_ivp,
            system.derivative,
            (0.0, mechanism.duration),
            system.start,
            "DOP853",
            rtol=tolerance,
            atol=tolerance,
        )

        def observe(solve: Callable[..., object] = solve) -> Observation:
            solution: object = solve(t_eval=mechanism.times)
            if not solution.success:  # type: ignore[attr-defined]
                raise NotConverged(solution.message)  # type: ignore[attr-defined]
            return system.measure(solution.y.T)  # type: ignore[attr-defined]

        yield Setting(tolerance_label(tolerance), partial(seconds_of, solve), observe)


def _fixed(mechanism: Mechanism) -> Iterator[Setting]:
    system = _system(mechanism)
    for per_interval in steps_per_interval(20, 20_000):
        h, total = mechanism.interval / per_interval, per_interval * len(mechanism.times)

        def observe(h: float = h, per_interval: int = per_interval) -> Observation:
            states = [system.start]
            for _ in mechanism.times:
                states.append(_rk4(system.derivative, states[-1], h, per_interval))
            return system.measure(np.array(states[1:]))

        run = partial(_rk4, system.derivative, system.start, h, total)
        yield Setting(ode_label(h), partial(seconds_of, run), observe)


def _chain(chain: problem.Chain) -> Setting:
    system = Chain(chain.links)
    run = partial(_rk4, system.derivative, system.start, chain.step, chain.steps)
    return Setting(ode_label(chain.step), partial(seconds_of, run), lambda: system.measure(run()[None]))


PEERS = (
    Peer("Pinocchio + SciPy DOP853", _dop853),
    Peer("Pinocchio + RK4 in Python", _fixed, _chain),
)
