"""When joints count as closed, and how far one correction may go."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Closing:
    """Lengths are in m, or in the mechanism's own length where that is below 1 m."""

    closed_to: float = threshold(
        1e-13,
        "m, rad",
        "both",
        "the smallest default tolerance of the violation test; poses nearby are closed to it",
        "450 ε",
    )
    closed_grains: float = threshold(
        4.0,
        "ε",
        "both",
        "a row that is open by so much of its coordinates is closed to round-off; the sides of a kink in time lie "
        "so far apart",
        "sums of 4 numbers",
    )
    paper_tolerance: float = threshold(
        1e-12, "kg m²", "both", "the default of the paper's test ΔqᵀMΔq", "paper, sect. 5"
    )
    round_off_grains: float = threshold(
        64.0,
        "ε",
        "both",
        "a violation of so many ε of a row's coordinates, or energy of its terms, may be round-off; events nearer "
        "in ε of time are one",
        "tests/projection/test_schedule.py: with 1, projections do not end at round-off",
    )
    slow: float = threshold(
        0.1, "1", "kernel", "a pass that leaves a larger part asks for a new factor", "simplified Newton"
    )
    widest_turn: float = threshold(
        0.5,
        "rad",
        "both",
        "no correction turns a body by more; a motion moves by no more in a part of a short move",
        "Conn, Gould & Toint 2000, sect. 7; 16 turns in 2 ms: parts of 6.6 rad do not close in full",
    )
    tighter: float = threshold(
        0.25,
        "1",
        "both",
        "from one trial to the next turns are limited to this part",
        "tests/projection/test_damping.py: uneven chains do not close in 12 passes with 0.5 and `stiffer` 10",
    )
    stiffer: float = threshold(
        100.0,
        "1",
        "both",
        "the moment of a body that turns too far grows by this, times how much too far",
        "tests/projection/test_damping.py: uneven chains do not close in 12 passes with 10 and `tighter` 0.5",
    )
    open_limit: float = threshold(
        1e-6,
        "length, rad",
        "both",
        "no run goes on with a larger violation after a failed projection",
        "no case: tests/projection/test_fallback.py holds with 1e-12 too",
    )
    lost_limit: float = threshold(
        1.0, "length, rad", "both", "no run goes on with a larger violation", "the mechanism itself"
    )
    assembled: float = threshold(
        1e-10,
        "length, rad",
        "numpy",
        "a pose with a smaller violation is assembled",
        "poses of tests/dynamics/test_assembly.py close to 1e-15",
    )
    large: int = threshold(
        100,
        "bodies",
        "numpy",
        "dense factors of more bodies are not made to assemble, to diagnose, for modes, or in a plane",
        "singular values of the rows of 100 bodies: 0.1 s, of 500: 16 s",
    )
