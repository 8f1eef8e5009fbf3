"""Fields that are numbers, or functions of the time and of what changes in a run."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.scene.expressions.syntax_tree import names
from mbproj.scene.fields.fields import Field, Schema
from mbproj.scene.fields.functions import Function, channels_in, is_misspelt
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node, ScalarNode


@dataclass(frozen=True)
class Varying(Field[float | Program]):
    """A `number`, or an expression in its unit that names t, signals, states or coordinates; bounds are of numbers."""

    number: Number

    @property
    def expects(self) -> str:
        return f"{self.number.expects} or an expression of t and signals"

    @property
    def unit(self) -> str | None:
        """The SI unit it is in, as `Number` has it."""
        return self.number.unit

    def read(self, node: Node, path: KeyPath, reading: Reading) -> float | Program | None:
        tree = reading.parse(node) if isinstance(node, ScalarNode) and node.text.strip() else None
        if isinstance(node, ScalarNode) and tree is not None:
            changes = "t" in names(tree) or channels_in(tree, {}, reading)
            if changes or is_misspelt(tree, reading.names.keys(), node, reading):
                return Function(self.unit, names_channels=True).read(node, path, reading) if changes else None
        return self.number.read(node, path, reading)

    def schema(self) -> Schema:
        return self.number.schema()
