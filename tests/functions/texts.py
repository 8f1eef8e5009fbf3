"""Expressions of time as texts, the times at which they are tested, and how they are compiled."""

from __future__ import annotations

import numpy as np

from mbproj.functions.program import TIME
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.expressions.syntax_tree import parse

T = np.linspace(0.13, 1.7, 23)


def expression(text):
    return compiled(parse(text), {"a": Value(1.25, None)}, {"t": TIME})[0]


SMOOTH = [
    "t",
    "3",
    "-t",
    "t + 2*t",
    "1 - t",
    "t*sin(t)",
    "sin(t)/(1 + t)",
    "t**3",
    "t**0",
    "t**1",
    "t**-2",
    "t**1.5",
    "(1 + t)**t",
    "2**t",
    "a**t",
    "sqrt(1 + t)",
    "exp(-t)*cos(7*t)",
    "log(2 + t)",
    "log10(1 + t**2)",
    "tan(t/2)",
    "asin(t/3)",
    "acos(t/3)",
    "atan(2*t)",
    "atan2(sin(t), 2 + cos(t))",
    "hypot(3, t)",
    "hypot(t, 4, 2*t)",
    "sinh(t)",
    "cosh(t)",
    "tanh(3*t)",
    "min(t, 9)",
    "max(t, 9, t/2)",
    "abs(t - 5)",
    "sign(t)*t",
    "floor(t/4) + ceil(t/4)",
    "hypot(-t)",
    "(2*t) deg",
    "t rad/s",
    "1/(1/t)",
]
