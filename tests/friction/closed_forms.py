"""What dry friction does in mechanisms of one coordinate, in closed form: brakes, inclines, a belt, a screw, a guide.

Nothing here knows mbproj. `test_closed_forms.py` holds each against an integration by SciPy or against statics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Brakes on a rotor of inertia J that turns with ω > 0.


def brake_stops(J, ω, torque):
    """Time and angle to rest under a constant torque: J ω' = -torque."""
    return J * ω / torque, J * ω**2 / (2.0 * torque)


def stribeck_stops(J, ω, sliding, static, speed):
    """Time and angle to rest where the torque rises as the rotor slows down, by quadrature of dt = J dω / T(ω)."""
    from scipy.integrate import quad

    def torque(ω):
        return sliding + (static - sliding) * np.exp(-((ω / speed) ** 2))

    bends = [min(5.0 * speed, 0.5 * ω)]
    time = quad(lambda ω: J / torque(ω), 0.0, ω, epsabs=0.0, epsrel=1e-13, points=bends, limit=200)[0]
    angle = quad(lambda ω: J * ω / torque(ω), 0.0, ω, epsabs=0.0, epsrel=1e-13, points=bends, limit=200)[0]
    return time, angle


def regularised_speed(J, ω, torque, width, t):
    """J ω' = -torque tanh(ω / width): sinh(ω / width) falls exponentially. When the brake would have stopped the rotor
    it still turns with width ln((1 + √5) / 2), to e^(-2ω/width): of order 1 in the width."""
    exponent = ω / width - torque * t / (J * width) + np.log(0.5 * (1.0 - np.exp(-2.0 * ω / width)))
    if exponent > 40.0:  # asinh x is ln 2x
        return width * (exponent + np.log(2.0))
    return width * np.arcsinh(np.exp(exponent))


def regularised_angle(J, ω, torque, width):
    """The angle to rest under torque tanh(ω / width): with ∫₀^∞ x (coth x - 1) dx = π²/12 it is the brake's and
    J width² π² / (12 torque), to e^(-2ω/width): of order 2 in the width."""
    return J / torque * (0.5 * ω**2 + width**2 * np.pi**2 / 12.0)


def eccentric_coasts(J, mass, eccentricity, arm, ω, t):
    """Angle and speed of a rotor without weight whose centre of mass is off its axis; J is about the centre of mass.

    The bearing bears |F| = m e √(ω⁴ + ω'²), its friction is arm |F|: (J + m e²) ω' = -arm m e √(ω⁴ + ω'²). So
    ω' = -k ω² with I k = c √(1 + k²), where I = J + m e² and c = arm m e; ω = ω₀ / (1 + k ω₀ t). Where c ≥ I no sliding
    motion exists at any speed: it is Painlevé's paradox of a rotor.
    """
    inertia, c = J + mass * eccentricity**2, arm * mass * eccentricity
    assert c < inertia, "no sliding motion exists"
    k = c / np.sqrt(inertia**2 - c**2)
    return np.log1p(k * ω * t) / k, ω / (1.0 + k * ω * t)


# A block on an incline.


def held_by(angle):
    """The least static coefficient that holds a block on an incline: tan of the angle (Coulomb 1785)."""
    return np.tan(angle)


def up_an_incline(angle, sliding, speed, g):
    """Time and way to rest of a block that is thrown up an incline."""
    slows = g * (np.sin(angle) + sliding * np.cos(angle))
    return speed / slows, speed**2 / (2.0 * slows)


def down_an_incline(angle, sliding, g):
    """Acceleration down an incline."""
    return g * (np.sin(angle) - sliding * np.cos(angle))


def thrown_across(angle, μ, speed, g):
    """Time to rest, way downhill and way across of a point that is thrown across an incline which friction holds.

    With ψ between velocity and downhill, v' = a (cos ψ - k) and v ψ' = -a sin ψ, where a = g sin of the angle and
    k = μ / tan > 1: the hodograph is v = speed tan(ψ/2)^k / sin ψ, from ψ = π/2 to 0.
    """
    from scipy.integrate import quad

    a, k = g * np.sin(angle), μ / np.tan(angle)

    def over(slowness):
        return quad(slowness, 0.0, 0.5 * np.pi, epsabs=0.0, epsrel=1e-12, limit=200)[0]

    def v(ψ):
        return speed * np.tan(0.5 * ψ) ** k / np.sin(ψ)

    time = over(lambda ψ: v(ψ) / (a * np.sin(ψ)))
    return time, over(lambda ψ: v(ψ) ** 2 / (a * np.tan(ψ))), over(lambda ψ: v(ψ) ** 2 / a)


