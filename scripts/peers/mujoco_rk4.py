"""MuJoCo: generalised coordinates, RK4, loops closed by soft constraints (https://mujoco.readthedocs.io).

As its documentation advises: the integrator RK4 for energy-conserving motion, contacts switched off, all steps inside
one call of `mj_step` (its `nstep`), the loop closed by `equality/connect`. How hard that is follows from solref (a time
constant of at least two steps, critically damped) and solimp (an impedance below 1): both are part of the sweep.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import mujoco
import numpy as np

from peers.peer import NotConverged, Observation, Peer, Setting, ode_label, seconds_of, steps_per_interval
from peers.problem import ACROSS, ALONG, FIVE_BAR, GRAVITY, LENGTH, MASS, Array, Chain, Mechanism, SliderCrank

#: Time constants in steps and impedances of the loop's constraint that are tried with each step.
TIME_CONSTANTS, IMPEDANCES = (2.0, 3.0), (0.999, 0.9999)
mujoco.set_mju_user_warning(lambda message: None)  # diverged runs are counted below, not logged to a file
#: A state that is not finite or too large warns and resets; then the setting counts as diverged.
FAULTS = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)


def _numbers(values: Array | tuple[float, ...]) -> str:
    return " ".join(f"{value:.17g}" for value in values)


def _inertial(mass: float, moments: tuple[float, ...], position: Array | tuple[float, ...]) -> str:
    return f'<inertial mass="{mass}" pos="{_numbers(position)}" diaginertia="{_numbers(moments)}"/>'


def _document(bodies: str, rest: str = "") -> str:
    return (
        f'<mujoco><compiler angle="radian" autolimits="false"/><option integrator="RK4" gravity="0 0 {-GRAVITY}"'
        f' tolerance="1e-15" iterations="50"><flag contact="disable"/></option>'
        f"<worldbody>{bodies}</worldbody>{rest}</mujoco>"
    )


def chain_model(links: int, length: float = LENGTH) -> mujoco.MjModel:
    """A chain in the x-z plane, level along x. (An XML document of 500 links would be nested too deeply.)"""
    across = ACROSS + MASS * (length**2 - LENGTH**2) / 12.0
    spec = mujoco.MjSpec.from_string(_document(""))
    body = spec.worldbody
    for index in range(links):
        body = body.add_body(
            pos=[length if index else 0.0, 0.0, 0.0],
            explicitinertial=True,
            mass=MASS,
            ipos=[length / 2, 0.0, 0.0],
            inertia=[ALONG, across, across],
        )
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0])
    body.add_site(name="marker", pos=[length, 0.0, 0.0])
    return spec.compile()


def slider_crank_model() -> mujoco.MjModel:
    """The slider-crank: a tree from the slider to the rod and one of the crank, connected at the ball."""
    S = SliderCrank
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, S.ROD_AXES.ravel())
    tree = (
        f'<body pos="{_numbers(S.PIVOT)}"><joint type="hinge" axis="1 0 0"/>'
        f"{_inertial(S.CRANK_MASS, S.CRANK_INERTIA, (0, 0, 0))}"
        f'<site name="crank_ball" pos="0 0 {S.CRANK_LENGTH}"/></body>'
        f'<body pos="{_numbers(S.SLIDER)}"><joint type="slide" axis="1 0 0"/>'
        f'{_inertial(S.SLIDER_MASS, S.SLIDER_INERTIA, (0, 0, 0))}<site name="marker"/>'
        f'<body quat="{_numbers(quaternion)}"><joint type="hinge" axis="{_numbers(S.ROD_AXES[0])}"/>'
        f'<joint type="hinge" axis="0 1 0"/>{_inertial(S.ROD_MASS, S.ROD_INERTIA, (-S.ROD_LENGTH / 2, 0, 0))}'
        f'<site name="rod_ball" pos="{-S.ROD_LENGTH} 0 0"/></body></body>'
    )
    connection = '<equality><connect site1="crank_ball" site2="rod_ball"/></equality>'
    return mujoco.MjModel.from_xml_string(_document(tree, connection))


class _Run:
    """A model with its data, at one setting."""

    def __init__(self, model: mujoco.MjModel, step: float, velocities: Array | None = None) -> None:
        self.model = model
        self.model.opt.timestep = step
        self.data = mujoco.MjData(self.model)
        self.velocities = np.zeros(self.model.nv) if velocities is None else velocities

    def harden(self, time_constant: float, impedance: float) -> None:
        self.model.eq_solref[:] = (time_constant * self.model.opt.timestep, 1.0)
        self.model.eq_solimp[:, :2] = impedance

    def integrate(self, steps: int) -> float:
        self.reset()
        return seconds_of(lambda: self.advance(steps))

    def observe(self, outputs: int, steps: int) -> Observation:
        self.reset()
        markers, openings = [], []
        for _ in range(outputs):
            self.advance(steps)
            mujoco.mj_kinematics(self.model, self.data)
            markers.append(self.data.site("marker").xpos.copy())
            if self.model.neq:
                openings.append(np.linalg.norm(self.data.site("crank_ball").xpos - self.data.site("rod_ball").xpos))
        points = np.array(markers)[:, [0]] if self.model.neq else np.array(markers)[:, [0, 2]]
        return Observation(points, float(max(openings)) if openings else None)

    def reset(self) -> None:
        mujoco.mj_resetData(self.model, self.data)
        self.data.qvel[:] = self.velocities

    def advance(self, steps: int) -> None:
        mujoco.mj_step(self.model, self.data, nstep=steps)
        if any(self.data.warning[fault].number for fault in FAULTS):
            raise NotConverged("MuJoCo reset a diverged state")


def _setting(label: str, make: Callable[[], _Run], outputs: int, steps: int) -> Setting:
    return Setting(label, lambda: make().integrate(outputs * steps), lambda: make().observe(outputs, steps))


def _settings(mechanism: Mechanism) -> Iterator[Setting]:
    tree = mechanism is FIVE_BAR
    model = chain_model(5) if tree else slider_crank_model()
    slider, about_x, about_pin = SliderCrank.start_velocities()
    velocities = None if tree else np.array([SliderCrank.SPEED, slider, about_x, about_pin])
    hardness = [(0.0, 0.0)] if tree else list(product(TIME_CONSTANTS, IMPEDANCES))
    for per_interval, (time_constant, impedance) in product(steps_per_interval(20, 20_000), hardness):
        step = mechanism.interval / per_interval

        def make(step: float = step, time_constant: float = time_constant, impedance: float = impedance) -> _Run:
            run = _Run(model, step, velocities)
            run.harden(time_constant, impedance)
            return run

        loop = "" if tree else f", solref {time_constant:g} h, solimp {impedance:g}"
        yield _setting(ode_label(step) + loop, make, len(mechanism.times), per_interval)


def _chain(chain: Chain) -> Setting:
    model = chain_model(chain.links)
    return _setting(ode_label(chain.step), lambda: _Run(model, chain.step), 1, chain.steps)


PEERS = (Peer("MuJoCo, RK4", _settings, _chain),)
