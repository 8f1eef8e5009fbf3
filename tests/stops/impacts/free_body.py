"""A body that nothing holds, for what happens at its stops alone."""

from __future__ import annotations


class Free:
    """A body in coordinates in which its kinetic energy is ½|x|²."""

    def __init__(self, speeds):
        self.speeds = speeds

    def changed(self, x):
        return x

    def gained(self, x):
        return float(x @ (self.speeds + 0.5 * x))
