"""The bound: equations of minimal coordinates, derived by hand for these mechanisms alone, compiled."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from functools import partial

import numpy as np

from peers.compiled import Integrate, advance, controlled_settings, fixed_settings, library
from peers.peer import Observation, Peer, Setting, ode_label, seconds_of
from peers.problem import FIVE_BAR, LENGTH, SLIDER_CRANK, Array, Chain, Mechanism, SliderCrank

#: The dense mass matrix costs the cube of the links: beyond this number it bounds nothing.
DENSE_LINKS = 20
LIBRARY = library("hand_derived.cpp", ("-march=native",))
LIBRARY.chain.restype = LIBRARY.slider_crank.restype = ctypes.c_long
LIBRARY.slider_place.restype = ctypes.c_double


def _chain(links: int) -> Integrate:
    return advance(LIBRARY.chain, ctypes.c_int(links))


def _tip(states: Array) -> Observation:
    angles = states[..., : states.shape[-1] // 2]
    return Observation(LENGTH * np.stack([np.cos(angles).sum(axis=-1), np.sin(angles).sum(axis=-1)], axis=-1))


def _slider(states: Array) -> Observation:
    return Observation(np.array([LIBRARY.slider_place(ctypes.c_double(angle)) for angle in states[:, 0]]))


def _settings(method: str, mechanism: Mechanism) -> Iterator[Setting]:
    if mechanism is FIVE_BAR:
        run, start, measure = _chain(5), np.zeros(10), _tip
    else:
        assert mechanism is SLIDER_CRANK
        run, start, measure = advance(LIBRARY.slider_crank), np.array([0.0, SliderCrank.SPEED]), _slider
    if method == "rk4":
        yield from fixed_settings(run, start, measure, mechanism, (5, 5000))
    else:
        yield from controlled_settings(run, start, measure, mechanism)


def _chain_setting(chain: Chain) -> Setting | None:
    if chain.links > DENSE_LINKS:
        return None
    run = _chain(chain.links)

    def integrate() -> float:
        y = np.zeros(2 * chain.links)
        return seconds_of(lambda: run("rk4", y, chain.steps * chain.step, chain.steps, 0.0))

    def observe() -> Observation:
        y = np.zeros(2 * chain.links)
        run("rk4", y, chain.steps * chain.step, chain.steps, 0.0)
        return _tip(y)

    return Setting(ode_label(chain.step), integrate, observe)


def chain_tip(chain: Chain) -> Array:
    """The tip (2,) of a chain at its end, to a tolerance of 1e-12, m."""
    y = np.zeros(2 * chain.links)
    _chain(chain.links)("dop853", y, chain.steps * chain.step, 0, 1e-12)
    return _tip(y).points


PEERS = (
    Peer("hand-derived, RK4", partial(_settings, "rk4"), _chain_setting, bound=True),
    Peer("hand-derived, DOP853", partial(_settings, "dop853"), bound=True),
)