@dataclass(frozen=True)
class Tilting:
    """A block on an incline that turns with the constant rate ω about the point where the block lies.

    With the block at s up the incline, s' < 0 and the normal force N = m (g cos ωt + 2 ω s') > 0,

        s'' = ω² s - g sin ωt + μ (g cos ωt + 2 ω s'),

    which is linear. It lies still as long as tan ωt < μ_s: s = 0 has neither Coriolis nor centrifugal force.
    """

    ω: float
    sliding: float
    static: float
    g: float

    @property
    def release(self):
        """The time at which the block begins to slide."""
        return np.arctan(self.static) / self.ω

    def __call__(self, t):
        """s and s' at a time t after the release."""
        μ, ω = self.sliding, self.ω
        part = self.g / (2.0 * ω**2 * (1.0 + μ**2))
        a, b = part * (1.0 - μ**2), -2.0 * part * μ
        roots = ω * (μ + np.array([1.0, -1.0]) * np.hypot(1.0, μ))
        φ = ω * self.release
        at_release = np.array([a * np.sin(φ) + b * np.cos(φ), ω * (a * np.cos(φ) - b * np.sin(φ))])
        amplitudes = np.linalg.solve([[1.0, 1.0], roots], -at_release)
        grows = amplitudes * np.exp(roots * (t - self.release))
        s = a * np.sin(ω * t) + b * np.cos(ω * t) + grows.sum()
        return s, ω * (a * np.cos(ω * t) - b * np.sin(ω * t)) + grows @ roots


# A mass on a belt, held back by a spring.


@dataclass(frozen=True)
class Belt:
    """A mass m on a belt of speed v, held by a spring k: it sticks until the spring pulls with `static`, and slips
    under the force `sliding` until it has the belt's speed again (phase plane; Magnus & Popp, Schwingungen, 2005).

    While it slips, x = sliding/k + D cos ωτ + (v/ω) sin ωτ with D = (static - sliding)/k and ω = √(k/m). The speed is v
    again where tan(ωτ/2) = -Dω/v, and there x = sliding/k - D.
    """

    m: float
    k: float
    v: float
    sliding: float
    static: float

    @property
    def drop(self):
        """D, m."""
        return (self.static - self.sliding) / self.k

    @property
    def ω(self):
        """√(k/m), rad/s."""
        return np.sqrt(self.k / self.m)

    @property
    def slips(self):
        """How long it slips in each period, s."""
        return 2.0 / self.ω * (np.pi - np.arctan(self.drop * self.ω / self.v))

    @property
    def sticks(self):
        """How long it sticks in each period, s."""
        return 2.0 * self.drop / self.v

    @property
    def period(self):
        """Of the limit cycle, s."""
        return self.slips + self.sticks

    @property
    def first_slip(self):
        """When it first slips, if it starts on the belt with the spring at rest."""
        return self.static / (self.k * self.v)

    @property
    def amplitude(self):
        """Half of the way between the ends of the limit cycle, m."""
        return np.hypot(self.drop, self.v / self.ω)

    def __call__(self, t):
        """x at a time after the first slip, on the limit cycle."""
        τ = np.mod(t - self.first_slip, self.period)
        slipping = self.sliding / self.k + self.drop * np.cos(self.ω * τ) + self.v / self.ω * np.sin(self.ω * τ)
        return np.where(τ < self.slips, slipping, self.sliding / self.k - self.drop + self.v * (τ - self.slips))


# A screw that carries a mass m; J is its inertia about the axis, h = pitch / 2π, r the radius of the thread.


def screw_runs_down(J, m, h, arm, g):
    """The angular acceleration of a screw that runs down by itself, arm = μ r < h.

    The thread bears λ = m (g + h ω') and resists with arm λ: J ω' = -(h - arm) λ.
    """
    return -(h - arm) * m * g / (J + m * h * (h - arm))


def screw_needs(m, h, arm, g):
    """The torques that begin to raise and to lower a screw, arm = μ_s r: (h + arm) m g and (arm - h) m g downwards. The
    screw holds by itself where the second is positive: where tan of the lead angle, h / r, is below μ_s."""
    return (h + arm) * m * g, (arm - h) * m * g


def screw_is_raised(J, m, h, arm, g, torque):
    """The angular acceleration of a screw under a torque that raises its load: J ω' = torque - (h + arm) λ."""
    return (torque - (h + arm) * m * g) / (J + m * h * (h + arm))


# A slider on a guide of two supports at a distance L.


def pushed_off_axis(force, m, μ, off, length):
    """The acceleration of a slider that is pushed parallel to its guide, `off` beside it: each support bears
    force off / length, so that the friction is 2 μ off / length of the force. Negative where it jams: it stays."""
    return force / m * (1.0 - 2.0 * μ * off / length)


def mass_off_axis(force, m, μ, off, length):
    """Accelerations with which a slider can slide forwards whose centre of mass is `off` beside its guide, under a
    force along the guide: m a = force - κ m |a| with κ = 2 μ off / length. One for κ < 1; for κ > 1 two where the
    force drives the slider and none where it brakes it (Painlevé 1895)."""
    κ = 2.0 * μ * off / length
    found = [force / m / (1.0 + κ), force / m / (1.0 - κ)]
    return [a for a, sign in zip(found, (1.0, -1.0), strict=True) if a * sign >= 0.0]


# A slender block that rocks on its two corners.


def rocking_block_keeps(α):
    """The part of the angular velocity that is left by each impact of a block whose corners are at the angle α from the
    upright as seen from its centre, without bouncing and without slip (Housner 1963): angular momentum about the new
    corner is kept."""
    return 1.0 - 1.5 * np.sin(α) ** 2


def rocking_block_period(α, amplitude, R, g):
    """The period of a block that rocks to this angle without a loss, for small angles: 4/p acosh(1 / (1 - θ/α)) with
    p² = 3 g / (4 R) (Housner 1963); R from a corner to the centre."""
    p = np.sqrt(0.75 * g / R)
    return 4.0 / p * np.arccosh(1.0 / (1.0 - amplitude / α))
