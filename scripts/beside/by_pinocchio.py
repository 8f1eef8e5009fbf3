"""Pinocchio: articulated bodies for trees, constrained dynamics for loops; SciPy's DOP853 from Python, or from C++ the
RK4 and DOP853 of `runge_kutta.hpp`, with no Python between the steps.

Pinocchio computes accelerations and leaves integration to its user (https://github.com/stack-of-tasks/pinocchio): `aba`
for open chains, `initConstraintDynamics` once and then `constraintDynamics` with a 3D contact between the two bodies
for a loop. The loop is not stabilised: nothing is gained by it at these tolerances (gains only add a stiff term). Joint
coordinates are one number each, so that q' = v. Compiling its templates takes minutes the first time, without
-march=native: the alignment of Eigen must be that of the wheel, or it crashes. Eigen's headers are those of the package
cmeel-eigen."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator
from functools import cached_property, partial
from pathlib import Path
from time import process_time

import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp

from .compiled import Integrate, NoCompiler, advance, library, runge_kutta_settings
from .problem import Array, NotDone, Outcome, Problem, Program, Setting, opening, tolerance_label, tolerances

JOINTS = {"hinge": (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)}
JOINTS["slide"] = (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ)
PREFIX = next(parent for parent in Path(pin.__file__).parents if parent.name == "cmeel.prefix")
#: As Pinocchio's CMake files ask for.
FLAGS = (
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION",
    f"-I{PREFIX}/include",
    f"-I{PREFIX}/include/eigen3",
    f"-L{PREFIX}/lib",
    "-lpinocchio_default",
    f"-Wl,-rpath,{PREFIX}/lib",
)


class _Model:
    """A falling mechanism as an ODE of (q, v), in Python and in C++. A joint has the axes of the body that it
    carries."""

    def __init__(self, problem: Problem) -> None:
        self.problem, start = problem, problem.start
        bodies = {body.name: body for body in problem.scene.bodies}
        self.model = pin.Model()
        self.model.gravity.linear = np.array(problem.scene.gravity)
        self.joint = {"ground": 0}
        self.place: dict[str, Array] = {}  # of the joint from the body's centre of mass, in its axes
        self.added: list[tuple[int, int, Array, Array]] = []  # what C++ adds, as `add` of pinocchio.cpp takes it
        rates = []
        for branch in problem.tree.branches:
            pose, parent = start.poses[branch.body], self.joint[branch.carrier]
            carrier = start.poses[branch.carrier]
            origin = start.point(branch.carrier, self.place.get(branch.carrier, np.zeros(3)))
            turn = carrier.rotation.T @ pose.rotation
            for number, freedom in enumerate(branch.freedoms):
                at = carrier.rotation.T @ (freedom.point - origin)
                # The first freedom is in the axes of the carrier or the body, in whichever its axis is one of them.
                own, before = pose.rotation.T @ freedom.axis, carrier.rotation.T @ freedom.axis
                last = number == len(branch.freedoms) - 1
                axis, rotation = (own, turn) if last or np.abs(own).max() > 1 - 1e-12 else (before, np.eye(3))
                which = int(np.abs(axis).argmax())
                assert abs(axis[which]) > 1 - 1e-12, "the axes of joints are those of bodies"
                sign = float(np.sign(axis[which]))
                moving = bodies[branch.body] if last else None
                self.place[branch.body] = pose.rotation.T @ (freedom.point - pose.position)
                parent = self._add(parent, freedom.kind, which, at, rotation, moving, -self.place[branch.body])
                rates.append(sign * freedom.rate)
                origin, carrier = freedom.point, pose if rotation is turn else carrier
                turn = np.eye(3) if rotation is turn else turn
            self.joint[branch.body] = parent
        self.count = len(rates)
        self.start = np.concatenate([np.zeros(self.count), rates])
        self.data, self.zero = self.model.createData(), np.zeros(self.count)
        self.ends = [tuple((self.joint[body], at - self.place[body]) for body, at in pair) for pair in problem.loops()]
        self.balls, self.ball_data = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        for (first, one), (second, other) in self.ends:
            places = pin.SE3(np.eye(3), one), pin.SE3(np.eye(3), other)
            ball = pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, self.model, first, places[0], second, places[1])
            self.balls.append(ball)
            self.ball_data.append(ball.createData())
        if self.ends:
            pin.initConstraintDynamics(self.model, self.data, self.balls, self.ball_data)
        self.accuracy = pin.ProximalSettings(1e-14, 0.0, 1)  # the rows of balls are independent: one exact solve

    def _add(self, parent: int, kind: str, axis: int, at: Array, rotation: Array, body: object, centre: Array) -> int:
        place = pin.SE3(rotation, at)
        joint = int(self.model.addJoint(parent, JOINTS[kind][axis](), place, f"joint{len(self.added)}"))
        numbers = np.zeros(13)
        if body is not None:
            inertia = np.array(body.inertia)  # type: ignore[attr-defined]
            mass = float(body.mass)  # type: ignore[attr-defined]
            self.model.appendBodyToJoint(joint, pin.Inertia(mass, centre, inertia), pin.SE3.Identity())
            numbers = np.concatenate([[mass], centre, inertia.ravel()])
        which = axis + 3 * (kind == "slide")
        self.added.append((parent, which, np.concatenate([rotation.ravel(), at]), numbers))
        return joint

    def derivative(self, _: float, y: Array) -> Array:
        """y' in Python."""
        q, v = y[: self.count], y[self.count :]
        if not self.ends:
            return np.concatenate((v, pin.aba(self.model, self.data, q, v, self.zero)))
        a = pin.constraintDynamics(self.model, self.data, q, v, self.zero, self.balls, self.ball_data, self.accuracy)
        return np.concatenate((v, a))

    def seen(self, states: Array) -> tuple[Array, float | None]:
        """What is watched in states (T, 2n), and the opening."""
        watched = [(self.joint[body], at - self.place[body]) for body, at in self.problem.places()]
        points = [*watched, *(end for pair in self.ends for end in pair)]
        rows = []
        for state in states:
            pin.forwardKinematics(self.model, self.data, state[: self.count])
            rows.append([self.data.oMi[joint].act(at) for joint, at in points])
        all_points = np.array(rows)
        ends = all_points[:, len(watched) :]
        return all_points[:, : len(watched)], opening(
            [(ends[:, k], ends[:, k + 1]) for k in range(0, ends.shape[1], 2)]
        )

    @cached_property
    def compiled(self) -> Integrate:
        """The steps in C++. Raises NoCompiler."""
        if not (PREFIX / "include" / "eigen3").is_dir():
            raise NoCompiler("no headers of Eigen beside Pinocchio's; pip install cmeel-eigen")
        own = library("pinocchio.cpp", FLAGS)
        own.create.restype, own.advance.restype = ctypes.c_void_p, ctypes.c_long
        system = ctypes.c_void_p(own.create(_at(np.array(self.problem.scene.gravity))))
        for parent, which, place, body in self.added:
            own.add(system, parent, which, _at(place), _at(body))
        for (first, one), (second, other) in self.ends:
            own.close_loop(system, first, _at(np.array(one)), second, _at(np.array(other)))
        own.ready(system)
        return advance(own.advance, system)


