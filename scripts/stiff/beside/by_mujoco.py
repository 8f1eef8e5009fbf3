"""MuJoCo: the bushing as two slides and a hinge with stiffness and damping between the halves, the loop closed at the
rocker by a soft constraint; the governor's links as tendons of fixed length, soft as well. The slides lie in the near
half, and not midway between both: that differs by the square of the bushing's deflection. `implicitfast` and `implicit`
take damping implicitly, `discrete` stiffness as well (https://mujoco.readthedocs.io).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from time import process_time

import mujoco
import numpy as np

from stiff.beside import governor as numbers
from stiff.beside.four_bar import CRANK, FRAME, GRAVITY, HALF, INERTIAS, MASSES, ROCKER, FourBar
from stiff.beside.governor import Governor
from stiff.beside.program import END, SAMPLES, Array, NotDone, Problem, Program, Setting, steps

INTEGRATORS = ("discrete", "implicit", "implicitfast")
#: Time constants of the loop's constraint in steps, and impedances, that are tried with each step.
TIME_CONSTANTS, IMPEDANCES = (2.0, 4.0), (0.9999,)
mujoco.set_mju_user_warning(lambda message: None)  # diverged runs are told by their result
FAULTS = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)


def _inertial(k: int, at: float) -> str:
    moment = INERTIAS[k]
    return f'<inertial mass="{MASSES[k]}" pos="{at!r} 0 0" diaginertia="{moment / 50!r} {moment!r} {moment!r}"/>'


def _document(integrator: str, step: float, rest: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><compiler angle="radian" autolimits="false"/>
        <option integrator="{integrator}" gravity="0 0 {-GRAVITY}" timestep="{step!r}" tolerance="1e-15"
          iterations="50"><flag contact="disable"/></option>{rest}</mujoco>"""
    )


def _four_bar(bar: FourBar, hardness: str) -> str:
    one, two, three, four = bar.angles.tolist()
    (kx, kz, kr), (cx, cz, cr) = bar.stiffness.tolist(), bar.damping.tolist()
    hinge = '<joint type="hinge" axis="0 -1 0"/>'
    return f"""<worldbody>
        <body axisangle="0 -1 0 {one!r}">{hinge}{_inertial(0, CRANK / 2)}
          <body pos="{CRANK} 0 0" axisangle="0 -1 0 {two - one!r}">{hinge}{_inertial(1, HALF / 2)}
            <site name="near" pos="{HALF} 0 0"/>
            <body name="far" pos="{HALF} 0 0" axisangle="0 -1 0 {three - two!r}">
              <joint type="slide" axis="1 0 0" stiffness="{kx!r}" damping="{cx!r}"/>
              <joint type="slide" axis="0 0 1" stiffness="{kz!r}" damping="{cz!r}"/>
              <joint type="hinge" axis="0 -1 0" stiffness="{kr!r}" damping="{cr!r}"/>{_inertial(2, HALF / 2)}
        </body></body></body>
        <body name="rocker" pos="{FRAME} 0 0" axisangle="0 -1 0 {four!r}">{hinge}{_inertial(3, ROCKER / 2)}
          <site name="end" pos="{ROCKER} 0 0"/></body>
        </worldbody>
        <equality><connect body1="rocker" body2="far" anchor="{ROCKER} 0 0" {hardness}/></equality>"""


