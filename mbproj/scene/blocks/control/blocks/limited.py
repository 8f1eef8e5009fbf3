"""Blocks that are not linear, or that act at instants: a limited rate, a delay.

slow: {rate_limit: {of: wanted, rate: 5 V/s, time: 1 ms}}
late: {delay: {of: pin.angle, time: 20 ms, period: 2 ms}}
"""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.elements.controlled import Controller, Held, ScalarState, Signal
from mbproj.functions.standard import reading, weighted, within
from mbproj.scene.blocks.control.blocks.block import ControlBlock, Expanded, Given, number_of, unit_like
from mbproj.scene.blocks.control.expression import VALUE
from mbproj.scene.blocks.expectations import MEASURE
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.fields.containers import Record
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Unfit

#: The most samples that a delay may hold.
MOST_SAMPLES = 1000
#: How far a delay may be from a whole number of periods, relative to that number.
ROUND_OFF = 1e-9


@dataclass(frozen=True)
class RateLimit(ControlBlock):
    """A signal y that follows `of` with the rate y' = (of - y)/time, at most `rate` upwards and at most `falling`
    downwards."""

    of: Given
    rate: float
    falling: float
    time: float
    initial: Value | None
    scale: float

    def expanded(self, name: str, unit: str | None) -> Expanded:
        program, y = self.of[0], reading(f"{name}.y")
        wanted = weighted([(1.0 / self.time, program), (-1.0 / self.time, y)])
        own = unit_like(self.of, unit, self.initial)
        start = number_of(self.initial, 0.0)
        state = ScalarState(f"{name}.y", within(wanted, -self.falling, self.rate), start, self.scale, own)
        return Expanded((Signal(name, y, own),), (state,))


@dataclass(frozen=True)
class Delay(ControlBlock):
    """The value that `of` had `count` periods ago, sampled at instants and held in between; `initial` before that."""

    of: Given
    count: int
    period: float
    initial: Value | None

    def expanded(self, name: str, unit: str | None) -> Expanded:
        own, start = unit_like(self.of, unit, self.initial), number_of(self.initial, 0.0)
        kept = [f"x{at}" for at in range(1, self.count + 1)]
        read = [self.of[0], *(reading(f"{name}.{each}") for each in kept)]
        states = tuple(Held(each, program, start, own) for each, program in zip(kept, read, strict=False))
        controller = Controller(name, self.period, (Held("value", read[-1], start, own),), states)
        return Expanded((Signal(name, reading(f"{name}.value"), own),), controllers=(controller,))


def _rate_limit(
    of: Given, rate: float, time: float, falling: float | None = None, initial: Value | None = None, scale: float = 1.0
) -> RateLimit:
    return RateLimit(of, rate, rate if falling is None else falling, time, initial, scale)


def _delay(of: Given, time: float, period: float, initial: Value | None = None) -> Delay:
    periods = time / period
    count = round(periods)
    if count < 1 or abs(periods - count) > ROUND_OFF * periods:
        raise Unfit(f"delays by {time:g} s, which is {periods:g} periods", "give a whole number of periods, at least 1")
    if count > MOST_SAMPLES:
        raise Unfit(f"keeps {count} values, at most {MOST_SAMPLES}", "give a longer 'period'")
    return Delay(of, count, period, initial)


LIMITED_BLOCKS: dict[str, Record[ControlBlock]] = {
    "rate_limit": Record(
        "a limited rate",
        {
            "of": VALUE,
            "rate": Number(None, above=0.0),
            "time": Number("s", above=0.0),
            "falling": Number(None, above=0.0),
            "initial": MEASURE,
            "scale": Number(None, above=0.0),
        },
        _rate_limit,
        ("of", "rate", "time"),
    ),
    "delay": Record(
        "a delay",
        {"of": VALUE, "time": Number("s", above=0.0), "period": Number("s", above=0.0), "initial": MEASURE},
        _delay,
        ("of", "time", "period"),
    ),
}