def _at(array: Array) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)  # it keeps the array


def _by_scipy(model: _Model, tolerance: float, times: Array) -> Outcome:
    begun, span = process_time(), (0.0, float(times[-1]))
    found = solve_ivp(model.derivative, span, model.start, "DOP853", t_eval=times, rtol=tolerance, atol=tolerance)
    seconds = process_time() - begun
    if not found.success:
        raise NotDone(found.message)
    watched, opened = model.seen(found.y.T)
    return Outcome(watched, seconds, opened, found.nfev)


def _python(model: _Model) -> Iterator[Setting]:
    for tolerance in tolerances():
        yield Setting(tolerance_label(tolerance), partial(_by_scipy, model, tolerance))


def programs(problem: Problem) -> Iterator[Program]:
    """SciPy's DOP853 on Pinocchio's Python; RK4 and DOP853 in C++."""
    if not problem.falls_freely or not set(problem.watch) <= {marker.name for marker in problem.scene.markers}:
        return
    model = _Model(problem)
    if not problem.tried:
        yield Program("Pinocchio, SciPy's DOP853", partial(_python, model))
    try:
        run = model.compiled
    except NoCompiler as error:
        print(f"left out: Pinocchio from C++ ({error})", file=sys.stderr)
        return
    yield from runge_kutta_settings("Pinocchio from C++", problem, run, model.start, model.seen)
