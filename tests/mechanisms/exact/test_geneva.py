"""A Geneva drive that nothing drives: its wheel by the closed form, its speed by the energy, its time by quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from mbproj import InputError, read_scene_text
from mbproj.base.mechanisms_folder import mechanism
from mbproj.functions.standard import Curve
from mbproj.joints.table import geneva
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.running import run

J1, J2, HELD = 2e-3, 0.5e-3, 10.0


def law(φ, slots):
    """f and f' of the pin in its slots, and of the disc."""
    k = np.sin(np.pi / slots)
    turns = np.round(φ / (2.0 * np.pi))
    φ = φ - 2.0 * np.pi * turns
    held = np.cos(φ) < k
    f = np.where(held, np.sign(φ) * np.pi / slots, np.arctan2(k * np.sin(φ), 1.0 - k * np.cos(φ)))
    slope = np.where(held, 0.0, k * (np.cos(φ) - k) / (1.0 - 2.0 * k * np.cos(φ) + k * k))
    return f + 2.0 * np.pi / slots * turns, slope


@pytest.mark.parametrize("slots", [3, 4, 8])
def test_the_function_is_that_of_a_pin_in_a_slot(slots):
    """With f' and, of 4, the numbers of the literature: f' = 2.414214 at the middle, f'' = 1 as it enters."""
    φ = np.linspace(-np.pi, np.pi, 20001)
    f, slope, bend = Curve(geneva(float(slots)).function)(φ)
    own, own_slope = law(φ, slots)
    np.testing.assert_allclose(-f[1:-1], own[1:-1], atol=1e-15)
    np.testing.assert_allclose(-slope, own_slope, atol=1e-14)
    if slots == 4:
        inside = np.abs(φ) < 0.25 * np.pi
        np.testing.assert_allclose(-slope.min(), 1.0 + np.sqrt(2.0), rtol=1e-12)
        np.testing.assert_allclose(np.abs(bend[inside]).max(), 5.406981, rtol=1e-6)
        np.testing.assert_allclose(-Curve(geneva(4.0).function)(np.array([-0.25 * np.pi + 1e-12]))[2], 1.0, rtol=1e-9)


@needs_kernel
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
@pytest.mark.parametrize("slots", [4, 6])
def test_three_turns_keep_the_energy_and_the_closed_form(slots, formulation):
    how = {"formulation": formulation, "tolerance": "1.0e-13"}  # the energy is off by twice the tolerance
    done = run("geneva", **how, parameters={"slots": slots}, duration="2.2 s")
    φ, wheel = done["joints/coordinate"].T[:2]
    assert φ[-1] > 6.0 * np.pi
    f, slope = law(φ, slots)
    np.testing.assert_allclose(wheel, -f, atol=2e-13)
    speed = HELD / np.sqrt(1.0 + J2 / J1 * slope**2)
    np.testing.assert_allclose(done["joints/speed"][:, 0], speed, rtol=1e-11)
    energy = done["diagnostics/total_energy"]
    assert np.abs(energy / energy[0] - 1.0).max() <= 5e-13
    enters = 0.5 * np.pi - np.pi / slots
    half = quad(lambda φ: np.sqrt(1.0 + J2 / J1 * law(φ, slots)[1] ** 2) / HELD, 0.0, enters, epsabs=1e-14)[0]
    turn = 2.0 * half + 2.0 * (np.pi - enters) / HELD
    at = int(np.argmin(np.abs(done["time"] - 3.0 * turn)))
    apart = done["time"][at] - 3.0 * turn
    reached = quad(lambda φ: np.sqrt(1.0 + J2 / J1 * law(φ, slots)[1] ** 2) / HELD, 0.0, φ[at] - 6.0 * np.pi)[0]
    assert abs(reached - apart) <= 1e-12


@pytest.mark.parametrize(
    ("slots", "message"),
    [("2", "has 2 for a number of slots; give a whole number, 3 or more"), ("4.5", "has 4.5 for a number of slots")],
)
def test_what_is_refused(slots, message):
    text = mechanism("geneva").read_text(encoding="utf-8").replace("slots: slots", f"slots: {slots}")
    with pytest.raises(InputError) as caught:
        read_scene_text(text)
    assert message in str(caught.value)
