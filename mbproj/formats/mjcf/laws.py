"""Laws of actuators: force = (gain · z) u + bias · z with z = (1, length, velocity), and muscles."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.formats.mechanism import Bare, GivenSignal, ImportedMechanism, ImportedNames, Signals
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.formats.yaml_text import number as shown
from mbproj.scene.expressions.evaluate import Value, evaluate
from mbproj.scene.expressions.syntax_tree import parse

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


# --- Drives of actuators ----------------------------------------------------------------------------------------------
# The input of an actuator's law, which is its control signal, or a state that follows that.
# An integrator and a filter of a constant signal have a closed form. MuJoCo limits states after each step; here the
# rate keeps them within their limits over one time step h of the model: x' = clip(f, (low - x)/h, (high - x)/h).


#: Stands for the actuator's length in a state's derivative.
LENGTH = "{length}"
#: Inputs of a PID actuator, in their order; the number of each is its bit in `actuator_ctrlspec`.
INPUTS = {"pos": 1, "vel": 2, "ff": 4}


@dataclass(frozen=True)
class StateOf:
    """A state of a drive. Its derivative is an expression that may have `LENGTH` in it."""

    name: str
    derivative: str
    initial: float


@dataclass(frozen=True)
class ActuatorDrive:
    """The input of a law: an expression of t and of the states, and its number where it is constant."""

    constant: float | None
    text: str
    states: tuple[StateOf, ...] = ()


def free_symbol(mechanism: ImportedMechanism, wanted: str) -> str:
    """A free name for a signal or a state, which expressions can use, as near to the wanted one as can be."""
    taken = frozenset([*mechanism.forces, *mechanism.signals, *mechanism.states])
    return ImportedNames(taken).unused(re.sub(r"\W", "_", wanted))


def inputs_of(compiled: CompiledMjcf, number: int, name: str) -> tuple[str, ...]:
    """The names that a user can give to the control signals of an actuator."""
    model = compiled.model
    if int(getattr(model, "actuator_ctrlnum", np.ones(model.nu))[number]) == 1:
        return (name,)
    spec = int(model.actuator_ctrlspec[number])
    chosen = [word for word, bit in INPUTS.items() if spec & bit]
    return (name, *(f"{name}.{word}" for word in chosen[1:]))


def drive_of(
    compiled: CompiledMjcf,
    mechanism: ImportedMechanism,
    number: int,
    name: str,
    law: ActuatorLaw | Muscle,
    signals: Signals,
) -> ActuatorDrive | str:
    """The drive of an actuator, or the reason why a scene has none like it. Its control signals are in `signals` by
    name; others keep their value `ctrl` of the start."""
    import mujoco

    model, kinds = compiled.model, mujoco.mjtDyn
    kind = int(model.actuator_dyntype[number])
    if int(model.actuator_gaintype[number]) == int(getattr(mujoco.mjtGain, "mjGAIN_PID", -1)):
        assert isinstance(law, ActuatorLaw)
        return _pid(compiled, mechanism, number, name, law, signals)
    command = _command(compiled, number, name, signals)
    if compiled.plugin_of(number) is not None:
        return _plugin(compiled, mechanism, number, name, command, kind != int(kinds.mjDYN_NONE))
    if kind in (int(kinds.mjDYN_NONE), int(getattr(kinds, "mjDYN_DCMOTOR", -1))):
        return command
    return _activation(compiled, mechanism, number, name, command)


def _command(compiled: CompiledMjcf, number: int, name: str, signals: Signals, which: int = 0) -> ActuatorDrive:
    """The drive of a control signal, which is limited to its range."""
    model = compiled.model
    at = int(getattr(model, "actuator_ctrladr", np.arange(model.nu))[number]) + which
    signal = signals.get(inputs_of(compiled, number, name)[which]) or GivenSignal(repr(float(compiled.data.ctrl[at])))
    constant = signal.constant
    text = f"({signal.text})" if constant is None else shown(constant)
    if model.actuator_ctrllimited[at]:
        low, high = (float(each) for each in model.actuator_ctrlrange[at])
        constant = None if constant is None else min(max(constant, low), high)
        text = within(text, (low, high)) if constant is None else shown(constant)
    return ActuatorDrive(constant, text)


def _activation(
    compiled: CompiledMjcf, mechanism: ImportedMechanism, number: int, name: str, command: ActuatorDrive
) -> ActuatorDrive | str:
    """The drive of an actuator whose input is its activation: an integrator, a filter or a muscle's. It has a closed
    form where the signal is constant. Else the reason why there is none."""
    import mujoco

    model, kinds, u = compiled.model, mujoco.mjtDyn, command.constant
    kind, range_ = int(model.actuator_dyntype[number]), _activation_range(compiled, number)
    first = _within(float(compiled.data.act[int(model.actuator_actadr[number])]), range_)
    integrates = kind == int(kinds.mjDYN_INTEGRATOR)
    time = float(model.actuator_dynprm[number][0])
    if integrates or kind in (int(kinds.mjDYN_FILTER), int(kinds.mjDYN_FILTEREXACT)):
        if u is not None and u == (0.0 if integrates else first):  # at rest
            return ActuatorDrive(first, shown(first))
        if u is not None and integrates:
            return ActuatorDrive(None, within(f"({shown(first)} + {shown(u)}*t)", range_))
        if u is not None:
            return ActuatorDrive(None, within(f"({shown(u)} + ({shown(first - u)})*exp(-t/{shown(time)}))", range_))
    elif kind != int(kinds.mjDYN_MUSCLE):
        return "a scene has no such states"
    state = _state(compiled, mechanism, number, name, command, first)
    return ActuatorDrive(None, state.name, (state,))


def _state(
    compiled: CompiledMjcf, mechanism: ImportedMechanism, number: int, name: str, command: ActuatorDrive, first: float
) -> StateOf:
    """The state of an actuator's activation, which follows the command."""
    import mujoco

    model, kinds, u = compiled.model, mujoco.mjtDyn, command.text
    kind, x = int(model.actuator_dyntype[number]), free_symbol(mechanism, f"{name}_act")
    time, slower, width = (float(each) for each in model.actuator_dynprm[number][:3])
    if kind == int(kinds.mjDYN_INTEGRATOR):
        rate = u
    elif kind != int(kinds.mjDYN_MUSCLE):
        rate = f"({u} - {x})/{shown(time)}"
    else:
        # From within [0, 1] the activation stays there, and needs no bounds, which would have kinks at the start.
        a = x if 0.0 <= first <= 1.0 else f"clip({x}, 0, 1)"
        wanted = f"clip({u}, 0, 1)" if command.constant is None else shown(min(max(command.constant, 0.0), 1.0))
        d = f"({wanted} - {x})"
        up, down = f"{shown(time)}*(0.5 + 1.5*{a})", f"{shown(slower)}/(0.5 + 1.5*{a})"
        rate = f"max({d}, 0)/({up}) + min({d}, 0)/({down})"
        if width > 0.0:
            s = f"clip({d}/{shown(width)} + 0.5, 0, 1)"
            rate = f"{d}/({down} + ({up} - {down})*{s}**3*(6*{s}**2 - 15*{s} + 10))"
    return StateOf(x, _limited(compiled, rate, x, _activation_range(compiled, number)), first)


