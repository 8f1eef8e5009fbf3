"""`ScenePart`: keys and values of one item of a scene, as a mapping; its classes know which keys there are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from inspect import Parameter, Signature
from typing import Any, ClassVar

from mbproj.scene.text.suggestions import choose_from


class ScenePart(Mapping[str, Any]):
    """A mapping of the keys that were given. Raises TypeError for a key that it does not have, or lacks."""

    #: What its type is called in a scene; "" where it needs no type.
    type: ClassVar[str] = ""
    #: Its keys, and those that must be given.
    keys_of_scene: ClassVar[tuple[str, ...]] = ()
    required: ClassVar[tuple[str, ...]] = ()
    __slots__ = ("_values",)

    def __init__(self, **values: Any) -> None:
        name = type(self).__name__
        for key in values:
            if key not in self.keys_of_scene:
                raise TypeError(f"{name}() has no argument '{key}'; {choose_from(key, self.keys_of_scene)}")
        for key in self.required:
            if values.get(key) is None:
                raise TypeError(f"{name}() lacks the argument '{key}'")
        given = {key: value for key, value in values.items() if value is not None}
        self._values = {"type": self.type, **given} if self.type else given

    def __getitem__(self, key: str) -> Any:
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        given = ", ".join(
            f"{key}={value!r}" for key, value in self._values.items() if not (key == "type" and self.type)
        )
        return f"{type(self).__name__}({given})"


def signature_of(keys: Mapping[str, str], required: tuple[str, ...]) -> Signature:
    """The arguments of a class by their annotations, those that are required first."""
    ordered = sorted(keys, key=lambda key: key not in required)
    return Signature(
        [
            Parameter(
                key,
                Parameter.KEYWORD_ONLY,
                default=Parameter.empty if key in required else None,
                annotation=keys[key] if key in required else f"{keys[key]} | None",
            )
            for key in ordered
        ]
    )
