"""Simbody, through OpenSim's Python package: a tree in minimal coordinates, loops closed by constraints and projection.

As its documentation advises (https://simbody.github.io): an error-controlled integrator (Runge-Kutta-Merson, OpenSim's
default) with an accuracy, which also sets how far the constraints' projection lets a loop open. Storage, analyses and
the record of states are switched off.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import opensim as osim

from peers.peer import NotConverged, Observation, Peer, Setting, seconds_of, tolerance_label, tolerances
from peers.problem import ACROSS, ALONG, FIVE_BAR, GRAVITY, LENGTH, MASS, Array, Mechanism, SliderCrank

osim.Logger.setLevelString("Error")
#: OpenSim's joints turn about z (pin) and slide along x: this turns z into y.
Z_TO_Y = [-np.pi / 2, 0.0, 0.0]


def _vec(values: Array | list[float] | tuple[float, ...]) -> osim.Vec3:
    return osim.Vec3(*(float(value) for value in values))


def _body(name: str, mass: float, centre: Array | list[float], moments: tuple[float, ...]) -> osim.Body:
    return osim.Body(name, mass, _vec(centre), osim.Inertia(*moments))


def _model() -> osim.Model:
    model = osim.Model()
    model.setGravity(osim.Vec3(0.0, 0.0, -GRAVITY))
    return model


def _chain_model(links: int) -> osim.Model:
    model = _model()
    previous = model.getGround()
    for index in range(links):
        body = _body(f"bar{index}", MASS, [LENGTH / 2, 0.0, 0.0], (ALONG, ACROSS, ACROSS))
        place = [LENGTH if index else 0.0, 0.0, 0.0]
        joint = osim.PinJoint(f"pin{index}", previous, _vec(place), _vec(Z_TO_Y), body, _vec([0, 0, 0]), _vec(Z_TO_Y))
        model.addBody(body)
        model.addJoint(joint)
        previous = body
    return model


def _angles(axes: Array) -> Array:
    """OpenSim's orientation of a frame: turns about its x, y, z in this order, body-fixed."""
    return np.array([np.arctan2(-axes[1, 2], axes[2, 2]), np.arcsin(axes[0, 2]), np.arctan2(-axes[0, 1], axes[0, 0])])


def _slider_crank_model() -> osim.Model:
    S, model = SliderCrank, _model()
    ground, zero = model.getGround(), _vec([0, 0, 0])
    x_as_z = _angles(np.column_stack([[0, 0, -1], [0, 1, 0], [1, 0, 0]]))
    crank = _body("crank", S.CRANK_MASS, [0, 0, 0], S.CRANK_INERTIA)
    slider = _body("slider", S.SLIDER_MASS, [0, 0, 0], S.SLIDER_INERTIA)
    rod = _body("rod", S.ROD_MASS, [-S.ROD_LENGTH / 2, 0, 0], S.ROD_INERTIA)
    # A universal joint turns about x of its first frame, then about y: the rod's pin.
    joints = (
        osim.PinJoint("A", ground, _vec(S.PIVOT), _vec(x_as_z), crank, zero, _vec(x_as_z)),
        osim.SliderJoint("D", ground, _vec(S.SLIDER), zero, slider, zero, zero),
        osim.UniversalJoint("C", slider, zero, _vec(_start_frame()), rod, zero, _vec(_angles(S.ROD_AXES.T @ _frame()))),
    )
    for body in (crank, slider, rod):
        model.addBody(body)
    for joint in joints:
        model.addJoint(joint)
    ball = osim.PointConstraint(crank, _vec([0, 0, S.CRANK_LENGTH]), rod, _vec([-S.ROD_LENGTH, 0, 0]))
    model.addConstraint(ball)
    return model


def _frame() -> Array:
    """Axes of the universal joint at the start: the slider's x, the rod's pin, their normal."""
    x, pin = np.array([1.0, 0.0, 0.0]), SliderCrank.ROD_AXES[:, 1]
    return np.column_stack([x, pin, np.cross(x, pin)])


def _start_frame() -> Array:
    return _angles(_frame())


class _Run:
    """A model, its start, and runs from there."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.tree = mechanism is FIVE_BAR
        self.model = _chain_model(5) if self.tree else _slider_crank_model()
        self.model.finalizeConnections()
        self.start = self.model.initSystem()
        if not self.tree:
            speeds = dict(zip(("A", "D", "C"), self._speeds(), strict=True))
            for joint, values in speeds.items():
                component = self.model.getJointSet().get(joint)
                for index, value in enumerate(values):
                    component.upd_coordinates(index).setSpeedValue(self.start, value)

    @staticmethod
    def _speeds() -> tuple[list[float], list[float], list[float]]:
        slider, about_x, about_pin = SliderCrank.start_velocities()
        return [SliderCrank.SPEED], [slider], [about_x, about_pin]

    def reach(self, accuracy: float, times: Array) -> tuple[float, list[osim.State]]:
        """Seconds of the integration, and the states at the times."""
        manager = osim.Manager(self.model)
        manager.setWriteToStorage(False)
        manager.setPerformAnalyses(False)
        manager.setRecordStatesTrajectory(False)
        manager.setIntegratorMethod(osim.Manager.IntegratorMethod_RungeKuttaMerson)
        manager.setIntegratorAccuracy(accuracy)
        manager.setIntegratorInternalStepLimit(10_000_000)
        manager.initialize(osim.State(self.start))
        states: list[osim.State] = []
        try:
            seconds = seconds_of(lambda: states.extend(osim.State(manager.integrate(float(time))) for time in times))
        except RuntimeError as error:
            raise NotConverged(str(error)) from error
        return seconds, states

    def _place(self, state: osim.State, body: str, point: list[float]) -> Array:
        self.model.realizePosition(state)
        found = self.model.getBodySet().get(body).findStationLocationInGround(state, _vec(point))
        return np.array([found.get(axis) for axis in range(3)])

    def observe(self, accuracy: float, times: Array) -> Observation:
        _, states = self.reach(accuracy, times)
        if self.tree:
            return Observation(np.array([self._place(state, "bar4", [LENGTH, 0, 0])[[0, 2]] for state in states]))
        S = SliderCrank
        openings = [
            np.linalg.norm(
                self._place(state, "crank", [0, 0, S.CRANK_LENGTH]) - self._place(state, "rod", [-S.ROD_LENGTH, 0, 0])
            )
            for state in states
        ]
        points = np.array([self._place(state, "slider", [0, 0, 0])[0] for state in states])
        return Observation(points, float(max(openings)))


def _settings(mechanism: Mechanism) -> Iterator[Setting]:
    run = _Run(mechanism)
    end = np.array([mechanism.duration])
    for accuracy in tolerances(2, 11):

        def integrate(accuracy: float = accuracy) -> float:
            return run.reach(accuracy, end)[0]

        observe: Callable[[], Observation] = partial(run.observe, accuracy, mechanism.times)
        yield Setting(tolerance_label(accuracy), integrate, observe)


PEERS = (Peer("Simbody (OpenSim), Merson", _settings),)
