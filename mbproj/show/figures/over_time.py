"""Pictures of a run over time: markers, joint coordinates, energies, steps, violations, certified errors, ratios."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.base.arrays import Array, Flags
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import shortened
from mbproj.results.analysis.expectations import mechanical_advantage, transmission_angle, velocity_ratio
from mbproj.results.record import Results
from mbproj.results.trust import Trust
from mbproj.show.figures import fitted_text, panels, rows
from mbproj.show.figures.panels import small_print
from mbproj.show.figures.rows import MAX_ROWS, SIGN, PanelGroup, PanelQuantity, coinciding
from mbproj.show.figures.style import DEGREES, METRES, AxisUnit, line, sizes, styled, units_of

# --- Position and velocity of each marker -----------------------------------------------------------------------------

#: A component counts as hidden where it moves by less than this part of the range of its panel.
HIDDEN = 0.03
PANELS = (("position", METRES.value), ("velocity", METRES.speed))


@dataclass(frozen=True)
class Components:
    """A reader of components (T, k) of a marker; None where a result has no such marker."""

    marker: str
    member: str
    which: tuple[int, ...]

    def __call__(self, result: Results) -> Array | None:
        if self.marker not in result.names("markers"):
            return None
        values: Array = getattr(result.marker(self.marker), self.member)
        return values[:, list(self.which)]


@styled
def draw_markers(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw one result with a row for each marker and lines x, y, z; a component that others would hide gets its own
    row. Draw several with a row for each component, and the distance of the markers."""
    names = fitted_text.all_names(results, "markers")
    single = len(results) == 1
    moving = _moving(results, names)
    listed = [_rows_apart(name, results[0], moving) if single else _overlaid_markers(name, moving) for name in names]
    groups = rows.fitting(listed, results)
    cut = fitted_text.note("markers", len(groups), len(names), "choose others with --marker")
    still = ", ".join("xyz"[index] for index in range(3) if index not in moving)
    zero = f"{still} {'are' if len(still) > 1 else 'is'} zero throughout" if still else ""
    return rows.draw_rows(results, labels, groups, "; ".join(filter(None, (cut, zero))))


def _moving(results: Sequence[Results], names: Sequence[str]) -> tuple[int, ...]:
    """The components that are not always zero, up to round-off, at all markers. In a plane motion normal to an axis
    these are two. All components, where none is left."""
    largest = np.zeros((len(PANELS), 3))
    for place, (member, _) in enumerate(PANELS):
        for result in results:
            for name in set(names) & set(result.names("markers")):
                values = np.abs(getattr(result.marker(name), member))
                largest[place] = np.maximum(largest[place], np.nanmax(values, axis=0, initial=0.0))
    some = (largest > panels.ROUND_OFF * largest.max(axis=1, keepdims=True)).any(axis=0)
    return tuple(np.flatnonzero(some).tolist()) or (0, 1, 2)


def mark_untrusted(figure: Figure, results: Sequence[Results], limit: float) -> str:
    """Shade each marker's panels from the time on at which its error may exceed the limit. Return a text on it."""
    axes: dict[str, list[Axes]] = {}
    for axis in figure.axes:
        axes.setdefault(str(axis.get_label()), []).append(axis)
    return panels.shade(axes, results, limit)


def _rows_apart(name: str, result: Results, moving: tuple[int, ...]) -> PanelGroup:
    """Rows of components that do not hide each other."""
    listed = []
    for together in legible(result.marker(name).position, result.marker(name).velocity):
        which = tuple(index for index in together if index in moving)
        if not which:
            continue
        parts = tuple(("xyz"[index], index) for index in which)
        some = "" if len(which) == len(moving) else ", ".join(part for part, _ in parts)
        words = (f"{name}: {some}", f"velocity {some}") if some else (f"position of {name}", "velocity")
        quantities = [(unit, Components(name, word, which)) for word, unit in PANELS]
        listed.append(tuple(PanelQuantity(text, *of, parts) for text, of in zip(words, quantities, strict=True)))
    return PanelGroup(tuple(listed), name=name)