def _pid(
    compiled: CompiledMjcf, mechanism: ImportedMechanism, number: int, name: str, law: ActuatorLaw, signals: Signals
) -> ActuatorDrive | str:
    """The drive of a PID actuator: kp u_pos + kv u_vel + ki ∫ (u_pos - length) + u_ff. The law itself has the terms
    -kp length - kv velocity."""
    model = compiled.model
    chosen = [word for word, bit in INPUTS.items() if int(model.actuator_ctrlspec[number]) & bit]
    drives = {word: _command(compiled, number, name, signals, which) for which, word in enumerate(chosen)}
    still = ActuatorDrive(0.0, "0")
    position, rate, ahead = (drives.get(word, still) for word in INPUTS)
    integral, (most, fastest) = float(model.actuator_gainprm[number][0]), model.actuator_dynprm[number][:2]
    states: list[StateOf] = []
    at = int(model.actuator_actadr[number])
    if fastest > 0.0:
        position = _slewed(compiled, mechanism, name, position, float(fastest), float(compiled.data.act[at]))
        states += position.states
        at += 1
    terms = [(-law.bias[1], position), (-law.bias[2], rate), (1.0, ahead)]
    if integral:
        summing = _integral(compiled, mechanism, name, position.text, float(most), float(compiled.data.act[at]))
        if isinstance(summing, str):
            return summing
        states.append(summing)
        terms.append((integral, ActuatorDrive(None, summing.name)))
    return _sum_of(terms, states)


