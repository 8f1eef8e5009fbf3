"""Laws of actuators: force = (gain · z) u + bias · z with z = (1, length, velocity), and muscles."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.formats.yaml_text import number as shown

Range = tuple[float, float]


@dataclass(frozen=True, eq=False)
class ActuatorLaw:
    """The law of an actuator that is no muscle: `gain` and `bias` (3,), and the range of the force where the model
    limits it."""

    gain: Array
    bias: Array
    range: Range | None

    @property
    def pushes(self) -> bool:
        """Whether the actuator exerts a force without a control signal."""
        return bool(self.bias.any())

    @property
    def simple(self) -> bool:
        """Whether the force depends on the signal alone, and is not limited."""
        return not (self.gain[1:].any() or self.bias[1:].any() or self.range)

    def force(self, drive: str, length: str, rate: str) -> str:
        """The force as an expression of the texts of its drive, of the length and of its rate."""
        terms = [(self.gain[0], drive), (self.bias[0], "1")]
        for at, text in ((1, length), (2, rate)):
            terms += [(self.gain[at], f"{drive}*{text}"), (self.bias[at], text)]
        return within(summed(terms), self.range)


@dataclass(frozen=True, eq=False)
class Muscle:
    """A muscle. `prm` (9,) are MuJoCo's numbers: range of lengths (2), peak force, scale, least and largest length,
    largest velocity, passive force, force of lengthening. `lengths` is the range of the actuator's length in m."""

    prm: Array
    lengths: Range
    acceleration: float
    range: Range | None

    pushes = True
    simple = False

    def force(self, drive: str, length: str, rate: str) -> str:
        """The force -peak (FL(L) FV(V) act + FP(L)) as an expression. L and V are the signals named `length` and
        `rate`, which `scaled` defines."""
        least, most, _, passive, lengthening = self.prm[4:9]
        peak = self.prm[2] if self.prm[2] >= 0.0 else self.prm[3] / max(self.acceleration, 1e-15)
        rising, falling = 0.5 * (least + 1.0), 0.5 * (1.0 + most)
        bends = [(1.0, least, rising), (-1.0, 1.0, rising), (-1.0, 1.0, falling), (1.0, most, falling)]
        squares = [(sign, f"{_part(length, start, end)}**2") for sign, start, end in bends]
        y = lengthening - 1.0
        speed = f"(clip({rate} + 1, 0, 1)**2"
        speed += f" + {shown(y)} - clip({shown(y)} - {rate}, 0, {shown(y)})**2/{shown(y)})" if y > 0.0 else ")"
        active = f"0.5*({summed(squares)})*{speed}*{drive}"
        stretched = f"0.5*{_part(length, 1.0, falling)}**2 + max({length} - {shown(falling)}, 0)/{shown(falling - 1.0)}"
        return within(f"{shown(-peak)}*({active} + {shown(passive)}*({stretched}))", self.range)

    def scaled(self, length: str, rate: str) -> Mapping[str, str]:
        """The expressions of L and V: the length, and the velocity over the largest one, in units of the rest
        length."""
        first, last = self.prm[:2]
        rest = (self.lengths[1] - self.lengths[0]) / max(last - first, 1e-15)
        start = first - self.lengths[0] / rest
        return {
            "length": f"{shown(start)} + ({length})/{shown(rest)}",
            "rate": f"({rate})/{shown(rest * self.prm[6])}",
        }


def law_of(compiled: CompiledMjcf, number: int) -> ActuatorLaw | Muscle | str:
    """The law of an actuator, or the reason why a scene has none like it."""
    import mujoco

    model = compiled.model
    gain, bias = np.array(model.actuator_gainprm[number][:3]), np.array(model.actuator_biasprm[number][:3])
    of_gain, of_bias = mujoco.mjtGain, mujoco.mjtBias
    kind, push = int(model.actuator_gaintype[number]), int(model.actuator_biastype[number])
    limits = _limits(compiled, number)
    if (config := compiled.plugin_of(number)) is not None:
        if isinstance(config, str):
            return config
        return ActuatorLaw(np.array([1.0, 0.0, 0.0]), np.array([0.0, -config["kp"], -config["kd"]]), limits)
    if kind == int(of_gain.mjGAIN_MUSCLE) == int(of_bias.mjBIAS_MUSCLE) and push == kind:
        output = compiled.output(number)
        low, high = (float(each) for each in model.actuator_lengthrange[output])
        prm, speed = np.array(model.actuator_gainprm[number][:9]), float(model.actuator_acc0[output])
        if np.any(model.actuator_biasprm[number][:9] != prm):
            return "its passive force is that of another muscle"
        return Muscle(prm, (low, high), speed, limits)
    if kind == int(getattr(of_gain, "mjGAIN_DCMOTOR", -1)):
        resistance, constant = gain[:2]
        rest = (model.actuator_gainprm[number][2:], model.actuator_biasprm[number], model.actuator_dynprm[number])
        if any(np.any(values) for values in rest):
            return "a scene has a motor's voltage, resistance and constant, and none of what else it has"
        gain = np.array([constant / resistance, 0.0, 0.0])
        bias = np.array([0.0, 0.0, -(constant**2) / resistance])
    elif kind == int(getattr(of_gain, "mjGAIN_PID", -1)):
        gain = np.array([1.0, 0.0, 0.0])
    elif kind == int(of_gain.mjGAIN_FIXED):
        gain[1:] = 0.0
    elif kind != int(of_gain.mjGAIN_AFFINE):
        return "a scene has no such law of a force"
    if push == int(of_bias.mjBIAS_NONE):
        bias[:] = 0.0
    elif push not in (int(of_bias.mjBIAS_AFFINE), int(getattr(of_bias, "mjBIAS_DCMOTOR", -1))):
        return "a scene has no such law of a force"
    return ActuatorLaw(gain, bias, limits)


def _limits(compiled: CompiledMjcf, number: int) -> Range | None:
    model = compiled.model
    low, high = (float(each) for each in model.actuator_forcerange[number])
    return (low, high) if model.actuator_forcelimited[number] else None


def within(text: str, limits: Range | None) -> str:
    """The expression, limited to a range; unchanged where that is None."""
    return text if limits is None else f"min(max({text}, {shown(limits[0])}), {shown(limits[1])})"


def summed(terms: list[tuple[float, str]]) -> str:
    """The expression Σ factor × text, without terms that are zero."""
    parts = []
    for factor, text in terms:
        if text == "1" and factor:
            parts.append(shown(factor))
        elif factor:
            parts.append({1.0: text, -1.0: f"-{text}"}.get(float(factor), f"{shown(factor)}*{text}"))
    return " + ".join(parts).replace("+ -", "- ") or "0"


def _part(x: str, start: float, end: float) -> str:
    """The expression of a ramp over x: 0 up to `start`, 1 from `end` on."""
    difference = f"{x} - {shown(start)}" if end > start else f"{shown(start)} - {x}"
    return f"clip(({difference})/{shown(abs(end - start))}, 0, 1)"