def _governor(problem: Governor, hardness: str) -> str:
    """The links are tendons of fixed length."""
    g = numbers
    s, c = float(np.sin(g.START)), float(np.cos(g.START))
    arms, tendons, closed = [], [], []
    for name, side, axis in (("right", 1.0, "0 -1 0"), ("left", -1.0, "0 1 0")):
        ball, joint = f"{side * g.ARM * s!r} 0 {-g.ARM * c!r}", f"{side * g.LINK * s!r} 0 {-g.LINK * c!r}"
        arms.append(
            f'<body pos="{side * g.PIN!r} 0 0"><joint type="hinge" axis="{axis}"/><inertial mass="{g.BALL}" '
            f'pos="{ball}" diaginertia="{g.BALL_INERTIA} {g.BALL_INERTIA} {g.BALL_INERTIA}"/>'
            f'<site name="{name}" pos="{joint}"/><site name="{name}_ball" pos="{ball}"/></body>'
        )
        tendons.append(f'<spatial name="{name}"><site site="{name}"/><site site="{name}_end"/></spatial>')
        closed.append(f'<tendon tendon1="{name}" {hardness}/>')
    return f"""<worldbody><body><joint type="hinge" axis="0 0 1"/>
        <inertial mass="{g.SPINDLE}" pos="0 0 -0.1" diaginertia="{g.ACROSS} {g.ACROSS} {g.ABOUT}"/>{"".join(arms)}
        <body pos="0 0 {-2.0 * g.LINK * c!r}">
          <joint type="slide" axis="0 0 1" stiffness="{problem.k!r}" damping="{problem.damping!r}"/>
          <inertial mass="{g.COLLAR}" pos="0 0 0"
            diaginertia="{g.COLLAR_INERTIA} {g.COLLAR_INERTIA} {g.COLLAR_INERTIA}"/>
          <site name="collar"/><site name="right_end" pos="{g.PIN} 0 0"/><site name="left_end" pos="{-g.PIN} 0 0"/>
        </body></body></worldbody>
        <tendon>{"".join(tendons)}</tendon><equality>{"".join(closed)}</equality>"""


def _model(problem: Problem, integrator: str, step: float, constant: float, impedance: float) -> mujoco.MjModel:
    hardness = f'solref="{constant!r} 1" solimp="{impedance!r} {impedance!r} 1"'
    rest = _four_bar(problem, hardness) if isinstance(problem, FourBar) else _governor(Governor(problem.k), hardness)
    return _document(integrator, step, rest)


def _data(model: mujoco.MjModel, problem: Problem) -> mujoco.MjData:
    data = mujoco.MjData(model)
    if isinstance(problem, FourBar):
        one, two, three, four = problem.speeds.tolist()
        data.qvel[:] = one, two - one, 0.0, 0.0, three - two, four
    else:
        data.qvel[:] = numbers.SPEED, 0.0, 0.0, 0.0
    return data


def _points(problem: Problem, data: mujoco.MjData) -> Array:
    if isinstance(problem, FourBar):
        return np.asarray(data.site_xpos[:, [0, 2]].ravel())
    ball, collar = data.site("right_ball").xpos, data.site("collar").xpos
    return np.array([ball[0], ball[1], 0.0, collar[2]])


def _run(problem: Problem, integrator: str, count: int, constant: float, impedance: float) -> tuple[float, Array]:
    step = END / SAMPLES / count
    model = _model(problem, integrator, step, constant * step, impedance)
    data = _data(model, problem)
    begun = process_time()
    for _ in range(SAMPLES):
        mujoco.mj_step(model, data, nstep=count)
    seconds = process_time() - begun
    data, points = _data(model, problem), np.zeros((SAMPLES, 4))
    for k in range(SAMPLES):
        mujoco.mj_step(model, data, nstep=count)
        if any(data.warning[fault].number for fault in FAULTS):
            raise NotDone("it diverges")
        mujoco.mj_kinematics(model, data)
        points[k] = _points(problem, data)
    return seconds, points


def _settings(problem: Problem, integrator: str) -> Iterator[Setting]:
    for count, constant, impedance in product(steps(), TIME_CONSTANTS, IMPEDANCES):
        label = f"{1e6 * END / SAMPLES / count:.3g} us, solref {constant:g} steps, solimp {impedance}"
        yield Setting(label, partial(_run, problem, integrator, count, constant, impedance))


def _accelerations(problem: Problem) -> Array:
    """With the loop's constraint as hard as it goes."""
    model = _model(problem, "implicit", 1e-6, 2e-6, 0.999999)
    data = _data(model, problem)
    mujoco.mj_forward(model, data)
    if not isinstance(problem, FourBar):
        return np.asarray(data.qacc[:2].copy())
    one, two, _, _, three, four = data.qacc.tolist()
    return np.array([one, one + two, one + two + three, four])


def programs(problem: Problem) -> list[Program]:
    """One for each integrator."""
    return [
        Program(f"MuJoCo, {name}", partial(_settings, problem, name), partial(_accelerations, problem))
        for name in INTEGRATORS
    ]
