"""Runs of scenes with stops, with what is recorded of them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.motion.marks import START
from tests.support import assembled

DOP853 = "integrator: dop853, tolerance: 1.0e-11, output_step: 0.1"
FIXED = "integrator: rk4, step: 1.0e-3, output_step: 0.1"


@dataclass
class Recorded:
    """Takes what a run records."""

    blocks: list = field(default_factory=list)
    happened: list = field(default_factory=list)

    def write(self, block):
        self.blocks.append({path: np.array(block[path]) for path in block})

    def events(self, events):
        self.happened = list(events)

    def __getitem__(self, path):
        return np.concatenate([block[path] for block in self.blocks])

    def of(self, *kinds):
        """The events of these kinds."""
        return [event for event in self.happened if event.kind in kinds]

    @property
    def unbalanced(self):
        """The largest |E(t) - E(0) - W + D|, J."""
        return np.abs(self["diagnostics/energy_balance"]).max()


def run(text, **parameters):
    """A scene's run: the report, and what was recorded."""
    scene = read_scene_text(text, parameters={name: str(value) for name, value in parameters.items()})
    recorded = Recorded()
    report = simulate(*assembled(scene), settings_to_run(scene), recorded)
    return report, recorded


def same(own, expected, paths, near):
    """Checks that two runs record the same events, at the same times, and the same numbers, to `near` of their
    scale."""
    told = [[(event.name, event.kind, event.direction) for event in each.happened] for each in (own, expected)]
    assert told[0] == told[1]
    assert len(own.happened) > 0
    for event, other in zip(own.happened, expected.happened, strict=True):
        assert event.time == pytest.approx(other.time, abs=near)
        assert (event.impulse, event.energy) == pytest.approx((other.impulse, other.energy), rel=near, abs=near)
    for path in paths:
        if path in expected.blocks[0]:
            scale = max(1.0, np.abs(expected[path]).max(initial=0.0))
            np.testing.assert_allclose(own[path], expected[path], rtol=0, atol=near * scale, err_msg=path)


def simulated(text, mark=START):
    """A scene's run, from a mark on: what was recorded, and the marks from which other runs can go on."""
    scene = read_scene_text(text)
    system = compile_system(scene)
    recorded, kept = Recorded(), []
    simulate(
        system,
        assemble(system, initial_guess(scene, system)),
        settings_to_run(scene),
        recorded,
        keep=lambda formulation, build, newest: kept.append(newest),
        resumed=mark,
    )
    return recorded, kept


def goes_on(text, duration, until, paths):
    """Checks that a run of this text that goes on where one to `until` ends has the bits of the whole one, events too.

    The whole run, the shorter one, and the time of the mark.
    """
    whole, _ = simulated(text)
    assert f"duration: {duration}" in text
    part, kept = simulated(text.replace(f"duration: {duration}", f"duration: {until}"))
    rest, _ = simulated(text, kept[-1])
    time = kept[-1]["t"]
    assert 0.0 < time <= until
    after = whole["time"] > time
    assert len(part["time"]) < after.size
    for path in ("time", "bodies/position", "bodies/velocity", *paths):
        assert np.array_equal(rest[path], whole[path][after]), path
    assert rest.happened == whole.happened
    return whole, part, time
