"""A spatial four-bar: two levers on axes that are skew, and a rod between balls at their ends (RSSR), in closed form.

The crank turns about -y at the origin; its end is a (cos θ, 0, sin θ). The lever turns about an axis that is tilted by
`twist` about x, at the point (1, y, z) in m; its end is b (cos ψ e1 + sin ψ e2) from there."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.studies.synthesis.linkage import Numbers

LENGTHS = ("crank_length", "rod_length", "lever_length")


class SpatialFourBar:
    """A spatial four-bar, for functions only: the rod may turn about its axis, so that its points have no unique
    path."""

    sides = ("side",)

    def angle(self, p: Numbers, crank: Array) -> Array:
        """The lever's angle ψ (B, N) at crank angles; NaN where the rod is too long or too short."""
        a, rod, b = (p[name] for name in LENGTHS)
        x, y, z = a * np.cos(crank) - 1.0, -p["dy"], a * np.sin(crank) - p["dz"]
        across = y * np.sin(p["twist"]) + z * np.cos(p["twist"])
        wanted = (x**2 + y**2 + z**2 + b**2 - rod**2) / (2.0 * b)
        with np.errstate(all="ignore"):
            return np.asarray(np.arctan2(across, x) + p["side"] * np.arccos(wanted / np.hypot(x, across)))

    def bounds(self) -> dict[str, tuple[float, float]]:
        """The bounds of its numbers; the axes are 1 m apart along x."""
        near = dict.fromkeys(LENGTHS, (0.05, 3.0))
        return {**near, "dy": (-2.0, 2.0), "dz": (-2.0, 2.0), "twist": (-np.pi, np.pi), "start": (-np.pi, np.pi)}
