"""Laws of actuators: force = (gain · z) u + bias · z with z = (1, length, velocity), and what drives them, u."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.formats.mechanism import Signal, Signals
from mbproj.formats.mjcf.compiled import Compiled
from mbproj.formats.yaml_text import number as shown


@dataclass(frozen=True, eq=False)
class Law:
    """`gain` and `bias` (3,), and the least and the largest force where the model limits it."""

    gain: Array
    bias: Array
    range: tuple[float, float] | None

    @property
    def pushes(self) -> bool:
        """Whether it exerts something without a control signal."""
        return bool(self.bias.any())


@dataclass(frozen=True)
class Drive:
    """What a law is driven by: a number where it is constant, and an expression of t."""

    constant: float | None
    text: str


def law_of(compiled: Compiled, number: int) -> Law | str:
    """The law of an actuator, or why a scene has none."""
    import mujoco

    model = compiled.model
    gain, bias = np.array(model.actuator_gainprm[number][:3]), np.array(model.actuator_biasprm[number][:3])
    of_gain, of_bias = mujoco.mjtGain, mujoco.mjtBias
    kind, push = int(model.actuator_gaintype[number]), int(model.actuator_biastype[number])
    if kind == int(getattr(of_gain, "mjGAIN_DCMOTOR", -1)):
        resistance, constant = gain[:2]
        rest = (model.actuator_gainprm[number][2:], model.actuator_biasprm[number], model.actuator_dynprm[number])
        if any(np.any(values) for values in rest):
            return "a scene has a motor's voltage, resistance and constant, and none of what else it has"
        gain = np.array([constant / resistance, 0.0, 0.0])
        bias = np.array([0.0, 0.0, -(constant**2) / resistance])
    elif kind == int(of_gain.mjGAIN_FIXED):
        gain[1:] = 0.0
    elif kind != int(of_gain.mjGAIN_AFFINE):
        return "a scene has no muscles, and no actuators of plugins"
    if push == int(of_bias.mjBIAS_NONE):
        bias[:] = 0.0
    elif push not in (int(of_bias.mjBIAS_AFFINE), int(getattr(of_bias, "mjBIAS_DCMOTOR", -1))):
        return "a scene has no muscles, and no actuators of plugins"
    low, high = (float(each) for each in model.actuator_forcerange[number])
    return Law(gain, bias, (low, high) if model.actuator_forcelimited[number] else None)


def drive_of(compiled: Compiled, number: int, name: str, signals: Signals) -> Drive | str:
    """What drives an actuator: its signal, or its `ctrl` at the start, through a filter or an integrator where that has
    a closed form; or why there is none."""
    import mujoco

    model, kinds = compiled.model, mujoco.mjtDyn
    ctrl = int(getattr(model, "actuator_ctrladr", np.arange(model.nu))[number])
    signal = signals.get(name) or Signal(repr(float(compiled.data.ctrl[ctrl])))
    constant = signal.constant
    text = f"({signal.text})" if constant is None else shown(constant)
    if model.actuator_ctrllimited[number] and not compiled.disables("CLAMPCTRL"):
        low, high = (float(each) for each in model.actuator_ctrlrange[number])
        constant = None if constant is None else min(max(constant, low), high)
        text = f"min(max({text}, {shown(low)}), {shown(high)})" if constant is None else shown(constant)
    kind = int(model.actuator_dyntype[number])
    if kind in (int(kinds.mjDYN_NONE), int(getattr(kinds, "mjDYN_DCMOTOR", -1))):
        return Drive(constant, text)
    simple = (int(kinds.mjDYN_INTEGRATOR), int(kinds.mjDYN_FILTER), int(kinds.mjDYN_FILTEREXACT))
    if kind not in simple or constant is None or model.actuator_actlimited[number]:
        return "it has states, which a scene has only of a constant signal through an integrator or a filter"
    first = float(compiled.data.act[int(model.actuator_actadr[number])])
    if constant == (0.0 if kind == simple[0] else first):  # at rest
        return Drive(first, shown(first))
    if kind == simple[0]:
        return Drive(None, f"({shown(first)} + {shown(constant)}*t)")
    time = float(model.actuator_dynprm[number][0])
    return Drive(None, f"({text} + ({shown(first - constant)})*exp(-t/{shown(time)}))")