def _plugin(
    compiled: CompiledMjcf,
    mechanism: ImportedMechanism,
    number: int,
    name: str,
    command: ActuatorDrive,
    activated: bool,
) -> ActuatorDrive | str:
    """The drive of an actuator of the plugin `mujoco.pid`, with one input, which an activation may follow. The force of
    its integral is limited."""
    config = compiled.plugin_of(number)
    assert config is not None and not isinstance(config, str)
    model, states, speed = compiled.model, list[StateOf](), "0"
    at, count = int(model.actuator_actadr[number]), int(model.actuator_actnum[number])
    position = command
    if activated:
        if config["slewmax"]:
            return "a scene has no limit of the rate of a state"
        moved = _state(compiled, mechanism, number, name, command, float(compiled.data.act[at + count - 1]))
        states.append(moved)
        position, speed = ActuatorDrive(None, moved.name), f"({moved.derivative})"
    elif config["slewmax"] and command.constant is None:
        first = evaluate(parse(command.text), {"t": Value(0.0, None)}).number
        position = _slewed(compiled, mechanism, name, command, config["slewmax"], first)
        states += position.states
    terms = [(config["kp"], position)]
    if config["kd"] and activated:
        terms.append((config["kd"], ActuatorDrive(None, speed)))
    if config["ki"]:
        most = config["imax"] / abs(config["ki"])
        first = float(compiled.data.act[at])
        first = _within(first, (-most, most)) if most else first
        summing = _integral(compiled, mechanism, name, position.text, most, first)
        if isinstance(summing, str):
            return summing
        states.append(summing)
        terms.append((config["ki"], ActuatorDrive(None, summing.name)))
    return _sum_of(terms, states)


def _sum_of(terms: Sequence[tuple[float, ActuatorDrive]], states: Sequence[StateOf]) -> ActuatorDrive:
    """The drive Σ factor × drive with these states; it is constant where all drives are."""
    values = [factor * each.constant for factor, each in terms if each.constant is not None and factor]
    if len(values) == sum(bool(factor) for factor, _ in terms):
        return ActuatorDrive(sum(values), shown(sum(values)))
    return ActuatorDrive(
        None, f"({summed([(factor, each.text) for factor, each in terms if each.text != '0'])})", (*states,)
    )


def _slewed(
    compiled: CompiledMjcf,
    mechanism: ImportedMechanism,
    name: str,
    command: ActuatorDrive,
    fastest: float,
    first: float,
) -> ActuatorDrive:
    """The drive of a setpoint that begins at `first` and follows the command at most at the rate `fastest`."""
    if command.constant is not None:
        way, most = command.constant - first, f"{shown(fastest)}*t"
        return ActuatorDrive(None, f"({shown(first)} + min(max({shown(way)}, -{most}), {most}))") if way else command
    x = free_symbol(mechanism, f"{name}_setpoint")
    h = float(compiled.model.opt.timestep)
    state = StateOf(x, within(f"({command.text} - {x})/{shown(h)}", (-fastest, fastest)), first)
    return ActuatorDrive(None, x, (state,))


def _integral(
    compiled: CompiledMjcf, mechanism: ImportedMechanism, name: str, position: str, most: float, first: float
) -> StateOf | str:
    """The state ∫ (position - length) dt, within ±most where that is not 0; or the reason why there is none."""
    if most and abs(first) > most:
        return "its integral begins beyond its limit"
    x = free_symbol(mechanism, f"{name}_integral")
    return StateOf(x, _limited(compiled, f"{position} - {LENGTH}", x, (-most, most) if most else None), first)


def _activation_range(compiled: CompiledMjcf, number: int) -> tuple[float, float] | None:
    model = compiled.model
    low, high = (float(each) for each in model.actuator_actrange[number])
    return (low, high) if model.actuator_actlimited[number] else None


def _within(value: float, limits: tuple[float, float] | None) -> float:
    return value if limits is None else min(max(value, limits[0]), limits[1])


def _limited(compiled: CompiledMjcf, rate: str, x: str, limits: tuple[float, float] | None) -> str:
    """The rate of x, limited so that x stays within its limits over one time step of the model."""
    if limits is None:
        return rate
    h = shown(float(compiled.model.opt.timestep))
    low, high = (f"({shown(each)} - {x})/{h}" for each in limits)
    return f"min(max({rate}, {low}), {high})"


def add_states(mechanism: ImportedMechanism, drive: ActuatorDrive, length: str) -> None:
    """Add the states of a drive to the mechanism; `length` is the expression of the actuator's length."""
    for state in drive.states:
        entry: dict[str, object] = {"derivative": Bare(state.derivative.replace(LENGTH, f"({length})"))}
        if state.initial:
            entry["initial"] = state.initial
        mechanism.states[state.name] = entry
