"""Recorded quantities of stops and of dry frictions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from types import MappingProxyType

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.gaps import gap_rates, gaps, pressing
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.dynamics.observe.samples import Samples
from mbproj.model.frictions import Frictions
from mbproj.model.stops import Stops
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class ContactsSeen:
    """The quantities of stops and frictions at T samples, by the paths of their datasets."""

    system: System
    samples: Samples
    pose: Pose
    twist: Twist

    def __getitem__(self, path: str) -> Numbers:
        """Return the values (T, S) of stops or (T, K) of frictions. Raises KeyError for a path that is not in
        `contact_paths`."""
        stops, frictions = self.system.stops, self.system.frictions
        if stops is not None and path in OF_STOPS:
            return OF_STOPS[path](self, stops)
        if frictions is not None and path in OF_FRICTIONS:
            return OF_FRICTIONS[path](self, frictions)
        raise KeyError(path)

    def pushes(self, stops: Stops) -> Numbers:
        """Return the push of each stop, (T, S), from the run. For a state at rest it follows from the gaps of compliant
        stops."""
        if self.samples.press is not None:
            return self.samples.press()
        gap = self["stops/gap"]
        return pressing(stops, np.zeros(stops.size), gap, np.zeros_like(gap))

    @cached_property
    def rubs(self) -> tuple[Array, Array]:
        """The force and the state of each dry friction, (T, K), from the run; 0 for a state at rest."""
        if self.samples.rub is not None:
            return self.samples.rub()
        none = np.zeros((len(self.samples.t), len(self.system.names.frictions)))
        return none, none


def contact_paths(system: System) -> tuple[str, ...]:
    """Return the paths of the datasets of stops and frictions that a mechanism has."""
    stops = OF_STOPS if system.stops is not None else ()
    return (*stops, *(OF_FRICTIONS if system.frictions is not None else ()))


#: The datasets of stops.
OF_STOPS: Mapping[str, Callable[[ContactsSeen, Stops], Numbers]] = MappingProxyType(
    {
        "stops/gap": lambda seen, stops: gaps(stops, seen.pose, seen.samples.turns),
        "stops/rate": lambda seen, stops: gap_rates(stops, seen.pose, seen.twist),
        "stops/force": lambda seen, stops: seen.pushes(stops),
    }
)

#: The datasets of dry frictions that can stick.
OF_FRICTIONS: Mapping[str, Callable[[ContactsSeen, Frictions], Numbers]] = MappingProxyType(
    {
        "friction/rate": lambda seen, frictions: set_velocity(frictions.coordinates, seen.pose, seen.twist),
        "friction/force": lambda seen, _: seen.rubs[0],
        "friction/state": lambda seen, _: seen.rubs[1],
        "friction/dissipation": lambda seen, _: seen.samples.work[:, 2:],
    }
)
