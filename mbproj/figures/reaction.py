"""The reaction of a joint for a picture: its size or components, and which of them the constraints determine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.results import Results


@dataclass(frozen=True)
class JointReaction:
    """A joint's "reaction_force" or "reaction_torque", with marks of the components that are unique in all results."""

    joint: str
    member: str
    unique: tuple[bool, bool, bool]

    @classmethod
    def of(cls, results: Sequence[Results], joint: str, member: str) -> JointReaction:
        """The reaction of a joint, with uniqueness as these results mark it."""
        unique = np.ones(3, dtype=bool)
        for result in results:
            marks = result.constant(f"joints/{member}_unique")
            if marks is not None and joint in result.names("joints"):
                unique &= marks[result.names("joints").index(joint)]
        first, second, third = unique.tolist()
        return cls(joint, member, (first, second, third))

    def components(self, result: Results) -> Array | None:
        """All three components (T, 3); None where the result has no such joint."""
        if self.joint not in result.names("joints"):
            return None
        values: Array = getattr(result.joint(self.joint), self.member)
        return values

    def vector(self, result: Results) -> Array | None:
        """The unique components (T, 3) with zeros for the others; all components where none is unique."""
        values = self.components(result)
        return values if values is None or not any(self.unique) else np.where(self.unique, values, 0.0)

    def size(self, result: Results) -> Array | None:
        """The length (T) of `vector`."""
        vector = self.vector(result)
        return None if vector is None else np.linalg.norm(vector, axis=1)

    def largest(self, results: Sequence[Results]) -> float:
        """The largest component in all results."""
        found = [values for result in results if (values := self.components(result)) is not None]
        of = [np.max(np.abs(values), where=np.isfinite(values), initial=0.0) for values in found]
        return float(max(of, default=0.0))
