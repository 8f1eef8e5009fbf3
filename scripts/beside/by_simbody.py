"""Simbody, through OpenSim's Python package: a tree in minimal coordinates, loops closed by constraints and projection.

As its documentation advises (https://simbody.github.io): an error-controlled integrator (Runge-Kutta-Merson, OpenSim's
default) with an accuracy, which also sets how far the constraints' projection lets a loop open. Storage, analyses and
the record of states are switched off.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from time import process_time

import numpy as np
import opensim as osim

from mbproj.formats.export.tree import TreeBranch

from .problem import Array, NotDone, Outcome, Problem, Program, Setting, opening, tolerance_label, tolerances

osim.Logger.setLevelString("Error")


def _vec(values: Array | Sequence[float]) -> osim.Vec3:
    return osim.Vec3(*(float(value) for value in values))


def _angles(axes: Array) -> osim.Vec3:
    """OpenSim's orientation of a frame: turns about its x, y, z in this order, body-fixed."""
    return _vec([np.arctan2(-axes[1, 2], axes[2, 2]), np.arcsin(axes[0, 2]), np.arctan2(-axes[0, 1], axes[0, 0])])


def _frame(kinds: list[str], axes: list[Array]) -> Array:
    """The frame of a joint, with z along a pin, x along a slider, x and y along the axes of a universal joint."""
    if kinds == ["hinge", "hinge"]:
        return np.column_stack([axes[0], axes[1], np.cross(axes[0], axes[1])])
    across = np.cross(axes[0], np.eye(3)[np.abs(axes[0]).argmin()])
    across /= np.linalg.norm(across)
    frame = np.column_stack([axes[0], across, np.cross(axes[0], across)])
    return frame if kinds == ["slide"] else np.roll(frame, -1, axis=1)


class _Model:
    """A model and its start."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.model = problem, osim.Model()
        self.model.setGravity(_vec(problem.scene.gravity))
        for branch in problem.tree.branches:
            self._branch(branch)
        for (first, one), (second, other) in problem.loops():
            ends = self._body(first), _vec(one), self._body(second), _vec(other)
            self.model.addConstraint(osim.PointConstraint(*ends))
        self.model.finalizeConnections()
        self.start = self.model.initSystem()
        for branch in problem.tree.branches:
            joint = self.model.getJointSet().get(f"{branch.body}_joint")
            for index, freedom in enumerate(branch.freedoms):
                joint.upd_coordinates(index).setSpeedValue(self.start, freedom.rate)

    def _body(self, name: str) -> osim.PhysicalFrame:
        return self.model.getGround() if name == "ground" else self.model.getBodySet().get(name)

    def _branch(self, branch: TreeBranch) -> None:
        start = self.problem.start
        body = next(each for each in self.problem.scene.bodies if each.name == branch.body)
        i = np.array(body.inertia)
        inertia = osim.Inertia(*(float(i[at]) for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))))
        own = osim.Body(body.name, float(body.mass), _vec(np.zeros(3)), inertia)
        kinds = [freedom.kind for freedom in branch.freedoms]
        frame, point = _frame(kinds, [freedom.axis for freedom in branch.freedoms]), branch.freedoms[0].point
        ends: list[object] = []
        for name, made in ((branch.carrier, self._body(branch.carrier)), (body.name, own)):
            pose = start.poses[name]
            ends += [made, _vec(pose.rotation.T @ (point - pose.position)), _angles(pose.rotation.T @ frame)]
        make = {1: osim.PinJoint if kinds == ["hinge"] else osim.SliderJoint, 2: osim.UniversalJoint}[len(kinds)]
        joint = make(f"{body.name}_joint", *ends)
        self.model.addBody(own)
        self.model.addJoint(joint)

    def _place(self, state: osim.State, body: str, at: Array) -> Array:
        found = self._body(body).findStationLocationInGround(state, _vec(at))
        return np.array([found.get(axis) for axis in range(3)])

    def run(self, accuracy: float, times: Array) -> Outcome:
        """Merson's method with so much accuracy."""
        manager = osim.Manager(self.model)
        manager.setWriteToStorage(False)
        manager.setPerformAnalyses(False)
        manager.setRecordStatesTrajectory(False)
        manager.setIntegratorMethod(osim.Manager.IntegratorMethod_RungeKuttaMerson)
        manager.setIntegratorAccuracy(accuracy)
        manager.setIntegratorInternalStepLimit(10_000_000)
        manager.initialize(osim.State(self.start))
        seen, ends, seconds = [], [], 0.0
        points = self.problem.places()
        pairs = self.problem.loops()
        for time in times:
            begun = process_time()
            try:
                state = osim.State(manager.integrate(float(time)))
            except RuntimeError as error:
                raise NotDone(str(error)) from error
            seconds += process_time() - begun
            self.model.realizePosition(state)
            seen.append([self._place(state, *point) for point in points])
            ends.append([[self._place(state, *end) for end in pair] for pair in pairs])
        both = np.array(ends)
        return Outcome(np.array(seen), seconds, opening([(both[:, k, 0], both[:, k, 1]) for k in range(len(pairs))]))


def _settings(model: _Model) -> Iterator[Setting]:
    for accuracy in tolerances(11):
        yield Setting(tolerance_label(accuracy), partial(model.run, accuracy))


def programs(problem: Problem) -> Iterator[Program]:
    """One, of mechanisms that fall freely, on pins, sliders and universal joints."""
    kinds = [[freedom.kind for freedom in branch.freedoms] for branch in problem.tree.branches]
    markers = {marker.name for marker in problem.scene.markers}
    known = all(each in (["hinge"], ["slide"], ["hinge", "hinge"]) for each in kinds) and set(problem.watch) <= markers
    if problem.falls_freely and known and not problem.tried:
        yield Program("Simbody (OpenSim), Merson", partial(_settings, _Model(problem)))
