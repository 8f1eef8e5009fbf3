"""The mechanisms as Pinocchio's models: joint coordinates with one number each, so that q' = v."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from peers.problem import ACROSS, ALONG, GRAVITY, LENGTH, MASS, Array, SliderCrank


def _shift(point: Sequence[float] | Array) -> pin.SE3:
    return pin.SE3(np.eye(3), np.asarray(point, dtype=float))


def _inertia(mass: float, moments: tuple[float, ...], centre: Sequence[float] | Array) -> pin.Inertia:
    return pin.Inertia(mass, np.asarray(centre, dtype=float), np.diag(moments))


def _empty() -> pin.Model:
    model = pin.Model()
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    return model


def chain_model(links: int) -> pin.Model:
    """A chain in the x-z plane, level along x."""
    model, parent = _empty(), 0
    for index in range(links):
        place = _shift([LENGTH if index else 0.0, 0.0, 0.0])
        parent = model.addJoint(parent, pin.JointModelRY(), place, f"joint{index}")
        model.appendBodyToJoint(parent, _inertia(MASS, (ALONG, ACROSS, ACROSS), [LENGTH / 2, 0, 0]), pin.SE3.Identity())
    return model


def slider_crank_model() -> tuple[pin.Model, pin.RigidConstraintModel, Array]:
    """The crank, and slider and rod, as two trees; what closes the ball between them; the velocities at the start."""
    S, model = SliderCrank, _empty()
    crank = model.addJoint(0, pin.JointModelRX(), _shift(S.PIVOT), "A")
    model.appendBodyToJoint(crank, _inertia(S.CRANK_MASS, S.CRANK_INERTIA, np.zeros(3)), pin.SE3.Identity())
    slider = model.addJoint(0, pin.JointModelPX(), _shift(S.SLIDER), "D")
    model.appendBodyToJoint(slider, _inertia(S.SLIDER_MASS, S.SLIDER_INERTIA, np.zeros(3)), pin.SE3.Identity())
    cross = model.addJoint(slider, pin.JointModelRX(), pin.SE3.Identity(), "C1")
    rod = model.addJoint(cross, pin.JointModelRY(), pin.SE3(S.ROD_AXES, np.zeros(3)), "C2")
    centre = np.array([-S.ROD_LENGTH / 2, 0.0, 0.0])
    model.appendBodyToJoint(rod, _inertia(S.ROD_MASS, S.ROD_INERTIA, centre), pin.SE3.Identity())
    ball = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D, model, crank, _shift([0, 0, S.CRANK_LENGTH]), rod, _shift([-S.ROD_LENGTH, 0, 0])
    )
    return model, ball, np.array([S.SPEED, *S.start_velocities()])
