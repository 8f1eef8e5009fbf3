"""The fastest modes of a scene's forces and states, and the steps that explicit integrators need, as text and JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi
from typing import Any

from mbproj.integrate.stiff.fast_forces import FastMode

#: A mode decays rather than vibrates where its imaginary part is less than this part of |λ|.
VIBRATES = 0.5


def facts(modes: Sequence[FastMode], steps: Mapping[str, float]) -> dict[str, Any]:
    """`fast_modes` and `stable_steps` as a dictionary for JSON, in Hz, 1/s and s."""
    return {
        "fast_modes": [
            {
                "forces": list(mode.forces),
                "states": list(mode.states),
                "bodies": list(mode.bodies),
                "frequency": abs(mode.eigenvalue.imag) / (2.0 * pi),
                "growth": mode.eigenvalue.real,
                "time_constant": mode.time_constant,
            }
            for mode in modes
        ],
        "stable_steps": dict(steps),
    }


def lines(modes: Sequence[FastMode], steps: Mapping[str, float]) -> list[str]:
    """A line of text for each mode and for each step; none without modes."""
    if not modes:
        return []
    width = max(map(len, steps), default=0)
    largest = [f"    {name:{width}}  {_short(step)}" for name, step in steps.items()]
    rows = [f"    {_quoted(mode.forces or mode.states)}{_on_bodies(mode)} {_motion(mode)}" for mode in modes]
    by = "forces and states" if any(mode.states for mode in modes) else "forces"
    return [f"  fastest by their {by}, at the start", *rows, "  stable up to steps of", *largest]


def _on_bodies(mode: FastMode) -> str:
    return f" on {_quoted(mode.bodies)}" if mode.bodies else ""


def _motion(mode: FastMode) -> str:
    size = abs(mode.eigenvalue)
    if abs(mode.eigenvalue.imag) < VIBRATES * size:
        return f"decays, time constant {_short(mode.time_constant)}"
    hertz = abs(mode.eigenvalue.imag) / (2.0 * pi)
    return f"vibrates with {hertz:.3g} Hz, time constant {_short(mode.time_constant)}"


def _short(seconds: float) -> str:
    """A time with three digits in s, ms or µs."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= 0.1 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3g} µs"


def _quoted(names: Sequence[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)
