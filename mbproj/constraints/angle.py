"""The angle of a vector in the plane of two others."""

from __future__ import annotations

from typing import final

import numpy as np

from mbproj.arrays import Numbers, dot
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass


@final
@dataclass(frozen=True)
class Angle(Primitive):
    """φ = atan2(u·y, u·x): the angle of u about x × y, from x towards y, in radians within (-π, π].

    x and y are fixed in one body and u in the other (Haug 1989, sect. 9.2.6: relative rotation).
    """

    slots = ("vector", "vector", "vector")
    rows = 1
    unit = "rad"

    def value(self, x: Numbers) -> Numbers:
        cosine, sine = _cosine_and_sine(x)
        # The derivative of arctan2 by the complex step needs this form: numpy.arctan2 takes real arguments only.
        real = np.arctan2(sine.real, cosine.real)
        if not np.iscomplexobj(x):
            return real[..., None]
        rate = (cosine.real * sine.imag - sine.real * cosine.imag) / (cosine.real**2 + sine.real**2)
        return (real + 1j * rate)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        cosine, sine = _cosine_and_sine(x)
        radius2 = cosine**2 + sine**2
        s, c = (sine / radius2)[..., None], (cosine / radius2)[..., None]
        first, second, u = x[..., 0, :], x[..., 1, :], x[..., 2, :]
        return np.stack([-s * u, c * u, c * second - s * first], axis=-2)[..., None, :, :]

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        cosine, sine = _cosine_and_sine(x)
        cosine_dot, sine_dot = _their_rates(x, x_dot)
        return ((cosine * sine_dot - sine * cosine_dot) / (cosine**2 + sine**2))[..., None]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        cosine, sine = _cosine_and_sine(x)
        cosine_dot, sine_dot = _their_rates(x, x_dot)
        radius2 = cosine**2 + sine**2
        first_dot, second_dot, u_dot = x_dot[..., 0, :], x_dot[..., 1, :], x_dot[..., 2, :]
        bend = 2.0 * (cosine * dot(u_dot, second_dot) - sine * dot(u_dot, first_dot)) / radius2
        rate = (cosine * sine_dot - sine * cosine_dot) / radius2
        stretch = (cosine * cosine_dot + sine * sine_dot) / radius2
        return (bend - 2.0 * rate * stretch)[..., None]


def _cosine_and_sine(x: Numbers) -> tuple[Numbers, Numbers]:
    return dot(x[..., 2, :], x[..., 0, :]), dot(x[..., 2, :], x[..., 1, :])


def _their_rates(x: Numbers, x_dot: Numbers) -> tuple[Numbers, Numbers]:
    (first, second, u), (first_dot, second_dot, u_dot) = ([each[..., k, :] for k in range(3)] for each in (x, x_dot))
    return dot(u_dot, first) + dot(u, first_dot), dot(u_dot, second) + dot(u, second_dot)
