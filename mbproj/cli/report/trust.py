"""The trust horizons of a run, as a table and for JSON."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbproj.arrays import Array
    from mbproj.results.trust import Trust

#: The most rows of the table.
MAX_POINTS = 8


def as_numbers(trust: Trust) -> dict[str, Any]:
    """The horizons as a dictionary for JSON. A time that is never reached is infinite; an unknown growth is NaN."""
    times = ("horizon", "horizon_low", "horizon_high")
    points = {
        name: {
            **{key: getattr(trust, key)[k] for key in times},
            **{key: getattr(trust, key)[k] for key in ("growth_rate", "growth_power")},
            "growth_law": trust.growth_law[k] or None,
            "largest_error": _largest(trust.error[:, k]),
            "largest_uncertainty": _largest(trust.uncertainty[:, k]),
        }
        for k, name in enumerate(trust.names)
    }
    words = {"solution": trust.solution, "remark": trust.remark or None}
    return {**words, "limits": trust.limits, "points": points}


def lines_on(trust: Trust) -> Iterator[str]:
    """Yield a table of the times at which errors exceed limits, a row for each point. Limits that no error reaches are
    left out."""
    if not trust.solution and trust.remark:
        yield f"  how far to trust it: {trust.remark}"
        return
    yield f"  how far to trust it, by {trust.solution}"
    limits = enumerate(trust.limits.tolist())
    reached = [(column, limit) for column, limit in limits if trust.horizon_low[:, column].min() < inf]
    points = trust.names[:MAX_POINTS]
    heads = [_limit_text(limit) for _, limit in reached]
    rows = [
        [*(_time(trust, k, column) for column, _ in reached), f"{_largest(trust.error[:, k]):.1e} m", _growth(trust, k)]
        for k in range(len(points))
    ]
    table = [["error exceeds", *heads, "largest", "grows as"]]
    table += [[name, *row] for name, row in zip(points, rows, strict=True)]
    widths = [max(len(row[column]) for row in table) for column in range(len(table[0]))]
    for row in table:
        yield "    " + "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
    if len(trust.names) > MAX_POINTS:
        yield f"    the first {MAX_POINTS} of {len(trust.names)}: the results file has all"
    if trust.remark:
        yield f"    {trust.remark}"


def _limit_text(limit: float) -> str:
    """A limit in m as text: "1e-4 m", "2.5 m"."""
    mantissa, _, power = f"{limit:.2e}".partition("e")
    return f"{limit:.3g} m" if limit >= 1.0 else f"{float(mantissa):g}e{int(power)} m"


def _time(trust: Trust, k: int, column: int) -> str:
    """A time in s as text, with its uncertainty: "0.95 s", "4.1-4.7 s", "4.1 s or later", "-" where it never comes."""
    low, high = trust.horizon_low[k, column], trust.horizon_high[k, column]
    if not isfinite(low):
        return "-"
    if not isfinite(high):
        return f"{low:.3g} s or later"
    return f"{low:.3g} s" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g}-{high:.3g} s"


def _growth(trust: Trust, k: int) -> str:
    laws = {"exponential": f"exp({trust.growth_rate[k]:.2g} t)", "power": f"t^{trust.growth_power[k]:.2g}"}
    return laws.get(trust.growth_law[k], "-")


def _largest(values: Array) -> float:
    """The largest known value."""
    return max((value for value in values.tolist() if isfinite(value)), default=0.0)