def _overlaid_markers(name: str, moving: tuple[int, ...]) -> PanelGroup:
    listed = []
    for index in moving:
        component = "xyz"[index]
        row = [(unit, Components(name, word, (index,))) for word, unit in PANELS]
        words = f"{name}: {component}", f"velocity {component}"
        listed.append(tuple(PanelQuantity(text, *quantity) for text, quantity in zip(words, row, strict=True)))
    apart = tuple(PanelQuantity(SIGN, unit, Components(name, word, (0, 1, 2))) for word, unit in PANELS)
    return PanelGroup(tuple(listed), apart, name)


def legible(*histories: Array) -> list[tuple[int, ...]]:
    """Group the components of vectors (T, 3) so that none hides another of its group. Small movements beside large
    ones, or far from them, would be hidden. A component that does not move cannot be hidden."""
    chosen: list[tuple[int, ...]] = []
    moved = np.max([_ranges(history) for history in histories], axis=0)
    for index in sorted(range(3), key=lambda index: -moved[index]):
        for place, group in enumerate(chosen):
            together = tuple(sorted((*group, index)))
            if not any(_hides(history[:, list(together)]) for history in histories):
                chosen[place] = together
                break
        else:
            chosen.append((index,))
    return sorted(chosen)


def _ranges(values: Array) -> Array:
    """The range of each component (3)."""
    finite = np.where(np.isfinite(values), values, 0.0)
    distance: Array = np.ptp(finite, axis=0)
    return distance


def _hides(values: Array) -> bool:
    """Whether in one panel with these components (T, k) some moving component would be hidden."""
    finite = values[np.all(np.isfinite(values), axis=1)]
    if not len(finite):
        return False
    moved, whole = _ranges(finite), float(np.ptp(finite))
    moves = moved > max(panels.STILL * float(moved.max()), panels.ROUND_OFF * float(np.abs(finite).max()))
    return bool(np.any(moves & (moved < HIDDEN * whole)))


# --- Joint coordinates and their speeds over time ---------------------------------------------------------------------


#: The most names in one remark.
NAMED = 6


