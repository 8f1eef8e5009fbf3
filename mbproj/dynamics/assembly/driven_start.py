"""Motions and speeds at the start of a run: errors where the mechanism cannot meet them."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.equations.motions import Drive
from mbproj.errors import InputError, Problem
from mbproj.model.compile.guess import Guess
from mbproj.model.system import Conditions, System
from mbproj.thresholds import THRESHOLDS


def refuse_contradictions(system: System, guess: Guess, drive: Drive) -> None:
    """Raise InputError where a motion starts at another value or speed than its joint's own conditions."""
    motions, problems = system.motions, []
    for number, index in enumerate(motions.joint_coordinate.tolist()):
        name, unit = system.names.coordinates[index], system.names.coordinate_units[index]
        for word, conditions, actual in (
            ("", guess.start, drive.value[number]),
            (" per s", guess.speed, drive.rate[number]),
        ):
            asked = _value_at(conditions, index)
            if asked is not None and abs(asked - actual) > THRESHOLDS.same_written * (1.0 + abs(asked)):
                message = (
                    f"motion '{system.names.motions[number]}' begins with {name} at {actual:.6g} {unit}{word}, "
                    f"and the joint's own condition asks for {asked:.6g}"
                )
                problems.append(Problem(message, motions.places[number], "take the joint's condition out"))
    if problems:
        raise InputError(problems)


def _value_at(conditions: Conditions, index: int) -> float | None:
    values = conditions.value[conditions.index == index]
    return float(values[0]) if len(values) else None


def motions_out_of_reach(system: System, left: Array) -> InputError:
    """Return the error for motions whose initial values the joints cannot reach; `left` (k,) is the scaled violation of
    each."""
    hint = "begin at the pose that 'bodies' gives, or take out other motions and conditions"
    return _worst(system, left, "the mechanism cannot reach where motion '{}' begins", hint)


def motions_at_odds(system: System, left: Array) -> InputError:
    """Return the error for motions whose velocities contradict; `left` (k,) is the violation of each."""
    hint = "its joints, or other motions and speeds, hold it: drive no more than there are degrees of freedom"
    return _worst(system, left, "the mechanism cannot move as motion '{}' asks at the start", hint)


def speeds_at_odds(system: System, guess: Guess, q: Array, of_joints: Array, of_speeds: Array) -> InputError:
    """Return the error for joints' speeds that no velocity meets: they contradict each other, or joints would open. The
    violations are those of the joints' rows and of the speeds."""
    message, hint = "the mechanism cannot move at the speeds that its joints ask for", "give fewer speeds, or others"
    if of_speeds.max(initial=0.0) >= of_joints.max(initial=0.0):
        worst = int(system.coordinates.owner[guess.speed.index[np.argmax(of_speeds)]])
        off = f"joint '{system.names.joints[worst]}' is off by {of_speeds.max():.3g}"
        hint = "give fewer speeds than degrees of freedom, or speeds that agree"
    else:
        from mbproj.dynamics.assembly.adjust import needed, rounded_up

        row = int(np.argmax(of_joints))
        worst = int(system.joints.owner[row])
        off = f"joint '{system.names.joints[worst]}' would open at {of_joints[row]:.3g} {system.joints.units[row]}/s"
        if size := needed(system, q):
            hint = f"its loop moves where joints are moved a little: give adjust_joints: {rounded_up(size)}"
    return InputError(Problem(f"{message}: {off}", system.joint_places[worst], hint))


def _worst(system: System, left: Array, message: str, hint: str) -> InputError:
    worst = int(np.argmax(np.abs(left)))
    return InputError(Problem(message.format(system.names.motions[worst]), system.motions.places[worst], hint))
