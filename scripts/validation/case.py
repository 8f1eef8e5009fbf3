"""Mechanisms that others computed: their scenes, their results, and the tolerances that these deserve.

The scenes stand in `mechanisms/validation`, the tables of results in `tests/data/validation`, under the same names. The
first line of a table says who computed it, the second has its columns (see `quantities`). They were made of MSC Adams'
results for Project Chrono's tests of joints, of Dymola's for the Modelica Standard Library, of the IFToMM library of
benchmark problems, and of the Test Set for Initial Value Problem Solvers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from string import ascii_uppercase

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "mechanisms" / "validation"
TABLES = ROOT / "tests" / "data" / "validation"
#: What joints of the n-four-bars are called in their order: A, B, .., Z, AA, AB, .., ZZ.
LETTERS = (*ascii_uppercase, *(a + b for a in ascii_uppercase for b in ascii_uppercase))


@dataclass(frozen=True)
class Case:
    """A mechanism with results that others computed.

    `tolerances` are absolute, by quantity; `relative` those of the other quantities, as a part of each column's largest
    magnitude. `short` in s is how far the projection methods are run that are not the default, with the settings
    `quick`. `loops` are the joints that close planar loops of spatial revolutes, whose rows are redundant in space.
    """

    name: str
    tolerances: Mapping[str, float]
    relative: Mapping[str, float] = field(default_factory=dict)
    short: float = 0.5
    quick: Mapping[str, str] = field(default_factory=dict)
    loops: tuple[str, ...] = ()

    @property
    def scene(self) -> Path:
        """Its scene file."""
        return SCENES / f"{self.name}.yaml"

    @property
    def table(self) -> Path:
        """Its reference table: a line on the origin, a header, rows."""
        return TABLES / f"{self.name}.csv"

    @property
    def origin(self) -> str:
        """Who computed the table."""
        with self.table.open(encoding="utf-8") as file:
            return file.readline().removeprefix("#").strip()


#: Of MSC Adams' pendulums on one joint each. Their tables have six digits.
ON_A_JOINT = {
    "position": 1e-3,
    "velocity": 1e-3,
    "orientation": 1e-3,
    "global_angular_velocity": 1e-3,
    "acceleration": 1e-2,
    "global_angular_acceleration": 1e-2,
    "force_on_first": 1e-2,
    "torque_on_first": 1e-2,
}
UNIVERSAL = {"position": 8.5e-4, "velocity": 3e-3, "force_on_first": 1.4e-2, "torque_on_first": 1e-2}
SPEED = {"speed": 1e-3}


def n_four_bar(n: int, short: float = 0.5, **quick: str) -> Case:
    """IFToMM's problem A02 with n loops, each closed by the second joint of its coupler."""
    loops = LETTERS[n + 2 : 3 * n + 2 : 2]
    return Case(f"iftomm_n_four_bar_{n}", {"position": 2e-8}, short=short, quick=quick, loops=loops)


_CASES = (
    Case("adams_revolute", {}, ON_A_JOINT),
    Case("adams_spherical", {}, ON_A_JOINT),
    # Baumgarte's feedback lets round-off grow up to the tolerance. What does not turn is compared to 1e-8 rad/s², the
    # tolerance times the square of its gains.
    Case("adams_prismatic", {}, ON_A_JOINT, quick={"tolerance": "1e-11"}),
    Case("adams_cylindrical", {}, ON_A_JOINT),
    Case("adams_distance", {"position": 2e-5}, ON_A_JOINT),
    Case("adams_universal", UNIVERSAL, ON_A_JOINT),
    Case("adams_universal_tilted", UNIVERSAL, ON_A_JOINT),
    Case("dymola_rssp", {"angle": 9e-4}, SPEED, short=0.3),
    Case(
        "dymola_spherical_double_pendulum",
        {"orientation": 1e-4, "angular_velocity": 1e-3},
        short=0.3,
        quick={"output_step": "6 ms"},
    ),
    Case(
        "dymola_universal_torque",
        {"angle_1": 2e-5, "angle_2": 2e-5},
        {"speed_1": 1e-3, "speed_2": 1e-3},
        short=0.3,
    ),
    Case("dymola_pendulum", {"angle": 5e-6}, SPEED),
    Case("dymola_planar_four_bar", {"angle": 7e-4}, SPEED, short=0.3, loops=("D",)),
    Case("iftomm_pendulum", {"position": 7.1e-7}, short=1.0),
    Case("iftomm_slider_crank", {"position": 1.31e-5}, {"angle": 1e-3}, short=0.3),
    # The source's errors are those of an equation of index 3: 1e-10 of the angles, 1e-8 of the speeds, 1e-6 of the
    # accelerations.
    Case(
        "andrews_squeezer",
        {"angle": 2e-9},
        {"angular_velocity": 1e-7, "angular_acceleration": 1e-5},
        short=0.03,
        quick={"tolerance": "1.0e-10"},
        loops=("C", "F", "I"),
    ),
    n_four_bar(1),
    n_four_bar(2),
    n_four_bar(40, short=0.05, integrator="dop853", step="25 ms"),
)
#: Every case by name.
CASES: Mapping[str, Case] = {case.name: case for case in _CASES}