@styled
def draw_coordinates(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw a row for each coordinate, its value beside its speed, with a line for each result. Coordinates that
    coincide are drawn once."""
    names = fitted_text.all_names(results, "coordinates")
    same = coinciding(results, names)
    groups = rows.fitting([_coordinate_group(results, name) for name in same], results)
    remarks = [fitted_text.note("coordinates", len(groups), len(same), "choose others with --joint")]
    remarks += [
        f"{name} and {shortened(others, NAMED)} coincide"
        for name, others in list(same.items())[: len(groups)]
        if others
    ]
    return rows.draw_rows(results, labels, groups, "; ".join(filter(None, remarks)))


def _coordinate_group(results: Sequence[Results], name: str) -> PanelGroup:
    def value(result: Results) -> Array | None:
        return result.coordinate(name).value if name in result.names("coordinates") else None

    def speed(result: Results) -> Array | None:
        return result.coordinate(name).speed if name in result.names("coordinates") else None

    coordinates = [result.coordinate(name) for result in results if name in result.names("coordinates")]
    units = units_of(coordinates[0].unit, [each.value for each in coordinates])
    row = PanelQuantity(name, units.value, value), PanelQuantity("speed", units.speed, speed)
    apart = PanelQuantity(SIGN, units.value, value), PanelQuantity(SIGN, units.speed, speed)
    return PanelGroup((row,), apart)


# --- Energies and their balance ---------------------------------------------------------------------------------------
# Energies, and the balance E(t) - E(0) - W + D, which is zero apart from errors of integration.


ENERGIES = ("kinetic", "potential", "total")
BALANCE = "energy balance"
JOULE = AxisUnit("J", "J")


@styled
def draw_energy(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw one result with its energies in one panel and the balance below. Draw several with a panel for each energy
    and the balance, and the differences in kinetic and total energy below."""
    if len(results) > 1:
        return rows.draw_rows(results, labels, [_overlaid_energies()])
    (result,) = results
    figure, axes = panels.panels(2, height=2.1)
    for index, energy in enumerate(ENERGIES):
        panels.plot(axes[0, 0], result.abscissa, result[f"diagnostics/{energy}_energy"], energy, index)
    # The axis names the balance; the legend is for the energies.
    panels.plot(axes[1, 0], result.abscissa, result["diagnostics/energy_balance"], "", 0)
    panels.hold_still([axes[0, 0]], sizes(results)["J"])
    panels.name(axes[0, 0], "energy", "J")
    panels.name(axes[1, 0], BALANCE, "J")
    return panels.finish(figure)


def _overlaid_energies() -> PanelGroup:
    kinetic, potential, total = (
        PanelQuantity(f"{energy} energy", JOULE, _reader(f"diagnostics/{energy}_energy")) for energy in ENERGIES
    )
    # The balance keeps its own scale, because its size tells how good a run is.
    balance = PanelQuantity(BALANCE, JOULE, _reader("diagnostics/energy_balance"), held=False)
    apart = tuple(PanelQuantity(f"{SIGN} of {each.words}", JOULE, each.read) for each in (kinetic, total))
    return PanelGroup(((kinetic, potential), (total, balance)), apart)


def _reader(path: str) -> Callable[[Results], Array]:
    def read(result: Results) -> Array:
        return result[path]

    return read


# --- The steps of a run -----------------------------------------------------------------------------------------------
# Their size, and the iterations of the projection in each.


ITERATIONS = (
    ("diagnostics/projection_iterations", "position iterations a step"),
    ("diagnostics/velocity_iterations", "velocity iterations a step"),
)
REJECTED = "×: steps were rejected since the sample before"
#: The ratio of the largest to the smallest step from which on the axis is logarithmic.
WIDE = 20.0


@styled
def draw_steps(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw three panels with a line for each result. Iterations are averages over the steps between two samples.
    Samples inside one step share that step's value."""
    figure, axes = panels.panels(3)
    sizes, remark = [result["diagnostics/step_size"] for result in results], ""
    for index, (result, label) in enumerate(zip(results, labels, strict=True)):
        panels.plot(axes[0, 0], result.time, sizes[index], label, index, drawstyle="steps-pre")
        after = rejected(result)
        if after.any():
            crosses = {"linestyle": "none", "marker": "x", "markersize": 4}
            panels.plot(axes[0, 0], result.time[after], sizes[index][after], "", index, **crosses)
            remark = REJECTED
        for axis, (path, _) in zip(axes[1:, 0], ITERATIONS, strict=True):
            panels.plot(axis, result.time, _filled_forward(per_step(result, path)), label, index, drawstyle="steps-pre")
    for axis, (_, name) in zip(axes[1:, 0], ITERATIONS, strict=True):
        panels.name(axis, name)
        _from_zero(axis)
    panels.name(axes[0, 0], "step size", "s")
    _scale(axes[0, 0], np.concatenate(sizes))
    return panels.finish(figure, remark=remark, with_legend=len(results) > 1)


def rejected(result: Results) -> Flags:
    """Mark the samples (T,) that have rejected steps between the sample before and themselves."""
    count = result["diagnostics/rejected_steps"]
    is_rejected: Flags = np.diff(count, prepend=count[:1]) > 0
    return is_rejected


def per_step(result: Results, path: str) -> Array:
    """The increase of a counter over that of the steps since the sample before (T); NaN where no step ended."""
    growth, steps = (np.diff(result[name], prepend=np.nan) for name in (path, "diagnostics/steps"))
    rate: Array = np.divide(growth, steps, out=np.full(len(steps), np.nan), where=steps > 0)
    return rate


def _filled_forward(rates: Array) -> Array:
    """Replace each NaN by the last number before it, where there is one."""
    last = np.maximum.accumulate(np.where(np.isnan(rates), 0, np.arange(len(rates))))
    return rates[last]


def _scale(axis: Axes, sizes: Array) -> None:
    positive = sizes[sizes > 0]
    if len(positive) and positive.max() > WIDE * positive.min():
        axis.set_yscale("log")
    else:
        _from_zero(axis)


def _from_zero(axis: Axes) -> None:
    """Set the limits a little beyond zero and the top, so that lines there are fully visible."""
    high = 1.05 * axis.get_ylim()[1]
    axis.set_ylim(-0.04 * high, high)


# --- The violation of the constraints over time -----------------------------------------------------------------------
# The largest, position and velocity, and that of each joint.


ROWS = (
    ("diagnostics/position_violation", r"$|C|_\infty$ (m or rad)"),
    ("diagnostics/velocity_violation", r"$|\dot{C}|_\infty$ (m/s or rad/s)"),
)
#: The attribute of a joint, its unit, and its name in the small print where no joint violates it.
VIOLATIONS = (("violation_length", "m", "lengths"), ("violation_angle", "rad", "angles"))


@styled
def draw_violation(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw two panels with logarithmic axes and a line for each result."""
    figure, axes = panels.panels(2, height=2.1)
    for axis, (path, name) in zip(axes[:, 0], ROWS, strict=True):
        for index, (result, label) in enumerate(zip(results, labels, strict=True)):
            panels.plot_log(axis, result.abscissa, result[path], label, index)
        axis.set_ylabel(name)
    return panels.finish(figure, with_legend=len(results) > 1)


@styled
def draw_joints(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw violations on logarithmic axes. One result has a row of lengths and one of angles, with a line for each
    joint. Several have a row for each joint. The small print names violations that are always zero."""
    single = len(results) == 1
    names, remark = fitted_text.largest_joints(
        results, "joints/violation", fitted_text.MAX_LINES if single else MAX_ROWS
    )
    drawn = [entry for entry in VIOLATIONS if _is_seen(results, names, entry[0])] or [VIOLATIONS[0]]
    zero = [f"{what}: no violation above 10⁻¹⁷" for entry in VIOLATIONS if entry not in drawn for what in entry[2:]]
    grid = (len(drawn), 1) if single else (len(names), len(drawn))
    figure, axes = panels.panels(*grid, height=2.1 if single else 1.75, share=not single and "col")
    for place, (member, unit, _) in enumerate(drawn):
        for row, name in enumerate(names):
            axis = axes[place, 0] if single else axes[row, place]
            for index, (result, label) in enumerate(zip(results, labels, strict=True)):
                if name in result.names("joints"):
                    text, look = (name, row) if single else (label, index)
                    panels.plot_log(axis, result.abscissa, getattr(result.joint(name), member), text, look)
            panels.name(axis, "violation" if single else f"{name}: violation", unit)
    return panels.finish(figure, remark="; ".join(filter(None, [remark, *zero])))


def _is_seen(results: Sequence[Results], names: Sequence[str], member: str) -> bool:
    """Whether the violation of any joint is ever above the floor."""
    for result in results:
        for name in names:
            if name in result.names("joints"):
                values = getattr(result.joint(name), member)
                if np.any(np.abs(values) > panels.FLOOR):
                    return True
    return False


# --- The error of each marker of a certified run over time, with its uncertainty --------------------------------------


#: An uncertainty below this part of the error is not visible.
SEEN = 0.05
BAND = "band: what the error may be at most"


@styled
def draw_trust(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw a row for each marker with a line for each certified result. The band above a line is where the true error
    may be."""
    certified = [(result, result.trust, label) for result, label in zip(results, labels, strict=True) if result.trust]
    names = list(dict.fromkeys(name for result, trust, _ in certified for name in _names(result, trust)))
    drawn = names[:MAX_ROWS]
    remarks = (
        [cut] if (cut := fitted_text.note("markers", len(drawn), len(names), "choose others with --marker")) else []
    )
    figure, axes = panels.panels(len(drawn), height=2.1)
    for axis, name in zip(axes[:, 0], drawn, strict=True):
        for index, (result, trust, label) in enumerate(certified):
            if name in _names(result, trust):
                k = trust.names.index(name)
                rows = (trust.time >= result.time[0]) & (trust.time <= result.time[-1])
                time, error, unsure = trust.time[rows], trust.error[rows, k], trust.uncertainty[rows, k]
                known = np.where(error > panels.FLOOR, error, np.nan)
                panels.plot_log(axis, time, known, label, index)
                if np.nanmax(unsure / known, initial=0.0) > SEEN:
                    axis.fill_between(time, known, known + unsure, color=line(index)["color"], alpha=0.2, linewidth=0)
                    remarks = list(dict.fromkeys([BAND, *remarks]))
        panels.name(axis, f"error of {name}", "m")
    return panels.finish(figure, remark="; ".join(remarks), with_legend=len(certified) > 1)


def _names(result: Results, trust: Trust) -> list[str]:
    """The points to draw; of markers, those that the results have kept."""
    chosen = result.names("markers") or trust.names
    return [name for name in trust.names if name in chosen]


# --- Ratios and transmission angles -----------------------------------------------------------------------------------
# Velocity ratios and mechanical advantages of joint coordinates to an input, and transmission angles.


#: A mechanical advantage is cut off at this multiple of its median, because it is infinite at a dead centre.
CUT = 20.0


@dataclass(frozen=True)
class _Ratio:
    """A reader of a ratio (T,) of a coordinate to the input; None where a result lacks either."""

    output: str
    forces: bool

    def __call__(self, result: Results) -> Array | None:
        if self.output not in result.names("coordinates") or result.shown_over is None:
            return None
        pair = result.coordinate(self.output).speed, result.shown_over.rate
        if not self.forces:
            return velocity_ratio(*pair)
        advantage = mechanical_advantage(*pair)
        finite = np.isfinite(advantage)
        most = CUT * float(np.median(np.abs(advantage[finite]))) if finite.any() else np.inf
        return np.where(np.abs(advantage) <= most, advantage, np.nan)


@styled
def draw_ratios(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw a row for each joint coordinate: its velocity ratio to the input, and the mechanical advantage."""
    over = next(result.shown_over for result in results if result.shown_over is not None)
    names = [name for name in fitted_text.all_names(results, "coordinates") if name != over.name]
    groups = rows.fitting([_ratio_group(results, name, over.unit) for name in names], results)
    cut = fitted_text.note("coordinates", len(groups), len(names), "choose others with --joint")
    said = f"gaps of the mechanical advantage: more than {CUT:g} times its median, near a dead centre"
    return rows.draw_rows(results, labels, groups, "; ".join(filter(None, [cut, said])))


def _ratio_group(results: Sequence[Results], name: str, input_unit: str) -> PanelGroup:
    unit = next(result.coordinate(name).unit for result in results if name in result.names("coordinates"))
    alike = unit == input_unit
    of_speeds, of_forces = ("", "") if alike else ("m/rad", "rad/m") if unit == "m" else ("rad/m", "m/rad")
    ratio = PanelQuantity(f"{name}: velocity ratio", AxisUnit(of_speeds, ""), _Ratio(name, False), held=False)
    advantage = PanelQuantity("mechanical advantage", AxisUnit(of_forces, ""), _Ratio(name, True), held=False)
    return PanelGroup(((ratio, advantage),))


@dataclass(frozen=True)
class _Angle:
    """A reader of a transmission angle (T,); None where a result lacks one of the markers."""

    corners: tuple[str, str, str]

    def __call__(self, result: Results) -> Array | None:
        if not set(self.corners) <= set(result.names("markers")):
            return None
        return transmission_angle(*(result.marker(name).position for name in self.corners))


@styled
def draw_transmission(
    results: Sequence[Results], labels: Sequence[str], corners: Sequence[tuple[str, str, str]]
) -> Figure:
    """Draw a row for each transmission angle, in degrees from 0 to 90."""
    groups = [
        PanelGroup(
            (
                (
                    PanelQuantity(
                        f"at {corner[1]}, to {corner[0]} and {corner[2]}", DEGREES.value, _Angle(corner), held=False
                    ),
                ),
            )
        )
        for corner in corners
    ]
    figure = rows.draw_rows(results, labels, rows.fitting(groups, results))
    for axis in figure.axes:
        axis.set_ylim(0.0, 90.0)
        axis.set_yticks([0.0, 30.0, 60.0, 90.0])
    small_print(figure, "transmission angle: 90° is best; below about 40° a mechanism tends to jam")
    return figure
