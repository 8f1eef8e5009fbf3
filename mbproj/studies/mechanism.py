"""A scene made ready to be run many times: compiled and assembled once."""

from __future__ import annotations

from dataclasses import dataclass

from mbproj.dynamics import State, assemble
from mbproj.model import System, compile_system, initial_guess
from mbproj.scene.records import Scene


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A scene with its system and its consistent start. `points` are what errors are measured at: the markers' names,
    or the bodies' where the scene has no marker."""

    scene: Scene
    system: System
    state: State

    @classmethod
    def of(cls, scene: Scene) -> Mechanism:
        """Compiles and assembles. Raises InputError where the mechanism cannot be assembled."""
        system = compile_system(scene)
        return cls(scene, system, assemble(system, initial_guess(scene, system)))

    @property
    def points(self) -> tuple[str, ...]:
        """Names of the points, (k,)."""
        return tuple(self.system.names.markers or self.system.names.bodies)

    @property
    def kind(self) -> str:
        """What the points are: "markers" or "bodies"."""
        return "markers" if self.system.names.markers else "bodies"
